// The stage equations of Radau IIA by Newton's method with the derivatives of every stage: for steps across
// singular positions, where the sweeps with one matrix diverge.

#include "solvers/exact_step.hpp"
#include "solvers/radau.hpp"
#include "solvers/radau_coefficients.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace gudgeon {

// Rotations: theta' = B(theta) w, so a turn p of the stage in its own axes changes theta by B p.
void Radau::couple_stages(double h) {
    const RadauCoefficients& k = radau_coefficients();
    exact_->couple(k.A_inverse / h, h * k.A);
    for (int b = 0; b < system_.moving; ++b) {
        std::array<Mat3, stages> B, slope;
        for (int j = 0; j < stages; ++j) {
            const Vec3 theta = Z_[j].segment<3>(6 * b + 3);
            const Vec3 w = state_.u.segment<3>(6 * b + 3) + V_[j].segment<3>(6 * b + 3);
            const double c = rotation_vector::curvature(theta);
            const Mat3 turn = skew(theta);
            B[j] = Mat3::Identity() + 0.5 * turn + c * turn * turn;
            slope[j] = (-0.5 * skew(w) - c * (skew(theta.cross(w)) + turn * skew(w))) * B[j];
        }
        for (int i = 0; i < stages; ++i) {
            const Mat3 inverse = B[i].inverse();
            for (int j = 0; j < stages; ++j) {
                exact_->rate_turn(i, j, b) = h * k.A(i, j) * inverse * B[j];
                exact_->pose_turn(i, j, b) = -h * k.A(i, j) * inverse * slope[j];
            }
            exact_->pose_turn(i, i, b) += Mat3::Identity();
        }
    }
}

// Residuals and derivatives of all stages; the largest open constraints.
void Radau::linearise_stages(double t, double h) {
    const RadauCoefficients& k = radau_coefficients();
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    phi_worst_ = rate_worst_ = 0;
    for (int i = 0; i < stages; ++i) {
        const double at = t + k.c[i] * h;
        stage_residual(i, at, h);
        phi_worst_ = std::max(phi_worst_, largest(ws_.phi));
        rate_worst_ = std::max(rate_worst_, largest(ws_.rate));
        const PhaseTimer timer(statistics_.seconds.assemble);
        linearise(system_, at, lambda_[i].data(), ws_);
        evaluate_rate_rows(system_, at, ws_);
        exact_->set_stage(i, ws_);
        exact_->velocities(i) = stage_rhs_[i].head(n);
        exact_->poses(i).setZero();
        exact_->multipliers(i) = stage_rhs_[i].segment(n, m);
        exact_->position_multipliers(i) = stage_rhs_[i].tail(m);
    }
    couple_stages(h);
}

// Adds a solution to the stages; increment_: its size.
void Radau::move_stages() {
    increment_ = {};
    for (int i = 0; i < stages; ++i) {
        V_[i] += exact_->velocities(i);
        lambda_[i] += exact_->multipliers(i);
        exact_->drift(i, exact_->position_multipliers(i), momentum_);
        for (int b = 0; b < system_.moving; ++b) {
            X_[i].segment<3>(6 * b) += momentum_.segment<3>(6 * b);
            const Vec3 theta = Z_[i].segment<3>(6 * b + 3), turn = momentum_.segment<3>(6 * b + 3),
                       half = 0.5 * theta.cross(turn);
            X_[i].segment<3>(6 * b + 3) +=
                turn + half + 2 * rotation_vector::curvature(theta) * theta.cross(half);
        }
        increment_ = ErrorNorm::worse(increment_,
                                      norm_.increment(exact_->poses(i).data(), exact_->velocities(i).data()));
    }
}

// From the predicted motion and no multipliers: the equations are linear in these, and near a singular
// position, where they grow as one over the distance, any predicted ones would only mislead.
Radau::Corrector Radau::correct_exactly(double t, double h) {
    if (!exact_)
        exact_ = std::make_unique<StageMatrix>(system_, stages);
    exact_->start_over();
    predict(h);
    for (VecX& lambda : lambda_)
        lambda.setZero();
    if (!turn_to_velocities(h))
        return Corrector::slow;
    if (has_states()) {
        z_.fill(state_.z);
        settle_states(t, h);
    }
    const auto apply = [&] {
        move_stages();
        if (!std::isfinite(increment_.norm) || !turn_to_velocities(h))
            return false;
        if (has_states())
            settle_states(t, h);
        return true;
    };
    const Corrector result = iterate_exactly(
        *exact_, sweeps_, [&] { linearise_stages(t, h); }, apply);
    return result == Corrector::converged ? finish_exactly(t, h) : result;
}

// The error estimate needs the real matrix; the next step begins with new derivatives.
Radau::Corrector Radau::finish_exactly(double t, double h) {
    stage_coordinates(2, q_end_);
    u_end_ = state_.u + V_[2];
    contraction_ = 0.1;
    matrix_t_ = t + radau_coefficients().c[1] * h;
    return refresh_real_matrix(h);
}

// As Gear::free_error(), of the estimate at hand, at the middle stage.
ErrorNorm::Value Radau::free_error(double h) {
    if (refresh_real_matrix(h) != Corrector::converged || !factor_nearly_hard())
        return error_;
    keep_free_part(error_q_);
    keep_free_part(error_u_);
    const ErrorNorm::Value error = norm_.increment(error_q_.data(), error_u_.data());
    return has_states() ? ErrorNorm::worse(error, norm_.states(error_z_)) : error;
}

} // namespace gudgeon
