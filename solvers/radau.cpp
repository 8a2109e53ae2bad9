// Radau IIA: start, error estimate, acceptance, step, dense output.

#include "solvers/radau.hpp"

#include "core/parallel.hpp"
#include "solvers/bdf_history.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/radau_coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gudgeon {

namespace {
constexpr int order = 5;
constexpr double safety = 0.9;
constexpr double keep_from = 1.0, keep_to = 1.2; // a new step within these factors is not worth new matrices
constexpr double below_failed = 0.8;             // of a step that did not converge: the longest tried again
constexpr double forgetting = 0.005;             // growth of that bound, more with every step
constexpr double most_foreseen = 5;       // of a step, over which the last polynomial foresees contacts
constexpr double good_contraction = 1e-3; // better: the derivatives are kept for the next step
} // namespace

Radau::Radau(const System& system, const IntegratorOptions& options)
    : ImplicitIntegrator(system, options), complex_(saddle_options(formulation_, options.threads)) {
    const Eigen::Index n = system.velocities(), m = system.row_count(), speeds = coordinates_->speeds();
    if (auto* real = dynamic_cast<AugmentedSolver*>(&solver_))
        pair_ = std::make_unique<AugmentedPairSolver>(*real);
    analyse_complex();
    for (int i = 0; i < stages; ++i) {
        for (auto* x : {&V_, &Z_, &X_, &last_V_, &last_Z_})
            (*x)[i] = VecX::Zero(speeds);
        lambda_[i] = last_lambda_[i] = VecX::Zero(m);
        stage_rhs_[i] = VecX::Zero(n + 2 * m);
        power_[i] = VecX::Zero(work_count(system));
        for (auto* x : {&z_, &last_z_, &source_i_, &decay_i_})
            (*x)[i] = VecX::Zero(system.friction_states());
    }
    z_matrix_decay_ = z_step_ = error_z_ = VecX::Zero(system.friction_states());
    complex_rhs_.assign(2 * (n + m), 0.0);
    complex_turn_.assign(n + m, 0.0);
    q_stage_ = q_end_ = VecX::Zero(coordinates_->coordinates());
    for (VecX* x : {&u_stage_, &u_end_, &speeds_, &slope_, &error_u_, &error_q_, &rate_})
        *x = VecX::Zero(speeds);
    for (VecX* x : {&momentum_, &f_start_})
        *x = VecX::Zero(n);
}

void Radau::analyse_complex() {
    if (pair_)
        pair_->analyse(saddle_.pattern());
    else if (auto structure = static_cast<BlockSolver&>(solver_).shared_structure())
        complex_.analyse(std::move(structure));
    else
        complex_.analyse(saddle_.pattern());
    complex_values_.assign(saddle_.pattern().nonzeros(), 0.0);
}

void Radau::soften() {
    ImplicitIntegrator::soften();
    analyse_complex();
    failed_h_ = std::numeric_limits<double>::infinity();
}

void Radau::start(const State& state) {
    State closed = state;
    VecX acceleration, x_rate;
    coordinates_->load(state, x_, w_);
    coordinates_->store(x_, w_, closed);
    begin(closed, acceleration);
    mass_times(system_, acceleration, f_start_);
    coordinates_->set_motion(x_, w_, ws_);
    coordinates_->rates(x_, w_, acceleration, x_rate, slope_);
    coordinates_->take_out_products(f_start_);
    find_state_rates(state_.t);
    previous_ = state_;
    previous_x_ = x_;
    previous_w_ = w_;
    have_last_ = matrix_current_ = false;
    matrix_h_ = 0;
    full_h_ = 0;
    contraction_ = 0.1;
    failed_h_ = std::numeric_limits<double>::infinity();
    h_ = first_step(acceleration);
}

// Of the step being tried only what the next one may read of it: its last slopes and decays.
void Radau::visit(Archive& archive) {
    ImplicitIntegrator::visit(archive);
    if (!goes_on_exactly())
        return;
    archive(complex_, previous_, x_, w_, previous_x_, previous_w_, last_bodies_, slope_, f_start_,
            z_matrix_decay_, power_, last_V_, last_Z_, last_lambda_, last_z_, last_lambda_start_, last_h_,
            matrix_h_, matrix_t_, contraction_, last_error_, failed_h_, steps_since_failure_, sweeps_,
            step_tried_, have_last_, matrix_current_);
}

