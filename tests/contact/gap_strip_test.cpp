#include "contact/gap_strip.hpp"

#include "contact/gap_tools.hpp"

#include <vector>

namespace gudgeon {
namespace {

using namespace test;

double axis_distance(const CylinderPose& pose, const Vec3& p) {
    const Vec3 d = p - pose.centre_b;
    return (d - pose.s.dot(d) * pose.s).norm();
}

// Local minima of the distance over the circle, nearest first: sampling, then golden section. A minimum
// shallower than 1e-7 R against its neighbourhood may be missed and is reported as -1 for the whole pose.
std::vector<double> sampled_minima(const CylinderPose& pose, double offset, double R) {
    const Vec3 x = pose.z.unitOrthogonal(), y = pose.z.cross(x), centre = pose.centre_a + offset * pose.z;
    const auto d = [&](double t) {
        return axis_distance(pose, centre + R * (std::cos(t) * x + std::sin(t) * y));
    };
    const int n = 1440;
    const double h = 2 * pi / n, golden = (std::sqrt(5.0) - 1) / 2;
    std::vector<double> samples(n), minima;
    for (int k = 0; k < n; ++k)
        samples[k] = d(k * h);
    for (int k = 0; k < n; ++k) {
        if (!(samples[k] <= samples[(k + n - 1) % n] && samples[k] < samples[(k + 1) % n]))
            continue;
        double low = (k - 1) * h, high = (k + 1) * h;
        while (high - low > 1e-9) {
            const double t1 = high - golden * (high - low), t2 = low + golden * (high - low);
            (d(t1) < d(t2) ? high : low) = d(t1) < d(t2) ? t2 : t1;
        }
        minima.push_back(d((low + high) / 2));
    }
    std::sort(minima.begin(), minima.end());
    return minima;
}

struct Case {
    CylinderPair pair;
    Pair m;
    double offset = 0, R = 1;
    CylinderPose pose() const { return cylinder_pose(m[0], m[1], pair); }
    int points(StripPoint out[2]) const {
        return strip_points(pose(), strip_frame(pose()), pair.journal_radius, offset, R, out);
    }
};

// Journal tilted by an angle, its axis displaced from the circle's centre by about `shift` radii.
Case random_case(std::mt19937& rng, double tilt, double shift) {
    Case x;
    x.pair = {random_vector(rng), random_vector(rng).normalized(), random_vector(rng),
              random_vector(rng).normalized(), 0.9};
    x.m = random_pair(rng);
    x.offset = random_vector(rng).x();
    const Vec3 z = x.m[0].A * x.pair.axis_a, across = z.cross(random_vector(rng)).normalized();
    point_axis_b(x.m, x.pair.axis_b, std::cos(tilt) * z + std::sin(tilt) * across);
    const Vec3 s = x.m[1].A * x.pair.axis_b;
    const Vec3 centre = point_position(x.m[0], x.pair.point_a) + x.offset * z;
    place_b(x.m, x.pair.point_b, centre + shift * random_vector(rng) + random_vector(rng).x() * s);
    return x;
}

// What the six columns say of the 12 coordinates: the bearing carries point and normal along.
ContactPointRates strip_rates(const BodyMotion& a, const BodyMotion& b, const CylinderPose& pose,
                              const StripPoint& c, Gradient<1>* position = nullptr) {
    const StripSlopes slopes(pose, c);
    const Gradient<6> j = relative_twist_gradient(a, b, pose.centre_a);
    const auto expanded = [&j](const auto& rows, auto& out) {
        out.ra = rows * j.ra;
        out.ta = rows * j.ta;
        out.rb = rows * j.rb;
        out.tb = rows * j.tb;
    };
    ContactPointRates rates;
    expanded(slopes.point(c), rates.p);
    expanded(slopes.normal(c), rates.n);
    rates.p.ra += Mat3::Identity();
    rates.p.ta -= skew(c.p - a.r) * a.A;
    rates.n.ta -= skew(c.n) * a.A;
    if (position)
        expanded(slopes.position(pose, c).transpose(), *position);
    return rates;
}

TEST(GapStrip, DepthAgainstSampling) {
    std::mt19937 rng(41);
    int two = 0, compared = 0;
    for (const double tilt : {0.0, 1e-9, 1e-3, 0.1, 0.6, 1.2, 1.5, 2.0, 3.0, pi})
        for (const double shift : {0.0, 1e-6, 0.1, 0.5, 2.0})
            for (int k = 0; k < 8; ++k) {
                SCOPED_TRACE(::testing::Message() << "tilt " << tilt << " shift " << shift);
                const Case x = random_case(rng, tilt, shift);
                StripPoint c[2];
                const int n = x.points(c);
                const std::vector<double> truth = sampled_minima(x.pose(), x.offset, x.R);
                if (truth.empty()) { // equally near all round
                    EXPECT_NEAR(c[0].depth, x.pair.journal_radius - axis_distance(x.pose(), c[0].p), 1e-14);
                    continue;
                }
                EXPECT_NEAR(c[0].depth, x.pair.journal_radius - truth[0], 2e-14);
                for (int i = 0; i < n; ++i) { // what a point says of itself
                    EXPECT_NEAR(axis_distance(x.pose(), c[i].p), c[i].distance, 1e-14);
                    EXPECT_NEAR((c[i].p - x.pose().centre_b).dot(x.pose().s), c[i].x, 1e-14);
                    EXPECT_NEAR((c[i].p - x.pose().centre_b - c[i].x * x.pose().s).dot(c[i].n), c[i].distance,
                                1e-14);
                    EXPECT_NEAR(c[i].n.norm(), 1, 1e-14);
                    EXPECT_NEAR(c[i].radial.dot(x.pose().z), 0, 1e-14);
                    EXPECT_LT((x.pose().centre_a + c[i].arm - c[i].p).norm(), 1e-15);
                }
                if (std::sin(tilt) < 1e-2) // all but round: several minima are rounding
                    continue;
                ++compared;
                EXPECT_EQ(n, static_cast<int>(truth.size()));
                if (n == 2 && truth.size() == 2) {
                    ++two;
                    EXPECT_NEAR(c[1].depth, x.pair.journal_radius - truth[1], 2e-14);
                }
            }
    EXPECT_GT(two, compared / 5);
    EXPECT_LT(two, compared);
}

// The distance is stationary along the circle, to rounding at every tilt: no place where one way of finding
// the point takes over from another is seen.
TEST(GapStrip, NearestPointIsStationary) {
    std::mt19937 rng(44);
    std::uniform_real_distribution<double> uniform(0, 1);
    double worst = 0;
    for (int k = 0; k < 20000; ++k) {
        const double tilt = std::pow(10, -8 * uniform(rng)), shift = std::pow(10, -3 * uniform(rng));
        const Case x = random_case(rng, uniform(rng) < 0.5 ? tilt : pi - tilt, shift);
        const CylinderPose pose = x.pose();
        const StripFrame frame = strip_frame(pose);
        StripPoint c[2];
        x.points(c);
        // in the frame of the circle: the axis passes at (q_e, q_f), the point at angle (ce, sf)
        const double ce = c[0].radial.dot(frame.e), sf = c[0].radial.dot(frame.m);
        const double w_e = ce - frame.q_e, w_f = frame.cosine * sf - frame.journal_f(x.offset);
        const double slope = -w_e * sf + w_f * frame.cosine * ce;
        const double reach = 1 + std::hypot(frame.q_e, frame.journal_f(x.offset));
        worst = std::max(worst, std::abs(slope) / reach);
    }
    EXPECT_LT(worst, 2e-15); // the search stops at 1e-15
}

// A second point nearer to the journal's axis than its radius needs the tilt that may_touch_twice() asks for.
TEST(GapStrip, SecondSideNeedsTilt) {
    std::mt19937 rng(45);
    std::uniform_real_distribution<double> uniform(0, 1);
    int twice = 0, second = 0;
    for (int k = 0; k < 50000; ++k) {
        const Case x = random_case(rng, 1.2 * uniform(rng), 0.3 * std::pow(uniform(rng), 2));
        StripPoint c[2];
        if (x.points(c) < 2)
            continue;
        ++second;
        if (c[1].depth > 0) {
            ++twice;
            ASSERT_TRUE(may_touch_twice(strip_frame(x.pose()), 0.9, x.R));
        }
    }
    EXPECT_GT(twice, 1000);
    EXPECT_GT(second, twice);
}

TEST(GapStrip, PositionSlope) {
    std::mt19937 rng(46);
    int checked = 0;
    for (const double tilt : {1e-6, 0.02, 0.5, 1.1, 2.2})
        for (int k = 0; k < 6; ++k) {
            const Case x = random_case(rng, tilt, 0.6);
            StripPoint c[2];
            x.points(c);
            const StripSlopes slopes(x.pose(), c[0]);
            if (slopes.g < 0.25 || c[0].distance < 0.2)
                continue;
            ++checked;
            // with a at rest the columns of b alone give displacement and turn at P_a
            const Mat3 A = x.m[1].A;
            const Vec3 lever = x.pose().centre_a - x.m[1].r;
            const MatX truth = jacobian(
                x.m,
                [&](const Pair& m) {
                    const CylinderPose pose = cylinder_pose(m[0], m[1], x.pair);
                    StripPoint at[2];
                    strip_points(pose, strip_frame(pose), 0.9, x.offset, x.R, at);
                    return MatX(StripSlopes(pose, at[0]).position(pose, at[0]));
                },
                moved);
            Mat6 six;
            six.leftCols<3>() = truth.middleCols<3>(6);
            six.rightCols<3>() =
                truth.middleCols<3>(9) * A.transpose() + truth.middleCols<3>(6) * skew(lever);
            EXPECT_LT((slopes.position_slope(x.pose(), c[0]) - six).cwiseAbs().maxCoeff(),
                      1e-8 * (1 + six.cwiseAbs().maxCoeff()));
        }
    EXPECT_GT(checked, 15);
}

TEST(GapStrip, DerivativesAndBalance) {
    std::mt19937 rng(42);
    int checked = 0;
    for (const double tilt : {0.0, 1e-6, 0.02, 0.5, 1.1, 2.2, 3.1, pi})
        for (int k = 0; k < 12; ++k) {
            const Case x = random_case(rng, tilt, 0.6);
            StripPoint c[2];
            const int n = x.points(c);
            for (int i = 0; i < n; ++i) {
                const Vec3 tau = x.pose().z.cross(c[i].radial);
                const double along = tau.dot(x.pose().s);
                if (1 - along * along - c[i].distance * c[i].n.dot(c[i].radial) < 0.25 || c[i].distance < 0.2)
                    continue; // too flat or too near the axis for the differences
                SCOPED_TRACE(::testing::Message() << "tilt " << tilt << " point " << i);
                ++checked;
                const auto at = [&](const Pair& m) {
                    Case moving = x;
                    moving.m = m;
                    StripPoint out[2];
                    moving.points(out);
                    // The same one of the two, whichever is nearer now.
                    return i == 0 && n == 1
                               ? out[0]
                               : out[(out[0].p - c[i].p).norm() < (out[1].p - c[i].p).norm() ? 0 : 1];
                };
                const auto rates = [&](const Pair& m, const ContactPoint&) {
                    return strip_rates(m[0], m[1], cylinder_pose(m[0], m[1], x.pair), at(m));
                };
                check_contact(
                    x.m, [&](const Pair& m) -> ContactPoint { return at(m); }, rates);
                Gradient<1> position;
                strip_rates(x.m[0], x.m[1], x.pose(), c[i], &position);
                const auto place = [&](const Pair& m) { return MatX::Constant(1, 1, at(m).x); };
                EXPECT_LT(error(dense(position), jacobian(x.m, place, moved)), 1e-8);
            }
        }
    EXPECT_GT(checked, 40);
}

// Concentric and tilted: the circle looks like an ellipse with the short half axis R cos(tilt), whose two
// ends lie on opposite sides at that distance.
TEST(GapStrip, ConcentricTiltedTouchesOnBothSides) {
    for (const double tilt : {0.5, 1.0, pi / 2, 2.5}) {
        BodyMotion a, b;
        b.A = Eigen::AngleAxisd(tilt, Vec3::UnitX()).toRotationMatrix();
        const CylinderPair pair{Vec3::Zero(), Vec3::UnitZ(), Vec3::Zero(), Vec3::UnitZ(), 0.9};
        const CylinderPose pose = cylinder_pose(a, b, pair);
        StripPoint c[2];
        ASSERT_EQ(strip_points(pose, strip_frame(pose), 0.9, 0, 1, c), 2);
        for (const StripPoint& x : c) {
            EXPECT_NEAR(x.depth, 0.9 - std::abs(std::cos(tilt)), 1e-15);
            EXPECT_NEAR(std::abs(x.p.y()), 1, 1e-15);
            EXPECT_TRUE(finite(x) && finite(strip_rates(a, b, pose, x)));
        }
        EXPECT_LT((c[0].p + c[1].p).norm(), 1e-15);
        if (std::abs(std::cos(tilt)) > 0.1) {
            EXPECT_LT((c[0].n + c[1].n).norm(), 1e-15);
        }
    }
}

// Parallel, antiparallel, concentric, journal axis on and outside the circle, at right angles.
TEST(GapStrip, NothingFails) {
    const CylinderPair pair{Vec3::Zero(), Vec3::UnitZ(), Vec3::Zero(), Vec3::UnitZ(), 0.0095};
    std::vector<Mat3> turns{Mat3::Identity(), Vec3(1, -1, -1).asDiagonal(),
                            Eigen::AngleAxisd(pi / 2, Vec3::UnitX()).toRotationMatrix()};
    for (const double tilt : {1e-300, 1e-160, 1e-17, 1e-16, 1e-15, 1e-12, 1e-8, pi - 1e-9, pi / 2 - 1e-12})
        turns.push_back(Eigen::AngleAxisd(tilt, Vec3(0.6, 0.8, 0)).toRotationMatrix());
    for (const Mat3& turn : turns)
        for (const double shift : {0.0, 1e-300, 1e-160, 1e-20, 1e-17, 1e-12, 5e-4, 0.01, 0.01 + 1e-17, 0.3})
            for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.6, 0.8, 0), Vec3(-0.8, 0.6, 0)})
                for (const double offset : {0.0, 0.02}) {
                    BodyMotion a, b;
                    b.A = turn;
                    b.r = shift * direction;
                    const CylinderPose pose = cylinder_pose(a, b, pair);
                    StripPoint c[2];
                    const int n = strip_points(pose, strip_frame(pose), pair.journal_radius, offset, 0.01, c);
                    for (int i = 0; i < n; ++i) {
                        Gradient<1> position;
                        EXPECT_TRUE(finite(c[i]));
                        EXPECT_TRUE(finite(strip_rates(a, b, pose, c[i], &position)));
                        EXPECT_TRUE(dense(position).allFinite());
                        EXPECT_NEAR(c[i].n.norm(), 1, 1e-14);
                        EXPECT_NEAR(c[i].radial.norm(), 1, 1e-14);
                        EXPECT_NEAR(c[i].distance, axis_distance(pose, c[i].p), 1e-16);
                    }
                    EXPECT_LE(c[0].depth, bearing_depth_bound(pose, 0.0095, 0.02, 0.01) + 1e-17);
                }
    // Concentric and parallel: R - R_j apart; the journal moved by 0.7 mm along y: 0.2 mm deep, pushing along
    // y.
    BodyMotion a, b;
    StripPoint c[2];
    CylinderPose pose = cylinder_pose(a, b, pair);
    EXPECT_EQ(strip_points(pose, strip_frame(pose), 0.0095, 0, 0.01, c), 1);
    EXPECT_NEAR(c[0].depth, -5e-4, 1e-17);
    b.r = Vec3(0, 7e-4, 0);
    pose = cylinder_pose(a, b, pair);
    strip_points(pose, strip_frame(pose), 0.0095, 0, 0.01, c);
    EXPECT_NEAR(c[0].depth, 2e-4, 1e-17);
    EXPECT_LT((c[0].n - Vec3::UnitY()).norm(), 1e-15);
    EXPECT_LT((c[0].p - Vec3(0, 0.01, 0)).norm(), 1e-15);
}

