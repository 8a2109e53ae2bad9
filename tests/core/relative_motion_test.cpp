#include "core/relative_motion.hpp"

#include "core/motion_tools.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace gudgeon {
namespace {

using namespace test;

// One measure behind a common face.
struct Measure {
    const char* name;
    CouplingMask coupling;
    std::function<VecX(const Pair&)> value;
    std::function<MatX(const Pair&)> gradient, rate_gradient;
    std::function<BlockMatrix(const Pair&, const VecX&)> geometric;
};

VecX scalar(double x) { return VecX::Constant(1, x); }

Measure point_difference_measure(Vec3 sa, Vec3 sb) {
    namespace f = point_difference;
    return {"point difference",
            f::coupling,
            [=](const Pair& m) { return f::value(m[0], m[1], sa, sb); },
            [=](const Pair& m) { return dense(f::gradient(m[0], m[1], sa, sb)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], sa, sb)); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(m[0], m[1], sa, sb, g, out);
                return out;
            }};
}

Measure displacement_measure(Vec3 sa, Vec3 sb, Vec3 x) {
    namespace f = displacement;
    return {"displacement",
            f::coupling,
            [=](const Pair& m) { return scalar(f::value(m[0], m[1], sa, sb, x)); },
            [=](const Pair& m) { return dense(f::gradient(m[0], m[1], sa, sb, x)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], sa, sb, x)); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(m[0], m[1], sa, sb, g[0] * x, out);
                return out;
            }};
}

Measure alignment_measure(Vec3 x, Vec3 y) {
    namespace f = alignment;
    return {"alignment",
            f::coupling,
            [=](const Pair& m) { return scalar(f::value(m[0], m[1], x, y)); },
            [=](const Pair& m) { return dense(f::gradient(m[0], m[1], x, y)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], x, y)); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(m[0], m[1], x, y, g[0], out);
                return out;
            }};
}

Measure swing_measure(Vec3 x, Vec3 y) {
    namespace f = swing;
    return {"swing",
            f::coupling,
            [=](const Pair& m) { return scalar(f::value(m[0], m[1], x, y)); },
            [=](const Pair& m) { return dense(f::gradient(m[0], m[1], x, y)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], x, y)); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(m[0], m[1], x, y, g[0], out);
                return out;
            }};
}

Measure distance_measure(Vec3 sa, Vec3 sb) {
    namespace f = distance;
    return {"distance",
            f::coupling,
            [=](const Pair& m) { return scalar(f::value(m[0], m[1], sa, sb)); },
            [=](const Pair& m) { return dense(f::gradient(m[0], m[1], sa, sb)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], sa, sb)); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(m[0], m[1], sa, sb, g[0], out);
                return out;
            }};
}

Measure rotation_vector_measure(Vec4 qa, Vec4 qb) {
    namespace f = rotation_vector;
    const Mat3 xa = rotation(qa), xb = rotation(qb);
    const auto theta = [=](const Pair& m) { return f::value(m[0], m[1], qa, qb); };
    const auto gradient = [=](const Pair& m) { return f::gradient(theta(m), xa, xb); };
    return {"rotation vector",
            f::coupling,
            [=](const Pair& m) { return theta(m); },
            [=](const Pair& m) { return dense(gradient(m)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], theta(m), xa, xb, gradient(m))); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(theta(m), xa, xb, gradient(m), g, out);
                return out;
            }};
}

Measure angle_measure(AngleFrames frames) {
    namespace f = angle;
    return {"angle",
            f::coupling,
            [=](const Pair& m) { return scalar(f::value(m[0], m[1], frames, 0.3)); },
            [=](const Pair& m) { return dense(f::gradient(m[0], m[1], frames)); },
            [=](const Pair& m) { return dense(f::rate_gradient(m[0], m[1], frames)); },
            [=](const Pair& m, const VecX& g) {
                BlockMatrix out = zero_blocks();
                f::add_geometric(m[0], m[1], frames, g[0], out);
                return out;
            }};
}