// As for an explicit method of low order: a hundredth of the time in which the state changes by its size.
double Radau::first_step(const VecX& acceleration) const {
    VecX q_rate;
    coordinate_rates(system_, state_.q, state_.u, q_rate);
    const double slope = std::max(norm_.rates(q_rate, acceleration).norm, norm_.states(z_rate_).norm);
    double h =
        slope > 0 ? std::pow(options_.rtol, 0.25) * norm_.rates(state_.q, state_.u).norm / slope : 1e-2;
    h = std::min(h, 1e-2);
    return options_.step > 0 ? std::min(h, options_.step) : h;
}

StepOutcome Radau::attempt(double t_stop, bool& accepted) {
    Trial trial = next_trial(t_stop);
    if (!watch_.idle() && have_last_ && trial.h <= most_foreseen * last_h_)
        end_at_contact(trial);
    const auto [t, h, last] = trial;
    predict(h);
    const bool renewed = !matrix_current_;
    Corrector result = correct(state_.t, h);
    const bool exact = result == Corrector::slow && renewed && soft();
    if (exact)
        result = correct_exactly(state_.t, h);
    if (softened(result, h)) {
        matrix_current_ = false;
        return {};
    }
    if (result != Corrector::converged) {
        if (result == Corrector::slow && !renewed) {
            matrix_current_ = false; // the same step with new derivatives
            return {};
        }
        count_rejection(reason_of(result), t, order, increment_.norm);
        full_h_ = 0;
        matrix_current_ = false;
        contraction_ = 0.1;
        if (soft()) {
            h_ = other_landing(h);
        } else {
            failed_h_ = h;
            steps_since_failure_ = 0;
            h_ = (result == Corrector::slow ? 0.5 : 0.25) * h;
        }
        if (rejections_in_row_ > 30 || h_ < smallest_step())
            return failure(reason_of(result), "the corrector did not converge");
        return {};
    }
    error_ = estimate_error(state_.t, h);
    if (soft() && error_.norm > 1)
        error_ = free_error(h);
    const double work = safety * 21.0 / (sweeps_ + 20.0);
    double quotient = 5; // an error that is no number
    if (std::isfinite(error_.norm))
        quotient = std::clamp(std::pow(std::max(error_.norm, 1e-12), 0.25) / work, 1.0 / 8, 5.0);
    if (!std::isfinite(error_.norm))
        note_bad_number(state_.t);
    if (!(error_.norm < 1)) {
        count_rejection(StepReason::error_test, t, order, error_.norm);
        full_h_ = 0; // the longer step would fail too
        h_ = have_last_ ? h / std::max(quotient, 1.1) : 0.1 * h;
        if (contraction_ > good_contraction)
            matrix_current_ = false;
        if (rejections_in_row_ > 30)
            return failure(StepReason::error_test, "the error test failed again and again");
        return {};
    }
    if (!watch_.idle()) {
        step_tried_ = h;
        ws_.z = z_[2];
        note_bodies();
        set_end_motion();
        if (contact_too_deep(trial, order))
            return {};
    }
    const bool cut = h < h_;  // at t_stop: says nothing against the longer step
    if (have_last_ && !cut) { // predictive control (Gustafsson 1994)
        const double predicted =
            (last_h_ / h) * std::pow(error_.norm * error_.norm / last_error_, 0.25) / safety;
        quotient = std::max(quotient, std::clamp(predicted, 1.0 / 8, 5.0));
    }
    last_error_ = std::max(error_.norm, 1e-2);
    accept(t, h, error_.norm);
    double next = h / quotient;
    if (rejections_in_row_ > 0)
        next = std::min(next, h);
    rejections_in_row_ = 0;
    failed_h_ *= 1 + forgetting * ++steps_since_failure_;
    next = std::min(next, below_failed * failed_h_);
    const bool keep = !exact && (contraction_ <= good_contraction || (sweeps_ == 1 && contraction_ < 0.1));
    if (!keep)
        matrix_current_ = false;
    if (keep && next >= keep_from * h && next <= keep_to * h && !last)
        next = h;
    if (!cut || quotient > 1)
        h_ = next;
    if (const double follow = watch_.suggested_step(); std::isfinite(follow))
        h_ = std::min(std::max(h_, full_h_), follow);
    else
        h_ = std::max(h_, full_h_);
    full_h_ = 0;
    accepted = true;
    return {};
}

