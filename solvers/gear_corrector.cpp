// One implicit step of Gear's method: predictor, Newton sweeps, closing of the constraints.

#include "solvers/gear.hpp"

#include "solvers/phase_timer.hpp"

#include <Eigen/LU>

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

namespace {

constexpr int most_sweeps = 6;
constexpr double newton_share = 0.1;        // of the error limit left to the corrector
constexpr double contraction_ageing = 1.3;  // per step: what was measured long ago may no longer hold
constexpr double slow_contraction = 0.3;    // above, the matrix is renewed for the next step
constexpr double constraint_target = 2e-11; // m, rad: closed after the corrector converged
constexpr double velocity_target = 8e-11;   // m/s, rad/s
constexpr int most_polish = 10;

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

} // namespace

void Gear::predict(double t) {
    const PhaseTimer timer(statistics_.seconds.control);
    std::array<double, BdfHistory::capacity> w{};
    interpolation_weights(history_.times(order_ + 1), t, w.data());
    history_.combine(order_ + 1, w.data(), q_predicted_, u_predicted_);
    for (int i = 0; i < system_.moving; ++i)
        q_predicted_.segment<4>(7 * i + 3).normalize();
    a0_ = bdf_weights(history_.times(order_), t, a_.data());
    history_.combine(order_, a_.data(), beta_q_, beta_u_);
    history_.next_q() = q_predicted_;
    history_.next_u() = u_predicted_;
    // multipliers too: with an old matrix, G^T (lambda - predicted) is turned wrongly
    const int n = std::min(order_ + 1, real_points_);
    interpolation_weights(history_.times(n), t, w.data());
    history_.combine_lambda(n, w.data(), history_.next_lambda());
    drift_.setZero();
    for (int i = 0; i < system_.moving; ++i)
        turn_to_velocity(i, step_.data() + 6 * std::ptrdiff_t(i));
}

// Moves q so that the BDF slope of q is T (u + a0 drift), drift being the position corrections so far;
// step: how far it went along T.
void Gear::turn_to_velocity(int i, double* step) {
    VecX& q = history_.next_q();
    const VecX& u = history_.next_u();
    const Vec3 r = (u.segment<3>(6 * i) - beta_q_.segment<3>(7 * i)) / a0_ + drift_.segment<3>(6 * i);
    const Vec3 dr = r - q.segment<3>(7 * i);
    q.segment<3>(7 * i) = r;
    const Vec4 p = q.segment<4>(7 * i + 3);
    const Vec3 w = u.segment<3>(6 * i + 3);
    const Vec3 defect =
        w + a0_ * drift_.segment<3>(6 * i + 3) - 2 * l_times(p, beta_q_.segment<4>(7 * i + 3));
    const Vec3 half = 0.5 * w; // (a0 + skew(half)) turn = defect, in closed form
    const Vec3 turn = (a0_ * a0_ * defect - a0_ * half.cross(defect) + half.dot(defect) * half) /
                      (a0_ * (a0_ * a0_ + half.squaredNorm()));
    q.segment<4>(7 * i + 3) = turned(p, turn);
    for (int k = 0; k < 3; ++k)
        step[k] = dr[k];
    for (int k = 0; k < 3; ++k)
        step[3 + k] = turn[k];
}

Gear::Corrector Gear::refresh_matrix(double t) {
    {
        const PhaseTimer timer(statistics_.seconds.assemble);
        linearise(system_, t, history_.next_lambda().data(), ws_);
        saddle_.assemble(system_, ws_, a0_, 1 / a0_, values_);
    }
    const PhaseTimer timer(statistics_.seconds.factor);
    matrix_fresh_ = true;
    refresh_wanted_ = false;
    const FactorStatus status = solver_.factor(values_);
    matrix_a0_ = status.ok() ? a0_ : 0;
    return status.ok()                                     ? Corrector::converged
           : status.kind == FactorStatus::Kind::non_finite ? Corrector::non_finite
                                                           : Corrector::singular;
}

// rhs = two columns: momentum and velocity residuals; position residuals.
void Gear::residual(double t) {
    const PhaseTimer timer(statistics_.seconds.evaluate);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    set_motion(system_, history_.next_q(), history_.next_u(), ws_);
    evaluate_forces(system_, t, ws_);
    evaluate_constraints(system_, t, history_.next_lambda().data(), false, ws_);
    ++statistics_.evaluations;
    momentum_ = a0_ * history_.next_u() + beta_u_;
    mass_times(system_, momentum_, momentum_);
    rhs_.head(n) = ws_.f - momentum_;
    rhs_.segment(n, m) = -ws_.rate;
    rhs_.segment(n + m, n).setZero();
    rhs_.tail(m) = -ws_.phi;
}

