#include "contact/relative_wrench.hpp"

namespace gudgeon {

namespace {

using Mat63 = Eigen::Matrix<double, 6, 3>;

// m J, part by part: J = (-1, skew(l_a) A_a; 0, -A_a) and (1, -skew(l_b) A_b; 0, A_b).
Gradient<6> times_twist_gradient(const Mat6& m, const BodyMotion& a, const BodyMotion& b,
                                 const Vec3& origin) {
    const Mat63 shift = m.leftCols<3>(), turn = m.rightCols<3>();
    Gradient<6> out;
    out.ra = -shift;
    out.ta = (shift.lazyProduct(skew(origin - a.r)) - turn).eval().lazyProduct(a.A);
    out.rb = shift;
    out.tb = (turn - shift.lazyProduct(skew(origin - b.r))).eval().lazyProduct(b.A);
    return out;
}

// Change of the twist, seen from a, with the poses at fixed u.
Gradient<6> twist_drift(const BodyMotion& a, const BodyMotion& b, const Vec3& origin) {
    const Vec3 arm_a = origin - a.r, arm_b = origin - b.r, wa = a.A * a.w, wb = b.A * b.w;
    const Vec3 velocity = b.v + wb.cross(arm_b) - a.v - wa.cross(arm_a);
    const Mat3 turning_a = skew(wa), turning_b = skew(wb), lever_a = skew(arm_a);
    Gradient<6> d;
    d.ra.topRows<3>() = turning_b;
    d.rb.topRows<3>() = -turning_b;
    d.ta.topRows<3>() = (turning_a.lazyProduct(lever_a) - turning_b.lazyProduct(lever_a) -
                         lever_a.lazyProduct(turning_a) + skew(velocity))
                            .eval()
                            .lazyProduct(a.A);
    d.tb.topRows<3>() = skew(arm_b).lazyProduct(turning_b).eval().lazyProduct(b.A);
    d.ta.bottomRows<3>() = turning_b.lazyProduct(a.A);
    d.tb.bottomRows<3>() = -turning_b.lazyProduct(b.A);
    return d;
}

// out += J^T change
void add_on_bodies(const BodyMotion& a, const BodyMotion& b, const Vec3& origin, const Gradient<6>& change,
                   BlockMatrix& out) {
    const Mat3 lever_a = skew(origin - a.r), lever_b = skew(origin - b.r);
    for (int j = 0; j < 4; ++j) {
        const Mat3 force = change.part(j).topRows<3>(), moment = change.part(j).bottomRows<3>();
        out.block[0][j] -= force;
        out.block[2][j] += force;
        out.block[1][j] -= a.A.transpose().lazyProduct((lever_a.lazyProduct(force) + moment).eval());
        out.block[3][j] += b.A.transpose().lazyProduct((lever_b.lazyProduct(force) + moment).eval());
    }
}

} // namespace

Vec6 relative_twist(const BodyMotion& a, const BodyMotion& b, const Vec3& origin) {
    Vec6 out;
    out << point_velocity_at(b, origin) - point_velocity_at(a, origin), b.A * b.w - a.A * a.w;
    return out;
}

Gradient<6> relative_twist_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& origin) {
    return times_twist_gradient(Mat6::Identity(), a, b, origin);
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
    Gradient<6> change = times_twist_gradient(wrench.by_pose, a, b, origin);
    if (wrench.damps) {
        const Gradient<6> drift = twist_drift(a, b, origin);
        change.ra += wrench.by_twist.lazyProduct(drift.ra);
        change.ta += wrench.by_twist.lazyProduct(drift.ta);
        change.rb += wrench.by_twist.lazyProduct(drift.rb);
        change.tb += wrench.by_twist.lazyProduct(drift.tb);
        add_on_bodies(a, b, origin, times_twist_gradient(wrench.by_twist, a, b, origin), C);
    }
    add_on_bodies(a, b, origin, change, S);

    const Vec3 force = wrench.value.head<3>(), moment = wrench.value.tail<3>();
    const Vec3 arm_a = origin - a.r, arm_b = origin - b.r;
    const Mat3 f = skew(force), f_a = f.lazyProduct(a.A), to_b = b.A.transpose().lazyProduct(f);
    const Mat3 turn_with_a = f.lazyProduct(skew(arm_a)) - skew(arm_b).lazyProduct(f) - skew(moment);
    S.block[0][1] += f_a;
    S.block[2][1] -= f_a;
    S.block[3][0] -= to_b;
    S.block[3][1] += b.A.transpose().lazyProduct(turn_with_a.lazyProduct(a.A).eval());
    S.block[3][2] += to_b;
    S.block[3][3] += skew(b.A.transpose() * (arm_b.cross(force) + moment));
}

} // namespace gudgeon