// The last accepted state of a body moved by a step along T(q).
void Radau::put_beyond(int body, const Vec6& step, const Vec6& u, BodyMotion& out) const {
    Eigen::Matrix<double, 7, 1> q;
    q << state_.q.segment<3>(7 * body) + step.head<3>(),
        turned(state_.q.segment<4>(7 * body + 3), step.tail<3>());
    set_body_motion(q, u, out);
}

void Radau::motion_carried_on(double t, int body, BodyMotion& out) const {
    const RadauCoefficients& k = radau_coefficients();
    const std::array<double, 4> nodes{0, k.c[0], k.c[1], 1};
    std::array<double, 4> w{};
    interpolation_weights(nodes, 1 + (t - state_.t) / last_h_, w.data());
    if (on_tree())
        return put_between(last_bodies_, w, body, out);
    w[3] -= 1; // from the end of the step on
    Vec6 step = Vec6::Zero(), u = state_.u.segment<6>(6 * body);
    for (int i = 0; i < stages; ++i) {
        step += w[i + 1] * last_Z_[i].segment<6>(6 * body);
        u += w[i + 1] * last_V_[i].segment<6>(6 * body);
    }
    put_beyond(body, step, u, out);
}

void Radau::carry_on(double t) {
    constexpr std::ptrdiff_t grain = 256;
    for_ranges(system_.moving, options_.threads, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (int i = static_cast<int>(begin); i < end; ++i)
            motion_carried_on(t, i, ws_.motion[i]);
    });
}

void Radau::motion_in_step(double t, int body, BodyMotion& out) const {
    const RadauCoefficients& k = radau_coefficients();
    const std::array<double, 4> nodes{0, k.c[0], k.c[1], 1};
    std::array<double, 4> w{};
    interpolation_weights(nodes, (t - state_.t) / step_tried_, w.data());
    if (on_tree())
        return put_between(bodies_, w, body, out);
    Vec6 step = Vec6::Zero(), u = state_.u.segment<6>(6 * body);
    for (int i = 0; i < stages; ++i) {
        step += w[i + 1] * Z_[i].segment<6>(6 * body);
        u += w[i + 1] * V_[i].segment<6>(6 * body);
    }
    put_beyond(body, step, u, out);
}

// The motion of the bodies at the start and the stages of the step being tried.
void Radau::note_bodies() {
    if (!on_tree())
        return;
    bodies_[0].q = state_.q;
    bodies_[0].u = state_.u;
    for (int i = 0; i < stages; ++i) {
        stage_coordinates(i, q_stage_);
        u_stage_ = w_ + V_[i];
        coordinates_->store(q_stage_, u_stage_, bodies_[i + 1]);
    }
}

void Radau::put_between(const BodyStages& bodies, const std::array<double, 4>& w, int body,
                        BodyMotion& out) const {
    Eigen::Matrix<double, 7, 1> q = Eigen::Matrix<double, 7, 1>::Zero();
    Vec6 u = Vec6::Zero();
    for (int i = 0; i <= stages; ++i) {
        q += w[i] * bodies[i].q.segment<7>(7 * body);
        u += w[i] * bodies[i].u.segment<6>(6 * body);
    }
    set_body_motion(q, u, out);
}