// Never below the truth, and above it by no more than the tilt shortens the circle.
TEST(GapStrip, Bounds) {
    std::mt19937 rng(43);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int k = 0; k < 100000; ++k) {
        const double tilt = std::pow(10, -4 * uniform(rng)) * pi;
        Case x = random_case(rng, tilt, std::pow(10, -3 * uniform(rng)));
        const CylinderPose pose = x.pose();
        const StripFrame frame = strip_frame(pose);
        double deepest = -1e9;
        const int strips = 5;
        for (int i = 0; i < strips; ++i) {
            const double offset = 0.5 * (i - (strips - 1) / 2.0);
            const double R = 1 + 0.1 * (i % 2);
            StripPoint c[2];
            strip_points(pose, frame, 0.9, offset, R, c);
            const double bound = strip_depth_bound(frame, 0.9, offset, R);
            ASSERT_LE(c[0].depth, bound + 1e-15);
            ASSERT_EQ(strip_is_apart(frame, 0.9, offset, R), bound <= 0) << bound;
            if ((pose.offset + offset * pose.offset_slope).norm() < R * std::abs(pose.cosine)) {
                ASSERT_GE(c[0].depth, bound - R * (1 - std::abs(pose.cosine)) - 1e-15);
            }
            deepest = std::max(deepest, c[0].depth);
        }
        ASSERT_LE(deepest, bearing_depth_bound(pose, 0.9, 1.0, 1.0) + 1e-15);
    }
}