void check(const Measure& c, const Pair& m, const VecX& g) {
    SCOPED_TRACE(c.name);
    const MatX b = c.gradient(m), d = c.rate_gradient(m);
    EXPECT_LT(error(b, jacobian(m, c.value, moved)), 1e-9);

    // D = d(B u)/dq at fixed u
    const Vec12 u = velocities(m);
    EXPECT_LT(error(d, jacobian(
                           m, [&](const Pair& x) { return MatX(c.gradient(x) * u); }, moved)),
              1e-9);

    const BlockMatrix s = c.geometric(m, g);
    const MatX truth = jacobian(
        m, [&](const Pair& x) { return MatX(c.gradient(x).transpose() * g); }, moved);
    EXPECT_LT(error(dense(s), truth), 1e-9);
    EXPECT_EQ(outside(s, c.coupling), 0.0);

    // B u and D u are the first and second time derivative of a motion without accelerations.
    const auto along = [&](double t) { return MatX(c.value(advanced(m, t))); };
    EXPECT_LT(error(b * u, derivative(along, 2e-3)), 1e-9);
    EXPECT_LT(error(d * u, second_derivative(along, 4e-3)), 1e-7);
}

// Bodies whose joint frames differ by a given rotation vector.
Pair pair_turned_by(std::mt19937& rng, const Vec4& qa, const Vec4& qb, const Vec3& theta) {
    Pair m = random_pair(rng);
    m[1].p = euler_parameters(m[0].A * rotation(qa) * rotation(turned(Vec4(1, 0, 0, 0), theta)) *
                              rotation(qb).transpose());
    m[1].A = rotation(m[1].p);
    return m;
}

TEST(RelativeMotion, DerivativesAgreeWithDifferences) {
    std::mt19937 rng(1);
    for (int trial = 0; trial < 5; ++trial) {
        SCOPED_TRACE(trial);
        const Vec3 sa = random_vector(rng), sb = random_vector(rng), x = random_vector(rng),
                   y = random_vector(rng);
        const VecX g1 = scalar(random_vector(rng, 20)[0]), g3 = random_vector(rng, 20);
        check(point_difference_measure(sa, sb), random_pair(rng), g3);
        check(displacement_measure(sa, sb, x), random_pair(rng), g1);
        check(alignment_measure(x, y), random_pair(rng), g1);
        check(distance_measure(sa, sb), random_pair(rng), g1);
    }
}

TEST(RelativeMotion, RotationVectorDerivativesAgreeWithDifferences) {
    std::mt19937 rng(2);
    for (const double size : {0.0, 1e-9, 1e-3, 0.49, 0.51, 2.9}) {
        SCOPED_TRACE(size);
        const Vec4 qa = random_orientation(rng), qb = random_orientation(rng);
        const Vec3 theta = size * random_vector(rng).normalized();
        const Pair m = pair_turned_by(rng, qa, qb, theta);
        EXPECT_LT((rotation_vector::value(m[0], m[1], qa, qb) - theta).norm(), 1e-14 + 1e-14 * size);
        check(rotation_vector_measure(qa, qb), m, random_vector(rng, 20));
    }
}

TEST(RelativeMotion, SwingIsTheAngleBetweenTwoAxes) {
    std::mt19937 rng(9);
    for (const double angle : {1e-6, 0.2, 1.5, 2.9, pi - 1e-6}) {
        SCOPED_TRACE(angle);
        Pair m = random_pair(rng);
        const Mat3 axes = rotation(random_orientation(rng));
        const Vec3 x = axes.col(0);
        m[1].p = turned(m[0].p, angle * axes.col(1));
        m[1].p = turned(m[1].p, 0.8 * x); // about b's own axis: no swing
        m[1].A = rotation(m[1].p);
        EXPECT_NEAR(swing::value(m[0], m[1], x, x), angle, 4e-15);
        if (angle > 1e-3 && angle < 3)
            check(swing_measure(x, x), m, scalar(7));
        // opens with the speed of b about the axis across both
        m[0].w.setZero();
        m[1].w = m[1].A.transpose() * (m[0].A * (2 * axes.col(1) + 3 * axes.col(0)));
        EXPECT_NEAR(swing::gradient(m[0], m[1], x, x).times(m[0], m[1])[0], 2, 1e-8);
    }
    for (const Vec3& y : {Vec3(0, 0, 1), Vec3(0, 0, -1)}) { // one line: no direction to open
        BodyMotion a, b;
        b.w = {1, 2, 3};
        EXPECT_EQ(swing::value(a, b, Vec3::UnitZ(), y), y[2] > 0 ? 0 : pi);
        EXPECT_EQ(dense(swing::gradient(a, b, Vec3::UnitZ(), y)).norm(), 0);
        EXPECT_EQ(dense(swing::rate_gradient(a, b, Vec3::UnitZ(), y)).norm(), 0);
        BlockMatrix s = zero_blocks();
        swing::add_geometric(a, b, Vec3::UnitZ(), y, 5, s);
        EXPECT_EQ(dense(s).norm(), 0);
    }
}

