#include "contact/relative_wrench.hpp"

namespace gudgeon {

namespace {

using Mat63 = Eigen::Matrix<double, 6, 3>;

// m skew(x)
template <int R> Eigen::Matrix<double, R, 3> times_skew(const Eigen::Matrix<double, R, 3>& m, const Vec3& x) {
    Eigen::Matrix<double, R, 3> out;
    out.col(0) = m.col(1) * x.z() - m.col(2) * x.y();
    out.col(1) = m.col(2) * x.x() - m.col(0) * x.z();
    out.col(2) = m.col(0) * x.y() - m.col(1) * x.x();
    return out;
}

// skew(x) m
Mat3 skew_times(const Vec3& x, const Mat3& m) {
    Mat3 out;
    out.row(0) = x.y() * m.row(2) - x.z() * m.row(1);
    out.row(1) = x.z() * m.row(0) - x.x() * m.row(2);
    out.row(2) = x.x() * m.row(1) - x.y() * m.row(0);
    return out;
}

// Six rows over (t_a, r_b, t_b); those over r_a are the negative ones over r_b.
struct Columns {
    Mat63 ta, rb, tb;
};

struct Bodies {
    const BodyMotion &a, &b;
    Vec3 arm_a, arm_b; // m, to the origin
};

// m J, J = (skew(l_a) A_a; -A_a), (1; 0), (-skew(l_b) A_b; A_b).
Columns times_twist_gradient(const Mat6& m, const Bodies& p) {
    const Mat63 shift = m.leftCols<3>(), turn = m.rightCols<3>();
    const Mat63 on_a = times_skew(shift, p.arm_a) - turn, on_b = turn - times_skew(shift, p.arm_b);
    return {on_a.lazyProduct(p.a.A), shift, on_b.lazyProduct(p.b.A)};
}

// change += m (change of the twist, seen from a, with the poses at fixed u).
void add_twist_drift(const Mat6& m, const Bodies& p, const Vec3& wa, const Vec3& wb, Columns& change) {
    const Vec3 velocity = p.b.v + wb.cross(p.arm_b) - p.a.v - wa.cross(p.arm_a);
    const Mat63 shift = m.leftCols<3>(), turn = m.rightCols<3>();
    const Mat63 shift_b = times_skew(shift, wb), turn_b = times_skew(turn, wb);
    // shift (skew(wa - wb) skew(l_a) - skew(l_a) skew(wa) + skew(velocity)) + turn skew(wb)
    const Mat63 on_a = times_skew<6>(times_skew(shift, wa - wb), p.arm_a) -
                       times_skew<6>(times_skew(shift, p.arm_a), wa) + times_skew(shift, velocity) + turn_b;
    const Mat63 on_b = times_skew<6>(times_skew(shift, p.arm_b), wb) - turn_b;
    change.ta += on_a.lazyProduct(p.a.A);
    change.rb -= shift_b;
    change.tb += on_b.lazyProduct(p.b.A);
}

// out += J^T change in the rows of t_a, r_b, t_b of one column.
void add_rows(const Mat63& change, const Bodies& p, int column, BlockMatrix& out) {
    const Mat3 force = change.topRows<3>(), moment = change.bottomRows<3>();
    const Mat3 on_a = skew_times(p.arm_a, force) + moment, on_b = skew_times(p.arm_b, force) + moment;
    out.block[1][column] -= p.a.A.transpose().lazyProduct(on_a);
    out.block[2][column] += force;
    out.block[3][column] += p.b.A.transpose().lazyProduct(on_b);
}

// What r_a feels and what its displacement does is the opposite of r_b.
void add_opposite(const BlockMatrix& half, BlockMatrix& out) {
    for (int j = 1; j < 4; ++j)
        for (int i = 1; i < 4; ++i)
            out.block[i][j] += half.block[i][j];
    for (int k = 1; k < 4; ++k) {
        out.block[0][k] -= half.block[2][k];
        out.block[k][0] -= half.block[k][2];
    }
    out.block[0][0] += half.block[2][2];
}

} // namespace

Vec6 relative_twist(const BodyMotion& a, const BodyMotion& b, const Vec3& origin) {
    Vec6 out;
    out << point_velocity_at(b, origin) - point_velocity_at(a, origin), b.A * b.w - a.A * a.w;
    return out;
}

Gradient<6> relative_twist_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& origin) {
    const Columns j = times_twist_gradient(Mat6::Identity(), {a, b, origin - a.r, origin - b.r});
    return {-j.rb, j.ta, j.rb, j.tb};
}

PairWrench on_bodies(const BodyMotion& a, const BodyMotion& b, const Vec3& origin, const Vec6& wrench) {
    const Vec3 force = wrench.head<3>(), moment = wrench.tail<3>();
    return {force, a.A.transpose() * ((origin - a.r).cross(force) + moment), -force,
            -(b.A.transpose() * ((origin - b.r).cross(force) + moment))};
}

// The wrench on the bodies is -J^T (F, M). With (F, M) changing by by_pose J + by_twist (change of the twist)
// seen from a, what is left are the turn of (F, M) with a, of b's frame and of the arm to b.
void add_relative_linearisation(const BodyMotion& a, const BodyMotion& b, const Vec3& origin,
                                const RelativeWrench& wrench, BlockMatrix& C, BlockMatrix& S) {
    const Bodies p{a, b, origin - a.r, origin - b.r};
    const auto add = [&p](const Columns& change, BlockMatrix& half) {
        add_rows(change.ta, p, 1, half);
        add_rows(change.rb, p, 2, half);
        add_rows(change.tb, p, 3, half);
    };
    BlockMatrix half; // without r_a
    half.set_zero();
    Columns change = times_twist_gradient(wrench.by_pose, p);
    if (wrench.damps) {
        add(times_twist_gradient(wrench.by_twist, p), half);
        add_opposite(half, C);
        half.set_zero();
        add_twist_drift(wrench.by_twist, p, a.A * a.w, b.A * b.w, change);
    }
    add(change, half);

    const Vec3 force = wrench.value.head<3>(), moment = wrench.value.tail<3>();
    const Mat3 f = skew(force);
    const Mat3 turn_with_a = times_skew(f, p.arm_a) - skew_times(p.arm_b, f) - skew(moment);
    half.block[2][1] -= f.lazyProduct(a.A);
    half.block[3][1] += b.A.transpose().lazyProduct(turn_with_a.lazyProduct(a.A).eval());
    half.block[3][2] += b.A.transpose().lazyProduct(f);
    half.block[3][3] += skew(b.A.transpose() * (p.arm_b.cross(force) + moment));
    add_opposite(half, S);
}

} // namespace gudgeon
