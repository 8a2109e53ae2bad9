#include "contact/gap_planar.hpp"

#include "contact/gap_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

const auto planar_rates_of = [](const PlanarGap& gap) {
    return [gap](const Pair& x, const ContactPoint& c) { return planar_rates(x[0], x[1], gap, c); };
};

TEST(GapPlanar, DerivativesAndBalance) {
    std::mt19937 rng(21);
    for (const double radius : {0.0, 0.7}) {
        for (int k = 0; k < 10; ++k) {
            const PlanarGap gap{random_vector(rng), random_vector(rng).normalized(), random_vector(rng), 0.2,
                                radius};
            Pair m = random_pair(rng);
            const Vec3 z = m[0].A * gap.axis_a;
            place_b(m, gap.point_b,
                    point_position(m[0], gap.point_a) + 0.5 * z +
                        0.4 * z.cross(random_vector(rng)).normalized());
            check_contact(
                m, [&](const Pair& x) { return planar_point(x[0], x[1], gap); }, planar_rates_of(gap));
        }
    }
}

TEST(GapPlanar, ByHand) {
    const PlanarGap gap{Vec3::Zero(), Vec3::UnitX(), Vec3::Zero(), 1e-3, 0.02};
    BodyMotion a, b;
    b.r = Vec3(0.3, -1.8e-3, 2.4e-3);
    const ContactPoint c = planar_point(a, b, gap);
    EXPECT_NEAR(c.depth, 2e-3, 1e-16);
    EXPECT_LT((c.n - Vec3(0, -0.6, 0.8)).norm(), 1e-14);
    EXPECT_LT((c.p - Vec3(0.3, -0.012, 0.016)).norm(), 1e-16);
    b.r = Vec3(0.3, 0, 0);
    const ContactPoint centred = planar_point(a, b, gap);
    EXPECT_EQ(centred.depth, -1e-3);
    EXPECT_TRUE(finite(centred));
    EXPECT_TRUE(finite(planar_rates(a, b, gap, centred)));
}

TEST(GapTwoEnd, DerivativesAndBalance) {
    std::mt19937 rng(22);
    for (int k = 0; k < 20; ++k) {
        const TwoEndGap gap{random_vector(rng),
                            random_vector(rng).normalized(),
                            random_vector(rng),
                            random_vector(rng).normalized(),
                            1.5,
                            0.2,
                            k % 2 * 0.7};
        Pair m = random_pair(rng);
        point_axis_b(m, gap.axis_b, (m[0].A * gap.axis_a + 0.5 * random_vector(rng)).normalized());
        place_b(m, gap.point_b, point_position(m[0], gap.point_a) + 0.6 * random_vector(rng));
        for (int end = 0; end < 2; ++end) {
            if (two_end_points(m[0], m[1], gap)[end].depth + gap.clearance < 0.2)
                continue; // too near the axis for the differences
            check_contact(
                m, [&](const Pair& x) { return two_end_points(x[0], x[1], gap)[end]; },
                [&](const Pair& x, const ContactPoint& c) { return two_end_rates(x[0], x[1], gap, end, c); });
        }
    }
}

// The four states of AU 19, axis X, 40 mm long, clearance 0.5 mm.
TEST(GapTwoEnd, NoContactPointTwoPointsLine) {
    const TwoEndGap gap{Vec3::Zero(), Vec3::UnitX(), Vec3::Zero(), Vec3::UnitX(), 0.04, 5e-4, 0.01};
    BodyMotion a, b;
    const auto pose = [&](double z, double slope) {
        b.r = Vec3(0, 0, z);
        b.p = turned(Vec4(1, 0, 0, 0), Vec3(0, -std::atan(slope), 0));
        b.A = rotation(b.p);
        return two_end_points(a, b, gap);
    };
    auto c = pose(0, 0); // free flight, centred
    EXPECT_EQ(c[0].depth, -5e-4);
    EXPECT_TRUE(finite(c[0]) && finite(two_end_rates(a, b, gap, 0, c[0])));
    c = pose(3e-4, 0.02); // up by 0.7 mm at the end +, down by 0.1 mm at the end -
    const double cosine = std::cos(std::atan(0.02));
    EXPECT_NEAR(c[0].depth, 1e-4 * cosine - 5e-4, 1e-17);
    EXPECT_NEAR(c[1].depth, 7e-4 * cosine - 5e-4, 1e-17);
    EXPECT_GT(c[1].n.z(), 0.99);
    EXPECT_LT(c[0].n.z(), -0.99);
    c = pose(0, 0.03); // two points, opposite
    EXPECT_NEAR(c[0].depth, 6e-4 * std::cos(std::atan(0.03)) - 5e-4, 1e-17);
    EXPECT_NEAR(c[1].depth, c[0].depth, 1e-17);
    EXPECT_LT((c[0].n + c[1].n).norm(), 1e-14);
    c = pose(6e-4, 0); // line
    EXPECT_NEAR(c[0].depth, 1e-4, 1e-17);
    EXPECT_NEAR(c[1].depth, 1e-4, 1e-17);
    EXPECT_LT((c[0].p - Vec3(-0.02, 0, 0.01)).norm(), 1e-15);
}

} // namespace
} // namespace gudgeon