TEST(RelativeMotion, AngleDerivativesAgreeWithDifferences) {
    std::mt19937 rng(3);
    for (const double turn : {0.0, 1.0, 3.0, -2.0}) {
        SCOPED_TRACE(turn);
        const Mat3 xa = rotation(random_orientation(rng)), xb = rotation(random_orientation(rng));
        // Nearly parallel axes, as in a joint on its way to convergence.
        Pair m = random_pair(rng);
        const Vec4 tilt = turned(turned(Vec4(1, 0, 0, 0), Vec3(0.1, -0.07, 0)), Vec3(0, 0, turn));
        m[1].p = euler_parameters(m[0].A * xa * rotation(tilt) * xb.transpose());
        m[1].A = rotation(m[1].p);
        const AngleFrames frames{xa.col(1), xb.col(0), xa.col(0), xb.col(0)};
        check(angle_measure(frames), m, scalar(13));
    }
}

TEST(RelativeMotion, SmallRotationVectorKeepsItsDigits) {
    const BodyMotion a;
    BodyMotion b;
    const Vec3 theta = 1e-9 * Vec3(1, -2, 2);
    b.p = turned(b.p, theta);
    b.A = rotation(b.p);
    const Vec4 none(1, 0, 0, 0);
    EXPECT_LT((rotation_vector::value(a, b, none, none) - theta).norm(), 1e-24);
}

// Series and closed form of the rotation vector's coefficients meet at |theta| = 1/2.
TEST(RelativeMotion, RotationVectorGradientIsContinuousWhereTheSeriesEnds) {
    const Vec3 n = Vec3(1, 2, -1).normalized();
    const Mat3 none = Mat3::Identity();
    const double step = 1e-12;
    const auto below = rotation_vector::gradient((0.5 - step) * n, none, none);
    const auto above = rotation_vector::gradient((0.5 + step) * n, none, none);
    EXPECT_LT((below.tb - above.tb).norm(), 1e-11);
    BlockMatrix s_below = zero_blocks(), s_above = zero_blocks();
    const Vec3 g(3, -1, 2);
    rotation_vector::add_geometric((0.5 - step) * n, none, none, below, g, s_below);
    rotation_vector::add_geometric((0.5 + step) * n, none, none, above, g, s_above);
    EXPECT_LT((dense(s_below) - dense(s_above)).norm(), 1e-10);
}

TEST(RelativeMotion, HandValues) {
    BodyMotion a, b;
    a.r = {1, 0, 0};
    a.p = turned(a.p, Vec3(0, 0, pi / 2)); // a's x axis along global y
    a.A = rotation(a.p);
    b.r = {1, 5, 2};
    const Vec3 sa(1, 0, 0), sb(0, 0, 1); // P_a = (1, 1, 0), P_b = (1, 5, 3)
    EXPECT_LT((point_difference::value(a, b, sa, sb) - Vec3(0, 4, 3)).norm(), 1e-15);
    EXPECT_NEAR(distance::value(a, b, sa, sb), 5, 1e-15);
    EXPECT_NEAR(displacement::value(a, b, sa, sb, Vec3(1, 0, 0)), 4, 1e-15);
    EXPECT_NEAR(displacement::value(a, b, sa, sb, Vec3(0, 0, 1)), 3, 1e-15);
    EXPECT_NEAR(alignment::value(a, b, Vec3(1, 0, 0), Vec3(0, 1, 0)), 1, 1e-15);
    EXPECT_NEAR(alignment::value(a, b, Vec3(0, 1, 0), Vec3(1, 0, 0)), -1, 1e-15);
}

