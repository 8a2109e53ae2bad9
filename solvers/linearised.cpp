#include "solvers/linearised.hpp"

#include "core/matrices.hpp"
#include "solvers/redundancy.hpp"
#include "solvers/rest_point.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace gudgeon {

namespace {

MatX dense(const CscMatrix& m) {
    MatX out = MatX::Zero(m.pattern.rows, m.pattern.cols);
    for (int j = 0; j < m.pattern.cols; ++j)
        for (int p = m.pattern.col_start[j]; p < m.pattern.col_start[j + 1]; ++p)
            out(m.pattern.row[p], j) = m.values[p];
    return out;
}

} // namespace

Linearised::Linearised(const System& system, const State& state)
    : system_(system), ws_(make_workspace(system)), matrix_(system, dependent_rows(system, state)),
      x_(VecX::Zero(system.velocities())), v_(x_), mx_(x_), cx_(x_), force_(x_),
      none_(VecX::Zero(system.row_count())) {
    ws_.angles = state.angles;
    ws_.contacts = state.contacts;
    ws_.z = state.z;
    ws_.frozen = state.u.isZero(0);
    set_motion(system, state.q, state.u, ws_);
    evaluate_forces(system, state.t, ws_);
    evaluate_constraints(system, state.t, nullptr, true, ws_);
    VecX acceleration = ws_.f, lambda = none_;
    if (!ws_.frozen) {
        const Evaluation e = evaluation(system, ws_, state.t);
        for (const auto& batch : system.constraints)
            batch->acceleration_rhs(e, lambda.data());
    }
    if (!matrix_.factor_mass(ws_).ok())
        throw std::runtime_error("the mass matrix with the constraints is singular at this state");
    matrix_.solve(acceleration, lambda);
    linearise(system, state.t, lambda.data(), ws_);
    ws_.lin.states.clear();
    ws_.lin.reactions.clear();
    double most = system.gravity.norm();
    for (int i = 0; i < system.moving; ++i) {
        // the angular velocity along axes that do not turn: d/dt(A dw) = A (dw' + w x dw)
        const Mat3 turning = -system.inertia[i] * skew(ws_.motion[i].w);
        Linearisation::add(ws_.lin.C, 4 * i + 3, turning);
        most = std::max(most, ws_.f.segment<3>(6 * i).norm() / system.mass[i]);
    }
    if (most > 0)
        scale_ = most / mechanism_size(system);
}

void Linearised::factor(double sigma) {
    for (int trial = 0; trial < 5; ++trial, sigma *= 1.37) // a root may sit on the shift
        if (matrix_.factor(ws_, sigma, 1 / sigma).ok()) {
            sigma_ = sigma;
            return;
        }
    throw std::runtime_error("the constrained stiffness matrix is singular for every shift tried: a motion "
                             "without mass and stiffness, or constraints that repeat each other");
}

// r = x + sigma p; (sigma^2 M + sigma C + S) p + G^T mu = -(C x + sigma M x + M v), G p = 0.
void Linearised::shift_invert(const double* y, double* w) {
    const Eigen::Index n = x_.size();
    x_ = Eigen::Map<const VecX>(y, n);
    v_ = sigma_ * Eigen::Map<const VecX>(y + n, n);
    v_ += sigma_ * x_;
    mass_of(v_, mx_);
    damping_of(x_, cx_);
    force_ = -(mx_ + cx_) / sigma_;
    none_.setZero();
    matrix_.solve(force_, none_);
    Eigen::Map<VecX>(w, n) = force_;
    Eigen::Map<VecX>(w + n, n) = x_ / sigma_ + force_;
}

MatX Linearised::mass() const { return dense(mass_matrix(system_)); }
MatX Linearised::damping() const { return dense(blocks_as_matrix(system_, ws_.lin.C)); }
MatX Linearised::stiffness() const { return dense(blocks_as_matrix(system_, ws_.lin.S)); }
MatX Linearised::rows() const { return dense(rows_as_matrix(system_, ws_)); }

std::complex<double> Linearised::refined(const Eigen::VectorXcd& x, std::complex<double> s) const {
    using Complex = std::complex<double>;
    const VecX re = x.real(), im = x.imag();
    VecX a(re.size()), b(re.size());
    const auto form = [&](auto&& times) {
        times(re, a);
        times(im, b);
        return Complex(re.dot(a) + im.dot(b), re.dot(b) - im.dot(a));
    };
    const Complex m = form([&](const VecX& y, VecX& out) { mass_of(y, out); });
    const Complex c = form([&](const VecX& y, VecX& out) { damping_of(y, out); });
    const Complex k = form([&](const VecX& y, VecX& out) { stiffness_of(y, out); });
    const Complex half = -0.5 * c / m, root = std::sqrt(half * half - k / m);
    const Complex one = half + root, other = half - root;
    const Complex best = std::abs(one - s) < std::abs(other - s) ? one : other;
    return std::abs(best - s) <= 1e-3 * std::abs(s) ? best : s;
}

} // namespace gudgeon
