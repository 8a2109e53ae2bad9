// One implicit step of Gear's method: predictor, Newton sweeps, closing of the constraints.

#include "solvers/gear.hpp"

#include "core/parallel.hpp"
#include "solvers/phase_timer.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr int most_sweeps = 6;
constexpr double making = 4;               // of a matrix, in sweeps
constexpr double newton_share = 0.1;       // of the error limit left to the corrector
constexpr double contraction_ageing = 1.3; // per step: what was measured long ago may no longer hold
constexpr double multiplier_share = 0.03;  // largest relative change of multipliers in the last sweep
constexpr std::ptrdiff_t grain = 256;      // bodies for a thread
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
    for_ranges(system_.moving, options_.threads, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t i = begin; i < end; ++i) {
            q_predicted_.segment<4>(7 * i + 3).normalize();
            history_.next_q().segment<7>(7 * i) = q_predicted_.segment<7>(7 * i);
            history_.next_u().segment<6>(6 * i) = u_predicted_.segment<6>(6 * i);
            drift_.segment<6>(6 * i).setZero();
            turn_to_velocity(static_cast<int>(i), step_.data() + 6 * i);
        }
    });
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
    set_motion(system_, history_.next_q(), history_.next_u(), ws_);
    VecX& z = history_.next_z();
    z_change_ = z;
    ws_.z = z;
    state_terms(system_, t, ws_, source_, decay_);
    z = (source_ - beta_z_).cwiseQuotient((a0_ + decay_.array()).matrix());
    ws_.z = z;
    z_change_ = z - z_change_;
}

// Moves q so that the BDF slope of q is T (u + a0 drift), drift being the position corrections so far;
// step: how far it went along T.
void Gear::turn_to_velocity(int i, double* step) {
    VecX& q = history_.next_q();
    const VecX& u = history_.next_u();
    const double lag = 1 / a0_;
    const Vec3 r = lag * (u.segment<3>(6 * i) - beta_q_.segment<3>(7 * i)) + drift_.segment<3>(6 * i);
    const Vec3 dr = r - q.segment<3>(7 * i);
    q.segment<3>(7 * i) = r;
    const Vec4 p = q.segment<4>(7 * i + 3);
    const Vec3 w = u.segment<3>(6 * i + 3);
    const Vec3 defect =
        w + a0_ * drift_.segment<3>(6 * i + 3) - 2 * l_times(p, beta_q_.segment<4>(7 * i + 3));
    const Vec3 half = 0.5 * w; // (a0 + skew(half)) turn = defect, in closed form
    const Vec3 turn = (lag / (a0_ * a0_ + half.squaredNorm())) *
                      (a0_ * a0_ * defect - a0_ * half.cross(defect) + half.dot(defect) * half);
    q.segment<4>(7 * i + 3) = turned(p, turn);
    for (int k = 0; k < 3; ++k)
        step[k] = dr[k];
    for (int k = 0; k < 3; ++k)
        step[3 + k] = turn[k];
}

Gear::Corrector Gear::refresh_matrix(double t) {
    {
        const PhaseTimer timer(statistics_.seconds.assemble);
        linearise(system_, t, history_.next_lambda().data(), ws_, 1 / a0_);
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
    // drives take their work, friction its force from the multipliers: then these are wanted to the tolerance
    const double share = driven_ ? std::min(multiplier_share, 10 * options_.rtol) : multiplier_share;
    return change <= share * (size + largest(ws_.f)) + 1e-9;
}

bool Gear::renew_matrix(double t) { return matrix_fresh_ || refresh_matrix(t) == Corrector::converged; }

// rhs = two columns: momentum and velocity residuals; position residuals.
void Gear::residual(double t) {
    const PhaseTimer timer(statistics_.seconds.evaluate);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    set_motion(system_, history_.next_q(), history_.next_u(), ws_);
    ws_.lambda = history_.next_lambda();
    evaluate_forces(system_, t, ws_);
    evaluate_constraints(system_, t, history_.next_lambda().data(), false, ws_);
    ++statistics_.evaluations;
    for_ranges(system_.moving, options_.threads, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t i = begin; i < end; ++i) {
            const Vec6 rate = a0_ * history_.next_u().segment<6>(6 * i) + beta_u_.segment<6>(6 * i);
            rhs_.segment<3>(6 * i) = ws_.f.segment<3>(6 * i) - system_.mass[i] * rate.head<3>();
            rhs_.segment<3>(6 * i + 3) = ws_.f.segment<3>(6 * i + 3) - system_.inertia[i] * rate.tail<3>();
            rhs_.segment<6>(n + m + 6 * i).setZero();
        }
    });
    put_open_rows(rhs_.segment(n, m), rhs_.tail(m));
}

void Gear::move_end() {
    const PhaseTimer timer(statistics_.seconds.control);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    history_.next_lambda() += rhs_.segment(n, m);
    for_ranges(system_.moving, options_.threads, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t i = begin; i < end; ++i) {
            history_.next_u().segment<6>(6 * i) += rhs_.segment<6>(6 * i);
            drift_.segment<6>(6 * i) += rhs_.segment<6>(n + m + 6 * i);
            turn_to_velocity(static_cast<int>(i), step_.data() + 6 * i);
        }
    });
    increment_ = norm_.increment(step_.data(), rhs_.data());
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
        solve_second_order(1 / a0_, 2);
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