TEST(RelativeMotion, TurnOfBAgainstAIsPositiveAboutTheAxis) {
    std::mt19937 rng(4);
    const Mat3 triad = joint_triad(Vec3(0.3, -0.5, 0.8));
    const BodyMotion a = random_motion(rng);
    BodyMotion b = a;
    b.p = turned(a.p, 0.7 * triad.col(2));
    b.A = rotation(b.p);
    const AngleFrames frames{triad.col(1), triad.col(0), triad.col(0), triad.col(0)};
    EXPECT_NEAR(angle::value(a, b, frames, 0), 0.7, 1e-14);
    EXPECT_NEAR(angle::value(a, b, frames, 6), 0.7 + 2 * pi, 1e-14);
    const Vec4 q = euler_parameters(triad);
    EXPECT_LT((rotation_vector::value(a, b, q, q) - Vec3(0, 0, 0.7)).norm(), 1e-14);
}

TEST(RelativeMotion, AngleCountsTurnsBothWays) {
    const AngleFrames frames{Vec3::UnitY(), Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitX()};
    for (const double speed : {30.0, -30.0}) {
        const double dt = 0.2; // 6 rad a step: the rate must choose the branch
        double angle = 0, t = 0;
        const double rate = speed;
        for (int step = 0; step < 40; ++step) {
            BodyMotion m[2];
            Evaluation e;
            e.body = m;
            e.angle = &angle;
            e.angle_rate = &rate;
            e.t_accepted = t;
            e.t = t + dt;
            m[1].p = turned(m[1].p, Vec3(0, 0, speed * e.t));
            m[1].A = rotation(m[1].p);
            angle = angle::value(m[0], m[1], frames, e.angle_reference(0));
            t = e.t;
            ASSERT_NEAR(angle, speed * t, 1e-11);
        }
        EXPECT_NEAR(std::abs(angle), 240, 1e-10); // 38 turns
    }
}

TEST(JointTriad, FollowsTheAxesCyclically) {
    Mat3 along_x, along_y, along_z;
    along_x << Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX();
    along_y << Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY();
    along_z << Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ();
    EXPECT_EQ(joint_triad(Vec3(2, 0, 0)), along_x);
    EXPECT_EQ(joint_triad(Vec3(0, 3, 0)), along_y);
    EXPECT_EQ(joint_triad(Vec3(0, 0, 5)), along_z);
}

TEST(JointTriad, IsRightHandedWithTheAxisLast) {
    std::mt19937 rng(5);
    for (int trial = 0; trial < 20; ++trial) {
        const Vec3 axis = random_vector(rng);
        for (const Mat3& t : {joint_triad(axis), joint_triad(axis, random_vector(rng))}) {
            EXPECT_LT((t.transpose() * t - Mat3::Identity()).norm(), 1e-14);
            EXPECT_LT((t.col(0).cross(t.col(1)) - t.col(2)).norm(), 1e-14);
            EXPECT_LT((t.col(2) - axis.normalized()).norm(), 1e-14);
        }
    }
    // Closest to Z: h is the part of X normal to the axis.
    const Mat3 t = joint_triad(Vec3(0.1, 0.2, -0.9));
    EXPECT_GT(t(0, 0), 0.9);
    EXPECT_NEAR(t.col(0).dot(Vec3(0.1, 0.2, -0.9)), 0, 1e-15);
    EXPECT_NEAR(t.col(0).dot(Vec3(0.1, 0.2, -0.9).cross(Vec3::UnitX())), 0, 1e-15);
    // A reference that is not normal to the axis keeps its side.
    const Mat3 r = joint_triad(Vec3::UnitZ(), Vec3(1, 1, 7));
    EXPECT_LT((r.col(0) - Vec3(1, 1, 0).normalized()).norm(), 1e-15);
}

} // namespace
} // namespace gudgeon
