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
    const Vec3 bristles = z ? Vec3(a.A * Eigen::Map<const Vec3>(z)) : Vec3(Vec3::Zero());
    out.f = evaluate_friction<3>(law, out.slip, bristles);
    out.force = -normal_force * (out.tangential * out.f.mu);
    return out;
}

void add_friction_linearisation(const PointFriction& friction, const BodyMotion& a, const BodyMotion& b,
                                const ContactPoint& c, const Gradient<1>& depth_rate,
                                const Gradient<1>& change, double by_rate, BlockMatrix& C, BlockMatrix& S) {
    const Gradient<3> j = relative_velocity(a, b, c.p), dj = relative_velocity_change(a, b, c.p);
    const Mat3& P = friction.tangential;
    const Mat3 by_slip = friction.normal_force * (P * friction.f.by_speed * P);
    const Vec3 direction = P * friction.f.mu; // -(force on b)/N
    for (int row = 0; row < 4; ++row) {
        const Mat3 left = j.part(row).transpose();
        const Mat3 slip = left * by_slip;
        const Vec3 pressed = left * direction;
        for (int col = 0; col < 4; ++col) {
            C.block[row][col] += slip * j.part(col) + by_rate * pressed * depth_rate.part(col);
            S.block[row][col] += slip * dj.part(col) + pressed * change.part(col);
        }
    }
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
