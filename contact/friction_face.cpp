#include "contact/friction_face.hpp"

namespace gudgeon {

namespace {

// Angular velocity of b relative to a about a direction x fixed in a: a rate that belongs to no coordinate.
namespace spin {

Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x) {
    Gradient<1> g;
    g.ta = -x.transpose();
    g.tb = (b.A.transpose() * (a.A * x)).transpose();
    return g;
}

// d(x . A_a^T A_b w_b)/dq at fixed w
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x) {
    Gradient<1> g;
    g.ta = x.cross(a.A.transpose() * (b.A * b.w)).transpose();
    g.tb = b.w.cross(b.A.transpose() * (a.A * x)).transpose();
    return g;
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& x, double g, BlockMatrix& out) {
    const Mat3 b_from_a = b.A.transpose() * a.A;
    out.block[3][1] -= g * b_from_a * skew(x);
    out.block[3][3] += g * skew(b_from_a * x);
}

} // namespace spin

Gradient<1> slip_gradient(const FaceSlip& face, int k, const BodyMotion& a, const BodyMotion& b) {
    const Vec3 x = face.weight[k] * face.axes.col(k);
    return k < 2 ? displacement::gradient(a, b, face.sa, face.sb, x) : spin::gradient(a, b, x);
}

Gradient<1> slip_rate_gradient(const FaceSlip& face, int k, const BodyMotion& a, const BodyMotion& b) {
    const Vec3 x = face.weight[k] * face.axes.col(k);
    return k < 2 ? displacement::rate_gradient(a, b, face.sa, face.sb, x) : spin::rate_gradient(a, b, x);
}

/// Sum over l of m(k, l) g_l
Gradient<1> mixed(const Mat3& m, int k, const std::array<Gradient<1>, 3>& g) {
    return combined(1.0, combined(m(k, 0), g[0], m(k, 1), g[1]), m(k, 2), g[2]);
}

} // namespace

FaceSlip face_slip(const Vec3& sa, const Vec3& sb, const Mat3& triad, int axis, double radius) {
    FaceSlip out{sa, sb, {}, {1, 1, radius}, 1};
    for (int k = 0; k < 3; ++k)
        out.axes.col(k) = triad.col((axis + 1 + k) % 3);
    return out;
}

FaceSlip key_slip(const Vec3& sa, const Vec3& sb, const Mat3& triad, double radius) {
    FaceSlip out{sa, sb, {}, {1, 0, 0}, 1 / radius};
    for (int k = 0; k < 3; ++k)
        out.axes.col(k) = triad.col((2 + k) % 3);
    return out;
}

FaceFriction face_friction(const FrictionLaw& law, const FaceSlip& face, const double* z, const BodyMotion& a,
                           const BodyMotion& b, double limit_force) {
    FaceFriction out;
    out.normal_force = face.pressing * limit_force;
    for (int k = 0; k < 3; ++k) {
        if (face.weight[k] == 0)
            continue;
        out.gradient[k] = slip_gradient(face, k, a, b);
        out.slip[k] = out.gradient[k].times(a, b)[0];
    }
    out.f = evaluate_friction<3>(law, out.slip, z ? Vec3(Eigen::Map<const Vec3>(z)) : Vec3(Vec3::Zero()));
    return out;
}

PairWrench face_wrench(const FaceFriction& friction) {
    PairWrench sum;
    for (int k = 0; k < 3; ++k) {
        const Eigen::Matrix<double, 1, 1> force(friction.normal_force * friction.f.mu[k]);
        sum += conjugate_wrench<1>(friction.gradient[k], force);
    }
    return sum;
}

Vec3 face_force(const FaceFriction& friction, const FaceSlip& face, const BodyMotion& a) {
    const Vec3 mu(face.weight[0] * friction.f.mu[0], face.weight[1] * friction.f.mu[1], 0);
    return -friction.normal_force * (a.A * (face.axes * mu));
}

void add_face_linearisation(const FaceFriction& friction, const FaceSlip& face, const BodyMotion& a,
                            const BodyMotion& b, const Gradient<1>& by_pose, const Gradient<1>& by_speed,
                            BlockMatrix& C, BlockMatrix& S) {
    const Mat3 slope = friction.normal_force * friction.f.by_speed;
    std::array<Gradient<1>, 3> rate_gradient;
    for (int k = 0; k < 3; ++k)
        if (face.weight[k] != 0)
            rate_gradient[k] = slip_rate_gradient(face, k, a, b);
    for (int k = 0; k < 3; ++k) {
        if (face.weight[k] == 0)
            continue;
        const Gradient<1>& g = friction.gradient[k];
        const double pressed = face.pressing * friction.f.mu[k];
        add_product(g, combined(1.0, mixed(slope, k, friction.gradient), pressed, by_speed), C);
        add_product(g, combined(1.0, mixed(slope, k, rate_gradient), pressed, by_pose), S);
        const Vec3 x = face.weight[k] * face.axes.col(k);
        const double force = friction.normal_force * friction.f.mu[k];
        if (k < 2)
            displacement::add_geometric(a, b, face.sa, face.sb, force * x, S);
        else
            spin::add_geometric(a, b, x, force, S);
    }
}

void face_state_terms(const FaceFriction& friction, double* source, double* decay) {
    std::copy_n(friction.slip.data(), 3, source);
    std::fill_n(decay, 3, friction.f.decay);
}

std::array<Linearisation::StateCoupling, 3> face_state_couplings(const FaceFriction& friction) {
    std::array<Linearisation::StateCoupling, 3> out;
    for (int k = 0; k < 3; ++k) {
        out[k].decay = friction.f.decay;
        out[k].force = combined(-friction.normal_force * friction.f.by_state, friction.gradient[k], 0.0,
                                friction.gradient[k]);
        out[k].rate = mixed(friction.f.rate_by_speed, k, friction.gradient);
    }
    return out;
}

} // namespace gudgeon
