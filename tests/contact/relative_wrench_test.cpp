#include "contact/relative_wrench.hpp"

#include "core/force_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

const Vec3 origin_a(0.3, -0.2, 0.5); // fixed in a

Vec3 origin(const Pair& m) { return point_position(m[0], origin_a); }

Mat6 turned_blocks(const Mat3& A) {
    Mat6 out = Mat6::Zero();
    out.topLeftCorner<3, 3>() = A;
    out.bottomRightCorner<3, 3>() = A;
    return out;
}

/// Some force and moment in a's components: x places b's mass centre off the origin, R turns b's components
/// to a's.
Vec6 law(const Vec3& x, const Mat3& R, const Vec6& twist) {
    const Vec3 V = twist.head<3>(), W = twist.tail<3>(), y = R * Vec3(0.4, -0.7, 0.2);
    Vec6 out;
    out << x.cross(y) + 2 * x + x.dot(V) * y + 0.7 * V, y * (1 + x.squaredNorm()) + W.cross(x) + 0.3 * W;
    return out;
}

Vec6 wrench(const Pair& m) {
    const Mat3 At = m[0].A.transpose();
    const Mat6 to_a = turned_blocks(At);
    return to_a.transpose() *
           law(At * (m[1].r - origin(m)), At * m[1].A, to_a * relative_twist(m[0], m[1], origin(m)));
}

TEST(RelativeWrench, TwistIsThatOfTheMaterialAtTheOrigin) {
    std::mt19937 rng(71);
    const Pair m = random_pair(rng);
    const Vec3 o = origin(m);
    const Vec6 twist = relative_twist(m[0], m[1], o);
    const Vec3 va = m[0].v + (m[0].A * m[0].w).cross(o - m[0].r);
    const Vec3 vb = m[1].v + (m[1].A * m[1].w).cross(o - m[1].r);
    EXPECT_LT((twist.head<3>() - (vb - va)).norm(), 1e-14);
    EXPECT_LT((twist.tail<3>() - (m[1].A * m[1].w - m[0].A * m[0].w)).norm(), 1e-14);
    EXPECT_LT((dense(relative_twist_gradient(m[0], m[1], o)) * velocities(m) - twist).norm(), 1e-13);
    // the power of the pair of wrenches is that of the wrench over the twist, b feeling the opposite
    const Vec6 w = wrench(m);
    const PairWrench on = on_bodies(m[0], m[1], o, w);
    EXPECT_NEAR(dense(on).dot(velocities(m)), -w.dot(twist), 1e-12);
    EXPECT_LT(resultant(on, m).norm(), 1e-13);
    EXPECT_LT((on.force_a - w.head<3>()).norm(), 1e-15);
}

TEST(RelativeWrench, DerivativesOnTheBodies) {
    std::mt19937 rng(72);
    for (int trial = 0; trial < 5; ++trial) {
        const Pair m = random_pair(rng);
        const Mat3 At = m[0].A.transpose();
        const Mat6 to_a = turned_blocks(At);
        const Vec3 x = At * (m[1].r - origin(m));
        const Mat3 R = At * m[1].A;
        const Vec6 twist = to_a * relative_twist(m[0], m[1], origin(m));
        RelativeWrench w;
        w.value = wrench(m);
        w.damps = true;
        for (int k = 0; k < 6; ++k) {
            w.by_pose.col(k) = derivative([&](double h) {
                if (k < 3)
                    return MatX(law(x + h * Vec3::Unit(k), R, twist));
                const Mat3 turn = Eigen::AngleAxisd(h, Vec3::Unit(k - 3)).toRotationMatrix();
                return MatX(law(turn * x, turn * R, twist));
            });
            w.by_twist.col(k) =
                derivative([&](double h) { return MatX(law(x, R, twist + h * Vec6::Unit(k))); });
        }
        w.by_pose = to_a.transpose() * w.by_pose * to_a;
        w.by_twist = to_a.transpose() * w.by_twist * to_a;
        const auto f = [](const Pair& p) { return MatX(dense(on_bodies(p[0], p[1], origin(p), wrench(p)))); };
        BlockMatrix c = zero_blocks(), s = zero_blocks();
        add_relative_linearisation(m[0], m[1], origin(m), w, c, s);
        EXPECT_LT(error(dense(c), -jacobian(m, f, pushed)), 1e-9);
        EXPECT_LT(error(dense(s), -jacobian(m, f, moved)), 1e-9);
        w.by_twist.setZero();
        BlockMatrix c0 = zero_blocks(), s0 = zero_blocks(), s1 = zero_blocks();
        add_relative_linearisation(m[0], m[1], origin(m), w, c0, s0);
        w.damps = false;
        add_relative_linearisation(m[0], m[1], origin(m), w, c0, s1);
        EXPECT_EQ(dense(c0).norm(), 0);
        EXPECT_LT((dense(s0) - dense(s1)).norm(), 1e-13 * (1 + dense(s0).norm()));
    }
}

} // namespace
} // namespace gudgeon