// K(gamma/h) (e_u, .) = (f - G^T lambda at the start + M sum e_i V_i / h - S (h/gamma) r, 0) with
// r = u + sum e_i Z_i / h; e_q = (h/gamma) (r + e_u). Friction states are eliminated likewise: with
// r_z = z' + sum e_i (z_i - z) / h the forces are those at z + r_z/(gamma/h + decay), to which e_z adds the
// change of z' with the velocities. In joint coordinates forces are less M times the velocity products.
ErrorNorm::Value Radau::estimate_error(double t, double h) {
    const PhaseTimer timer(statistics_.seconds.solve);
    const RadauCoefficients& k = radau_coefficients();
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    const double lag = h / k.real_eigenvalue;
    const auto weighted = [&](const std::array<VecX, stages>& x) {
        return (k.error_weights[0] * x[0] + k.error_weights[1] * x[1] + k.error_weights[2] * x[2]) / h;
    };
    const auto take_out_stiffness = [&](const VecX& w) {
        coordinates_->velocities_of(w, pose_change_);
        blocks_times(system_, ws_.lin.S, pose_change_, pushed_);
        momentum_ -= lag * pushed_;
    };
    coordinates_->go_to(x_, w_);
    rate_ = w_ + weighted(Z_);
    speeds_ = weighted(V_);
    coordinates_->velocities_of(speeds_, momentum_);
    mass_times(system_, momentum_, momentum_);
    take_out_stiffness(rate_);
    ErrorNorm::Value error;
    if (has_states()) {
        z_step_ = (k.error_weights[0] * (z_[0] - state_.z) + k.error_weights[1] * (z_[1] - state_.z) +
                   k.error_weights[2] * (z_[2] - state_.z)) /
                  h;
    }
    for (int pass = 0; pass < 2; ++pass) {
        rhs_.head(n) = momentum_ + f_start_;
        if (pass == 0 && has_states()) {
            error_z_ = (z_rate_ + z_step_).array() / (1 / lag + z_matrix_decay_.array());
            ws_.z = state_.z + error_z_;
            start_forces();
            rhs_.head(n) = momentum_ + ws_.f;
        }
        if (pass == 1) { // filtered once more, with the forces at the estimate (Hairer & Wanner, IV.8.20)
            take_out_stiffness(error_u_);
            q_stage_ = x_;
            coordinates_->shift(error_q_, q_stage_);
            u_stage_ = w_ + error_u_;
            coordinates_->set_motion(q_stage_, u_stage_, ws_);
            if (has_states()) {
                ws_.z = state_.z + error_z_;
                state_terms(system_, t, ws_, source_, decay_);
                error_z_ = (source_ - decay_.cwiseProduct(ws_.z) + z_step_).array() /
                           (1 / lag + z_matrix_decay_.array());
                ws_.z += error_z_;
            }
            ws_.lambda = state_.lambda;
            evaluate_forces(system_, t, ws_);
            evaluate_constraints(system_, t, state_.lambda.data(), false, ws_);
            coordinates_->take_out_products(ws_.f);
            ++statistics_.evaluations;
            rate_ += error_u_;
            rhs_.head(n) = momentum_ + ws_.f;
        }
        rhs_.segment(n, m).setZero();
        solver_.solve({rhs_.data(), static_cast<std::size_t>(n + m)}, 1);
        coordinates_->speeds_of(rhs_, error_u_);
        error_q_ = lag * (rate_ + error_u_);
        error = coordinates_->measure(norm_, error_q_, error_u_);
        if (has_states())
            error = ErrorNorm::worse(error, state_error(t, lag));
        if (error.norm < 1 || (have_last_ && rejections_in_row_ == 0))
            break;
    }
    return error;
}

// Adds the change of z' with the velocity error to error_z_ (motion: that of the start).
ErrorNorm::Value Radau::state_error(double t, double lag) {
    u_stage_ = w_ + error_u_;
    coordinates_->set_motion(x_, u_stage_, ws_);
    state_terms(system_, t, ws_, source_, decay_);
    error_z_.array() +=
        (source_ - decay_.cwiseProduct(state_.z) - z_rate_).array() / (1 / lag + z_matrix_decay_.array());
    return norm_.states(error_z_);
}

// ws_.f with reactions at the start of the step and the friction states of ws_.z.
void Radau::start_forces() {
    coordinates_->set_motion(x_, w_, ws_);
    ws_.lambda = state_.lambda;
    evaluate_forces(system_, state_.t, ws_);
    evaluate_constraints(system_, state_.t, state_.lambda.data(), false, ws_);
    coordinates_->take_out_products(ws_.f);
    ++statistics_.evaluations;
}

