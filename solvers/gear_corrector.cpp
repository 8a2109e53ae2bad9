// One implicit step of Gear's method: predictor, Newton sweeps, closing of the constraints.

#include "solvers/gear.hpp"

#include "solvers/phase_timer.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr int most_sweeps = 6;
constexpr double making = 4;               // of a matrix, in sweeps
constexpr double newton_share = 0.1;       // of the error limit left to the corrector
constexpr double contraction_ageing = 1.3; // per step: what was measured long ago may no longer hold
constexpr double slow_contraction = 0.3;   // above, the matrix is renewed for the next step

} // namespace

void Gear::predict(double t) {
    const PhaseTimer timer(statistics_.seconds.control);
    std::array<double, BdfHistory::capacity> w{};
    interpolation_weights(history_.times(order_ + 1), t, w.data());
    history_.combine(order_ + 1, w.data(), q_predicted_, u_predicted_);
    a0_ = bdf_weights(history_.times(order_), t, a_.data());
    history_.combine(order_, a_.data(), beta_q_, beta_u_);
    // Multipliers too, since with an old matrix G^T (lambda - predicted) is turned wrongly. Their errors are
    // not controlled: a high polynomial would blow them up from step to step faster than the sweeps mend.
    const int n = std::max(1, std::min(lambda_points_, real_points_));
    interpolation_weights(history_.times(n), t, w.data());
    history_.combine_lambda(n, w.data(), history_.next_lambda());
    coordinates_->begin_step(formula(), q_predicted_, u_predicted_, history_.next_q(), history_.next_u());
    if (!has_states())
        return;
    interpolation_weights(history_.times(order_ + 1), t, w.data());
    history_.combine_z(order_ + 1, w.data(), z_predicted_);
    history_.combine_z(order_, a_.data(), beta_z_);
    history_.next_z() = z_predicted_;
    settle_states(t);
}

// Friction states that fit the motion: a0 z + beta = source - decay z, exactly; z_change_: how far they went.
void Gear::settle_states(double t) {
    set_end_motion();
    VecX& z = history_.next_z();
    z_change_ = z;
    ws_.z = z;
    state_terms(system_, t, ws_, source_, decay_);
    z = (source_ - beta_z_).cwiseQuotient((a0_ + decay_.array()).matrix());
    ws_.z = z;
    z_change_ = z - z_change_;
}

Gear::Corrector Gear::refresh_matrix(double t) {
    {
        const PhaseTimer timer(statistics_.seconds.assemble);
        coordinates_->hold();
        linearise(system_, t, history_.next_lambda().data(), ws_, 1 / a0_);
        if (!on_tree())
            evaluate_rate_rows(system_, t, ws_);
        saddle_.assemble(system_, ws_, a0_, 1 / a0_, values_);
    }
    const PhaseTimer timer(statistics_.seconds.factor);
    matrix_fresh_ = true;
    refresh_wanted_ = false;
    matrix_work_ = making;
    matrix_steps_ = 0;
    const FactorStatus status = solver_.factor(values_);
    matrix_a0_ = status.ok() ? a0_ : 0;
    return factored(status, t);
}

// Where few coordinates are free, velocities are right at once, and only this keeps the multipliers from
// running away over the steps.
bool Gear::multipliers_settled() {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    if (m == 0)
        return true;
    // where rows repeat each other only what the multipliers do counts
    const double change = soft() ? force_of(rhs_.segment(n, m)) : largest(rhs_.segment(n, m));
    const double size = soft() ? force_of(history_.next_lambda()) : largest(history_.next_lambda());
    return change <= multiplier_share() * (size + largest(ws_.f)) + 1e-9;
}

bool Gear::renew_matrix(double t) { return matrix_fresh_ || refresh_matrix(t) == Corrector::converged; }

// rhs = two columns: momentum and velocity residuals; position residuals.
void Gear::residual(double t) {
    const PhaseTimer timer(statistics_.seconds.evaluate);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    set_end_motion();
    ws_.lambda = history_.next_lambda();
    evaluate_forces(system_, t, ws_);
    evaluate_constraints(system_, t, history_.next_lambda().data(), false, ws_);
    ++statistics_.evaluations;
    speeds_ = a0_ * history_.next_u() + beta_u_;
    coordinates_->momentum_residual(speeds_, ws_.f, rhs_);
    rhs_.segment(n + m, n).setZero();
    put_open_rows(rhs_.segment(n, m), rhs_.tail(m));
}

void Gear::move_end() {
    const PhaseTimer timer(statistics_.seconds.control);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    history_.next_lambda() += rhs_.segment(n, m);
    const StepCoordinates::Moved moved =
        coordinates_->move(formula(), rhs_.data(), rhs_.data() + n + m, history_.next_q(), history_.next_u());
    increment_ = norm_.increment(moved.poses, moved.velocities);
    if (has_states()) {
        settle_states(t_try_);
        increment_ = ErrorNorm::worse(increment_, norm_.states(z_change_));
    }
}

Gear::Corrector Gear::correct(double t) {
    double last = 0;
    contraction_ = std::min(0.9, contraction_ageing * contraction_);
    const bool stale = matrix_a0_ == 0 || refresh_wanted_ || std::abs(a0_ / matrix_a0_ - 1) > 0.25;
    for (int sweep = 1; sweep <= most_sweeps; ++sweep) {
        residual(t);
        if (!rhs_.allFinite()) {
            note_bad_number(t);
            return Corrector::non_finite;
        }
        if (sweep == 1) {
            matrix_fresh_ = false;
            if (stale)
                if (const Corrector status = refresh_matrix(t); status != Corrector::converged)
                    return status;
        }
        ++statistics_.newton_sweeps;
        solve_second_order(1 / a0_, coordinates_->can_drift() ? 2 : 1);
        move_end();
        if (!std::isfinite(increment_.norm))
            return Corrector::non_finite;
        // near singular positions the second sweep takes back what the first did with unfit multipliers
        if (sweep > (soft() ? 2 : 1)) {
            const double ratio = increment_.norm / last;
            contraction_ = std::max(0.3 * contraction_, ratio);
            if (ratio > 2 || (ratio > 0.9 && increment_.norm > newton_share))
                return Corrector::slow;
        }
        last = increment_.norm;
        const double rate = std::clamp(contraction_, soft() ? 0.7 : 0.0, 0.9);
        if (!multipliers_settled())
            continue;
        if (increment_.norm * rate / (1 - rate) <= newton_share || increment_.norm <= 1e-3 * newton_share) {
            if (sweep > 1 && contraction_ > slow_contraction)
                refresh_wanted_ = !matrix_fresh_;
            return close_constraints(t) ? Corrector::converged : Corrector::slow;
        }
    }
    return Corrector::slow;
}

} // namespace gudgeon