TEST(GapStrip, Coverage) {
    EXPECT_EQ(strip_coverage(0.01, 0.002, 0.04).fraction, 1);
    EXPECT_EQ(strip_coverage(0.01, 0.002, 0.04).by_x, 0);
    EXPECT_NEAR(strip_coverage(0.0195, 0.002, 0.04).fraction, 0.75, 1e-12);
    EXPECT_NEAR(strip_coverage(0.0195, 0.002, 0.04).by_x, -500, 1e-9);
    EXPECT_NEAR(strip_coverage(-0.0205, 0.002, 0.04).fraction, 0.25, 1e-12);
    EXPECT_NEAR(strip_coverage(-0.0205, 0.002, 0.04).by_x, 500, 1e-9);
    EXPECT_EQ(strip_coverage(0.03, 0.002, 0.04).fraction, 0);
    EXPECT_EQ(strip_coverage(0.03, 0.002, 0.04).by_x, 0);
    EXPECT_NEAR(strip_coverage(0.0001, 0.002, 0.001).fraction, 0.5, 1e-12); // journal inside one strip
    EXPECT_EQ(strip_coverage(0.0001, 0.002, 0.001).by_x, 0);
}

// A journal 0.35 mm below the centre and tilted by 1 degree about Y in a bearing along X, elastic: force and
// moment on the journal from an independent calculation in the coordinates of the ellipse.
TEST(GapStrip, StaticPose) {
    const CylinderPair pair{Vec3::Zero(), Vec3::UnitX(), Vec3::Zero(), Vec3::UnitZ(), 0.0095};
    const BodyMotion a;
    BodyMotion b;
    b.r = Vec3(0, 0, -3.5e-4);
    b.A = Eigen::AngleAxisd(pi / 180, Vec3::UnitY()).toRotationMatrix() * rotation(Vec4(0.5, 0.5, 0.5, 0.5));
    const CylinderPose pose = cylinder_pose(a, b, pair);
    const StripFrame frame = strip_frame(pose);
    const struct {
        int strips;
        double fz, my;
    } truth[] = {
        {8, 31.820628680, -0.525916450}, {16, 32.321300581, -0.543596573}, {256, 32.617297909, -0.550757746}};
    for (const auto& t : truth) {
        Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
        for (int k = 1; k <= t.strips; ++k) {
            StripPoint c[2];
            const int n =
                strip_points(pose, frame, 0.0095, (t.strips - 2 * k + 1) / 2.0 * 0.04 / t.strips, 0.01, c);
            EXPECT_TRUE(n == 1 || c[1].depth < 0);
            if (c[0].depth <= 0)
                continue;
            const PairWrench w =
                point_wrench(a, b, c[0].p, 1e8 / t.strips * std::pow(c[0].depth, 1.5) * c[0].n);
            force += w.force_b;
            moment += b.A * w.moment_b;
        }
        EXPECT_NEAR(force.z(), t.fz, 6e-10);
        EXPECT_NEAR(moment.y(), t.my, 6e-10);
        EXPECT_NEAR(force.y(), 0, 1e-12);
        EXPECT_NE(force.x(), 0); // the normal is the journal's: it has a part along the bearing
    }
}

} // namespace
} // namespace gudgeon