void Radau::accept(double t, double h, double error) {
    count_acceptance(t, h, order, error);
    landings_ = 0;
    if (soft())
        for (VecX& lambda : lambda_)
            drop_idle_part(lambda);
    const RadauCoefficients& k = radau_coefficients();
    previous_ = state_;
    std::swap(previous_x_, x_);
    std::swap(previous_w_, w_);
    {
        const PhaseTimer timer(statistics_.seconds.evaluate);
        for (int i = 0; i < stages; ++i) {
            q_stage_ = previous_x_;
            coordinates_->shift(Z_[i], q_stage_);
            u_stage_ = previous_w_ + V_[i];
            coordinates_->set_motion(q_stage_, u_stage_, ws_);
            ws_.z = z_[i];
            powers(system_, state_.t + k.c[i] * h, lambda_[i].data(), ws_, power_[i]);
            state_.work += h * k.A(2, i) * power_[i];
        }
        x_ = q_stage_;
        w_ = u_stage_;
        coordinates_->store(x_, w_, state_);
        state_.lambda = lambda_[2];
        state_.z = z_[2];
        state_.t = t;
        update_angles(system_, t, ws_, ws_.angles);
        state_.angles = ws_.angles;
    }
    {
        const PhaseTimer timer(statistics_.seconds.contact);
        watch_.commit(t - h, t, state_, ws_);
    }
    {
        const PhaseTimer timer(statistics_.seconds.evaluate);
        ws_.lambda = state_.lambda;
        evaluate_forces(system_, t, ws_);
        evaluate_constraints(system_, t, state_.lambda.data(), false, ws_);
        ++statistics_.evaluations;
        f_start_ = ws_.f;
        coordinates_->take_out_products(f_start_);
        if (soft()) { // M u' of the collocation: multipliers next to a singular position are less exact
            f_start_ =
                (k.A_inverse(2, 0) * V_[0] + k.A_inverse(2, 1) * V_[1] + k.A_inverse(2, 2) * V_[2]) / h;
            mass_times(system_, f_start_, f_start_);
        }
        find_state_rates(t);
    }
    const PhaseTimer timer(statistics_.seconds.control);
    for (int i = 0; i < stages; ++i) {
        std::swap(last_V_[i], V_[i]);
        std::swap(last_Z_[i], Z_[i]);
        std::swap(last_lambda_[i], lambda_[i]);
        std::swap(last_z_[i], z_[i]);
    }
    if (on_tree() && !watch_.idle())
        std::swap(last_bodies_, bodies_);
    last_h_ = h;
    have_last_ = true;
    norm_.set_scale(state_.q, state_.u, state_.z);
}

void Radau::interpolate(double t, State& out) const {
    const RadauCoefficients& k = radau_coefficients();
    const double s = (t - previous_.t) / last_h_;
    const std::array<double, 4> nodes{0, k.c[0], k.c[1], 1};
    std::array<double, 4> w{};
    interpolation_weights(nodes, s, w.data());
    out = previous_;
    out.t = t;
    VecX x = previous_x_;
    coordinates_->shift(w[1] * last_Z_[0] + w[2] * last_Z_[1] + w[3] * last_Z_[2], x);
    coordinates_->store(x, previous_w_ + (w[1] * last_V_[0] + w[2] * last_V_[1] + w[3] * last_V_[2]), out);
    if (has_states())
        out.z = w[0] * previous_.z + w[1] * last_z_[0] + w[2] * last_z_[1] + w[3] * last_z_[2];
    out.lambda = state_.lambda;
    out.angles = state_.angles;
    out.contacts = state_.contacts;
    watch_.memory_inside(out.contacts);
    out.history = state_.history;
    integration_weights(k.c, 0, s, w.data());
    for (int i = 0; i < stages; ++i)
        out.work += last_h_ * w[i] * power_[i];
}

const Statistics& Radau::statistics() const {
    ImplicitIntegrator::statistics();
    const LinearSolverCounts& counts = pair_ ? pair_->counts() : complex_.counts();
    statistics_.factorisations += counts.factorisations;
    statistics_.refactorisations += counts.refactorisations;
    statistics_.cholmod_solves += counts.cholmod_solves;
    statistics_.cholmod_iterations += counts.cholmod_iterations;
    statistics_.klu_fallbacks += counts.klu_fallbacks;
    statistics_.nnz_factors += pair_ ? pair_->factor_nonzeros() : complex_.factor_nonzeros();
    return statistics_;
}

std::unique_ptr<Integrator> make_radau(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Radau>(system, options);
}

} // namespace gudgeon
