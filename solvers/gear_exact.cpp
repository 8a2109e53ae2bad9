// A step of Gear's method by Newton's method with new derivatives at every iteration: next to singular
// positions, where sweeps with one matrix diverge.

#include "solvers/exact_step.hpp"
#include "solvers/gear.hpp"

namespace gudgeon {

// Residuals and derivatives at the end of the step as it stands.
void Gear::linearise_end(double t) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    residual(t);
    phi_worst_ = largest(ws_.phi);
    rate_worst_ = largest(ws_.rate);
    const PhaseTimer timer(statistics_.seconds.assemble);
    linearise(system_, t, history_.next_lambda().data(), ws_);
    evaluate_rate_rows(system_, t, ws_);
    exact_->set_stage(0, ws_);
    exact_->couple(MatX::Constant(1, 1, a0_), MatX::Constant(1, 1, 1 / a0_));
    for (int b = 0; b < system_.moving; ++b) { // as in turn_to_velocity()
        exact_->pose_turn(0, 0, b) =
            Mat3::Identity() + skew(0.5 / a0_ * history_.next_u().segment<3>(6 * b + 3));
        exact_->rate_turn(0, 0, b) = Mat3::Identity() / a0_;
    }
    exact_->velocities(0) = rhs_.head(n);
    exact_->poses(0).setZero();
    exact_->multipliers(0) = rhs_.segment(n, m);
    exact_->position_multipliers(0) = rhs_.tail(m);
}

// From the predicted motion and no multipliers: the equations are linear in these, and near a singular
// position, where they grow as one over the distance, any predicted ones would only mislead.
Gear::Corrector Gear::correct_exactly(double t) {
    if (!exact_)
        exact_ = std::make_unique<StageMatrix>(system_, 1);
    exact_->start_over();
    predict(t);
    history_.next_lambda().setZero();
    int iterations = 0;
    const Corrector result = iterate_exactly(
        *exact_, iterations, [&] { linearise_end(t); }, [&] { return take_exact_solution(); });
    return result == Corrector::converged ? finish_exactly(t) : result;
}

bool Gear::take_exact_solution() {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    rhs_.head(n) = exact_->velocities(0);
    rhs_.segment(n, m) = exact_->multipliers(0);
    exact_->drift(0, exact_->position_multipliers(0), momentum_);
    rhs_.segment(n + m, n) = momentum_;
    move_end();
    return true;
}

// Multipliers of such a step predict nothing; the next one begins with a new matrix.
Gear::Corrector Gear::finish_exactly(double t) {
    const Corrector status = refresh_matrix(t);
    matrix_a0_ = 0;
    contraction_ = 0.5;
    lambda_points_ = 0;
    return status;
}

// Round-off r of the constraints leaves about r/sigma^2 in velocities near a singular position. It lies
// across the constraints, so the next step does away with it; but a predictor through such points carries it
// on.
ErrorNorm::Value Gear::free_error(double t, double constant) {
    const bool factored = refresh_matrix(t) == Corrector::converged && factor_nearly_hard();
    matrix_a0_ = 0;
    if (!factored)
        return error_;
    const VecX& q = history_.next_q();
    for (int i = 0; i < system_.moving; ++i) {
        step_.segment<3>(6 * i) = q.segment<3>(7 * i) - q_predicted_.segment<3>(7 * i);
        step_.segment<3>(6 * i + 3) =
            -2 * l_times(q.segment<4>(7 * i + 3), q_predicted_.segment<4>(7 * i + 3));
    }
    momentum_ = history_.next_u() - u_predicted_;
    keep_free_part(step_);
    keep_free_part(momentum_);
    step_ *= constant;
    momentum_ *= constant;
    const ErrorNorm::Value error = norm_.increment(step_.data(), momentum_.data());
    return has_states() ? ErrorNorm::worse(error, norm_.states(z_change_)) : error;
}

} // namespace gudgeon
