#include "contact/gap_sphere.hpp"

#include "contact/gap_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

TEST(GapSphere, DerivativesAndBalance) {
    std::mt19937 rng(11);
    for (const double radius : {0.0, 0.7}) {
        for (int k = 0; k < 10; ++k) {
            const SphereGap gap{random_vector(rng), random_vector(rng), 0.2, radius};
            Pair m = random_pair(rng);
            place_b(m, gap.point_b,
                    point_position(m[0], gap.point_a) + 0.4 * random_vector(rng).normalized());
            check_contact(
                m, [&](const Pair& x) { return sphere_point(x[0], x[1], gap); },
                [&](const Pair& x, const ContactPoint& c) { return sphere_rates(x[0], x[1], gap, c); });
        }
    }
}

// A ball 3 mm along (0, 3, 4) off the centre pushes the socket that way.
TEST(GapSphere, ByHand) {
    const SphereGap gap{Vec3(1, 0, 0), Vec3(0, 0, 0), 1e-3, 0.02};
    BodyMotion a, b;
    b.r = Vec3(1, 1.8e-3, 2.4e-3);
    const ContactPoint c = sphere_point(a, b, gap);
    EXPECT_NEAR(c.depth, 2e-3, 1e-16);
    EXPECT_LT((c.n - Vec3(0, 0.6, 0.8)).norm(), 1e-14);
    EXPECT_LT((c.p - Vec3(1, 0.012, 0.016)).norm(), 1e-16);
    b.v = Vec3(0, 0.6, 0.8);
    EXPECT_NEAR(depth_gradient(a, b, c).times(a, b)(0), 1, 1e-14);
}

TEST(GapSphere, CentredBallIsSafe) {
    const SphereGap gap{Vec3::Zero(), Vec3::Zero(), 1e-4, 0.01};
    const BodyMotion a, b;
    const ContactPoint c = sphere_point(a, b, gap);
    EXPECT_EQ(c.depth, -1e-4);
    EXPECT_EQ(c.n, Vec3::Zero());
    EXPECT_TRUE(finite(sphere_rates(a, b, gap, c)));
}

} // namespace
} // namespace gudgeon
