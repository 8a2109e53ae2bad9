#include "contact/friction_point.hpp"

namespace gudgeon {

namespace {

// J of the velocity of b's material at p off that of a's, global.
Gradient<3> relative_velocity(const BodyMotion& a, const BodyMotion& b, const Vec3& p) {
    Gradient<3> j;
    j.ra = -Mat3::Identity();
    j.ta = skew(p - a.r) * a.A;
    j.rb = Mat3::Identity();
    j.tb = -skew(p - b.r) * b.A;
    return j;
}

// d(J u)/dq at fixed u and p.
Gradient<3> relative_velocity_change(const BodyMotion& a, const BodyMotion& b, const Vec3& p) {
    const auto turn = [&](const BodyMotion& m) -> Mat3 { // of omega x (p - r), omega = A w
        return skew(p - m.r) * m.A * skew(m.w);
    };
    Gradient<3> d;
    d.ra = skew(a.A * a.w);
    d.ta = -turn(a);
    d.rb = -skew(b.A * b.w);
    d.tb = turn(b);
    return d;
}

} // namespace

PointFriction point_friction(const FrictionLaw& law, const double* z, const BodyMotion& a,
                             const BodyMotion& b, const ContactPoint& c, double normal_force) {
    PointFriction out;
    out.normal_force = normal_force;
    out.tangential = Mat3::Identity() - c.n * c.n.transpose();
    out.slip = out.tangential * (point_velocity_at(b, c.p) - point_velocity_at(a, c.p));
    if (z)
        out.bristles = Eigen::Map<const Vec3>(z);
    out.f = evaluate_friction<3>(law, out.slip, Vec3(a.A * out.bristles));
    out.force = -normal_force * (out.tangential * out.f.mu);
    return out;
}

// C = J^T (N P mu_v P J + P mu dN/du). With F the force on b, dF = -(dN P mu + N dP mu + N P dmu), dP x =
// -(dn (n.x) + n (dn.x)); mu changes with the slip, P V, and with the bristles that turn with a.
void add_friction_linearisation(const PointFriction& friction, const BodyMotion& a, const BodyMotion& b,
                                const ContactPoint& c, const ContactPointRates& rates,
                                const Gradient<1>& depth_rate, const Gradient<1>& change, double by_rate,
                                BlockMatrix& C, BlockMatrix& S) {
    const Gradient<3> j = relative_velocity(a, b, c.p), dj = relative_velocity_change(a, b, c.p);
    const Mat3& P = friction.tangential;
    const Mat3 by_speed = friction.normal_force * (P * friction.f.by_speed);
    const Vec3 pressed = P * friction.f.mu, &F = friction.force, arm_a = c.p - a.r, arm_b = c.p - b.r;
    const Vec3 velocity = point_velocity_at(b, c.p) - point_velocity_at(a, c.p);
    const auto tilt = [&](const Vec3& x) -> Mat3 { // d(P x)/dn
        return -c.n.dot(x) * Mat3::Identity() - c.n * x.transpose();
    };
    const Mat3 by_n = friction.normal_force * tilt(friction.f.mu) + by_speed * tilt(velocity);
    const Mat3 by_p = by_speed * P * skew(b.A * b.w - a.A * a.w);
    for (int col = 0; col < 4; ++col) {
        const Mat3 by_u = by_speed * P * j.part(col) + pressed * by_rate * depth_rate.part(col);
        Mat3 x = pressed * change.part(col) + by_n * rates.n.part(col) + by_p * rates.p.part(col) +
                 by_speed * P * dj.part(col); // -dF
        if (col == 1)
            x -= friction.normal_force * friction.f.by_state * P * a.A * skew(friction.bristles);
        Mat3 point_a = rates.p.part(col), point_b = point_a;
        if (col == 0)
            point_a -= Mat3::Identity();
        if (col == 2)
            point_b -= Mat3::Identity();
        for (int row = 0; row < 4; ++row)
            C.block[row][col] += j.part(row).transpose() * by_u;
        S.block[0][col] -= x;
        S.block[1][col] -= a.A.transpose() * (skew(arm_a) * x + skew(F) * point_a);
        S.block[2][col] += x;
        S.block[3][col] += b.A.transpose() * (skew(arm_b) * x + skew(F) * point_b);
    }
    S.block[1][1] += skew(a.A.transpose() * arm_a.cross(F));
    S.block[3][3] -= skew(b.A.transpose() * arm_b.cross(F));
}

// The bristles turn with a: seen from there they rest.
void add_relative_friction(const PointFriction& friction, const Vec3& n, const Vec3& arm,
                           const Vec3& velocity, const Vec3& turning, const Mat36& dn, const Mat36& dp,
                           const Vec6& depth_slope, const Vec6& change, double by_rate, RelativeWrench& out) {
    const Mat3& P = friction.tangential;
    const Mat3 by_slip = friction.normal_force * (P * friction.f.by_speed), by_velocity = by_slip * P;
    const Vec3 pressed = P * friction.f.mu, force = -friction.force; // on a
    const auto tilt = [&n](const Vec3& x) -> Mat3 {                  // d(P x)/dn
        return -n.dot(x) * Mat3::Identity() - n * x.transpose();
    };
    Mat36 by_pose = pressed * change.transpose() + by_velocity * skew(turning) * dp;
    by_pose += (friction.normal_force * tilt(friction.f.mu) + by_slip * tilt(velocity)) * dn;
    Mat36 by_twist = pressed * (by_rate * depth_slope.transpose());
    by_twist.leftCols<3>() += by_velocity;
    by_twist.rightCols<3>() -= by_velocity * skew(arm);

    const Mat3 lever = skew(arm);
    out.value.head<3>() += force;
    out.value.tail<3>() += arm.cross(force);
    out.by_pose.topRows<3>() += by_pose;
    out.by_pose.bottomRows<3>() += lever * by_pose - skew(force) * dp;
    out.by_twist.topRows<3>() += by_twist;
    out.by_twist.bottomRows<3>() += lever * by_twist;
    out.damps = true;
}

void point_state_terms(const PointFriction& friction, const BodyMotion& a, double* source, double* decay) {
    const Vec3 slip = a.A.transpose() * friction.slip;
    std::copy_n(slip.data(), 3, source);
    std::fill_n(decay, 3, friction.f.decay);
}

void free_state_terms(const FrictionLaw& law, double* source, double* decay) {
    std::fill_n(source, 3, 0.0);
    std::fill_n(decay, 3, law.free_decay());
}

std::array<Linearisation::StateCoupling, 3> free_state_couplings(const FrictionLaw& law) {
    std::array<Linearisation::StateCoupling, 3> out;
    for (Linearisation::StateCoupling& coupling : out)
        coupling.decay = law.free_decay();
    return out;
}

std::array<Linearisation::StateCoupling, 3> point_state_couplings(const PointFriction& friction,
                                                                  const BodyMotion& a, const BodyMotion& b,
                                                                  const ContactPoint& c) {
    const Gradient<3> j = relative_velocity(a, b, c.p);
    const Mat3 by_state = -friction.normal_force * friction.f.by_state * (friction.tangential * a.A);
    const Mat3 rate = a.A.transpose() * friction.f.rate_by_speed * friction.tangential;
    std::array<Linearisation::StateCoupling, 3> out;
    for (int k = 0; k < 3; ++k) {
        const Vec3 force = by_state.col(k);
        const Eigen::RowVector3d row = rate.row(k);
        out[k].decay = friction.f.decay;
        out[k].force = {force.transpose() * j.ra, force.transpose() * j.ta, force.transpose() * j.rb,
                        force.transpose() * j.tb};
        out[k].rate = {row * j.ra, row * j.ta, row * j.rb, row * j.tb};
    }
    return out;
}

} // namespace gudgeon