void Gear::apply_increment() {
    const PhaseTimer timer(statistics_.seconds.control);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    history_.next_u() += rhs_.head(n);
    history_.next_lambda() += rhs_.segment(n, m);
    drift_ += rhs_.segment(n + m, n);
    for (int i = 0; i < system_.moving; ++i)
        turn_to_velocity(i, step_.data() + 6 * std::ptrdiff_t(i));
    increment_ = norm_.increment(step_.data(), rhs_.data());
}

Gear::Corrector Gear::correct(double t) {
    double last = 0;
    contraction_ = std::min(0.9, contraction_ageing * contraction_);
    const bool stale = matrix_a0_ == 0 || refresh_wanted_ || std::abs(a0_ / matrix_a0_ - 1) > 0.25;
    for (int sweep = 1; sweep <= most_sweeps; ++sweep) {
        residual(t);
        if (sweep == 1) {
            matrix_fresh_ = false;
            if (stale)
                if (const Corrector status = refresh_matrix(t); status != Corrector::converged)
                    return status;
        }
        ++statistics_.newton_sweeps;
        {
            const PhaseTimer timer(statistics_.seconds.solve);
            solver_.solve({rhs_.data(), static_cast<std::size_t>(rhs_.size())}, 2);
        }
        apply_increment();
        if (!std::isfinite(increment_.norm))
            return Corrector::non_finite;
        if (sweep > 1) {
            const double ratio = increment_.norm / last;
            contraction_ = std::max(0.3 * contraction_, ratio);
            if (ratio > 2 || (ratio > 0.9 && increment_.norm > newton_share))
                return Corrector::slow;
        }
        last = increment_.norm;
        const double rate = std::min(contraction_, 0.9);
        if (increment_.norm * rate / (1 - rate) <= newton_share || increment_.norm <= 1e-3 * newton_share) {
            if (sweep > 1 && contraction_ > slow_contraction)
                refresh_wanted_ = !matrix_fresh_;
            return close_constraints(t) ? Corrector::converged : Corrector::slow;
        }
    }
    return Corrector::slow;
}

// Position and velocity constraints to round-off: solves of the same matrix without new forces.
bool Gear::close_constraints(double t) {
    phi_worst_ = rate_worst_ = 0;
    if (system_.row_count() == 0)
        return true;
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= most_polish; ++i) {
        {
            const PhaseTimer timer(statistics_.seconds.evaluate);
            set_motion(system_, history_.next_q(), history_.next_u(), ws_);
            evaluate_constraints(system_, t, nullptr, false, ws_);
        }
        phi_worst_ = largest(ws_.phi);
        rate_worst_ = largest(ws_.rate);
        const double round_off = 1e-15 * (largest(history_.next_q()) + largest(history_.next_u()));
        const double open = std::max(phi_worst_, constraint_target / velocity_target * rate_worst_);
        if (open <= std::max(constraint_target, round_off))
            return true;
        if (!(open < 1e3 * last))
            return false;
        // an old matrix turns the corrections: a new one where they help little
        if (open > 0.2 * last && !matrix_fresh_ && refresh_matrix(t) != Corrector::converged)
            return false;
        last = open;
        rhs_.setZero();
        rhs_.segment(n, m) = -ws_.rate;
        rhs_.tail(m) = -ws_.phi;
        {
            const PhaseTimer timer(statistics_.seconds.solve);
            const int columns = phi_worst_ <= constraint_target ? 1 : 2; // the second closes Phi
            solver_.solve({rhs_.data(), static_cast<std::size_t>(columns * (n + m))}, columns);
            if (columns == 1)
                rhs_.tail(m).setZero();
        }
        ++statistics_.constraint_polish;
        apply_increment();
    }
    return phi_worst_ <= 1e-10 && rate_worst_ <= 1e-10;
}

std::string Gear::worst_part() const {
    for (int i = 0; i < system_.moving; ++i) {
        const auto own_blocks = [&](const std::vector<double>& x) {
            return Eigen::Map<const Eigen::Matrix<double, 36, 1>>(x.data() + 36 * std::size_t(i));
        };
        if (!ws_.f.segment<6>(6 * i).allFinite() || !own_blocks(ws_.lin.C).allFinite() ||
            !own_blocks(ws_.lin.S).allFinite())
            return fmt::format("body '{}', whose force or its derivative is no number",
                               system_.body_names[i]);
    }
    if (system_.row_count() > 0 && std::max(phi_worst_, rate_worst_) > 1e-8) {
        Eigen::Index row = 0;
        ws_.phi.cwiseAbs().maxCoeff(&row);
        const RowRecord& r = system_.rows[row];
        return fmt::format("joint '{}' ({}), open by {:.3g}", system_.joints[r.joint].name, r.direction,
                           ws_.phi[row]);
    }
    const int body = error_.body >= 0 && error_.norm > 1 ? error_.body : increment_.body;
    return body < 0 ? "no body stands out" : fmt::format("body '{}'", system_.body_names[body]);
}

} // namespace gudgeon
