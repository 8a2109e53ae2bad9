#include "solvers/implicit_integrator.hpp"

#include "core/bad_numbers.hpp"
#include "solvers/block_solver.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/singular_position.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gudgeon {

namespace {
constexpr double position_target = 2e-11; // m, rad
constexpr double velocity_target = 8e-11; // m/s, rad/s
constexpr int failures_before_probe = 2;  // of the sweeps, in a row
constexpr double ahead = 8;               // of a step that failed so often: about the first that did
constexpr double nearly_hard = 1e-4;      // of the softness
constexpr int most_failures = 100;        // since the last step that was ...
constexpr double worth_while = 1e-4;      // ... this share of the longest
constexpr double longest_look = 1e-2;     // s, where a method has taken short steps alone ...
constexpr double longest_move = 0.1;      // ... and m or rad
constexpr int most_closings = 10;
constexpr double slow_closing = 0.2; // share left over by a solve: more asks for a new matrix
// Of the smallest step: shorter ones are not shortened any more for a contact that begins too deep.
constexpr double shortest_for_contact = 1e3;
} // namespace

ImplicitIntegrator::ImplicitIntegrator(const System& system, const IntegratorOptions& options)
    : system_(system), options_(options), ws_(make_workspace(system, options.threads)), saddle_(system),
      formulation_(formulation_for(system, options.formulation)),
      linear_(make_saddle_solver(system, formulation_, options.threads)), solver_(*linear_),
      projections_(options.projections ? options.projections : std::make_shared<ConsistentSolver>(system)),
      consistent_(*projections_), norm_(system, options.rtol, options.atol, options.threads),
      coordinates_(make_step_coordinates(system, formulation_, options.threads)), watch_(system, options),
      motion_at_([this](double t, int body, BodyMotion& out) { motion_in_step(t, body, out); }),
      carried_on_([this](double t, int body, BodyMotion& out) { motion_carried_on(t, body, out); }) {
    solver_.analyse(saddle_.pattern());
    values_.assign(saddle_.pattern().nonzeros(), 0.0);
    pose_change_ = pushed_ = VecX::Zero(system.velocities());
    rate_change_ = VecX::Zero(system.row_count());
    turn_ = VecX::Zero(system.velocities() + system.row_count());
    rhs_ = VecX::Zero(2 * (system.velocities() + system.row_count()));
    source_ = decay_ = z_rate_ = VecX::Zero(system.friction_states());
    statistics_.nnz_matrix = saddle_.pattern().nonzeros();
    for (const Joint& joint : system.model.joints)
        driven_ = driven_ || !joint.drives.empty() || system.reaction_friction;
    if (options.redundant)
        ImplicitIntegrator::soften();
}

void ImplicitIntegrator::soften() {
    soft_ = true;
    consistent_.soften();
    saddle_ = SaddleMatrix(system_, Rows::soft);
    solver_.analyse(saddle_.pattern());
    values_.assign(saddle_.pattern().nonzeros(), 0.0);
    statistics_.nnz_matrix = saddle_.pattern().nonzeros();
}

bool ImplicitIntegrator::softened(Corrector result, double h) {
    if (soft_ || on_tree() || system_.row_count() == 0)
        return false;
    if (result == Corrector::singular) {
        ConsistentSolver probe(system_); // forces may be the cause as well
        probe.soften();
        VecX u = state_.u;
        probe.project_velocities(state_.t, state_.q, u, ws_);
        if (probe.deficiency() == 0)
            return false;
    } else if (result != Corrector::slow || rejections_in_row_ != failures_before_probe ||
               singular_rows(system_, state_, std::max(ahead * h, statistics_.largest_step)).empty()) {
        return false;
    }
    soften();
    close_state();
    h_ = ahead * h;
    statistics_.softened_at = state_.t;
    return true;
}

// Independent rows are closed less exactly than soft ones.
void ImplicitIntegrator::close_state() {
    VecX q = state_.q, u = state_.u;
    if (consistent_.project_positions(state_.t, q, u, ws_, 0) &&
        consistent_.project_velocities(state_.t, q, u, ws_)) {
        state_.q = q;
        state_.u = u;
    }
}

// K (., x) = (0, E lambda) gives x = -(N + E)^-1 E lambda, N = G (a M + C + s S)^-1 G^T.
void ImplicitIntegrator::drop_idle_part(VecX& lambda) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    rhs_.head(n).setZero();
    saddle_.soft_times(values_, lambda, rhs_.segment(n, m));
    const PhaseTimer timer(statistics_.seconds.solve);
    solver_.solve({rhs_.data(), static_cast<std::size_t>(n + m)}, 1);
    lambda += rhs_.segment(n, m);
}

void ImplicitIntegrator::put_rows(Eigen::Ref<VecX> velocity, Eigen::Ref<VecX> position) const {
    velocity = -ws_.rate;
    position = -ws_.phi;
    if (const std::vector<bool>* kept = coordinates_->kept_rows())
        for (std::size_t r = 0; r < kept->size(); ++r)
            if ((*kept)[r])
                velocity[r] = position[r] = 0;
}

void ImplicitIntegrator::put_open_rows(Eigen::Ref<VecX> velocity, Eigen::Ref<VecX> position) const {
    put_rows(velocity, position);
    if (soft_ && largest(ws_.rate) <= round_off * (1 + largest(state_.u)))
        velocity.setZero();
    if (soft_ && largest(ws_.phi) <= round_off * (1 + largest(state_.q)))
        position.setZero();
}

// With R = d(G u)/dq: G du = -rate - R dq and G dq = -Phi, dq = q_per_u du + d. The first two columns leave R
// out; a third makes up for it, and takes its share of dq back out of d. On a tree R belongs to the motion of
// its joints.
void ImplicitIntegrator::solve_second_order(double q_per_u, int columns) {
    const PhaseTimer timer(statistics_.seconds.solve);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    if (columns == 2)
        rhs_.tail(m) -= q_per_u * rhs_.segment(n, m);
    solver_.solve({rhs_.data(), static_cast<std::size_t>(columns * (n + m))}, columns);
    if (columns == 1)
        rhs_.tail(n + m).setZero();
    if (m == 0 || on_tree())
        return;
    pose_change_ = rhs_.segment(n + m, n) + q_per_u * rhs_.head(n);
    rate_rows_times(system_, ws_, pose_change_, rate_change_);
    if (largest(rate_change_) <= negligible_rate())
        return;
    turn_.head(n).setZero();
    turn_.tail(m) = -rate_change_;
    solver_.solve({turn_.data(), static_cast<std::size_t>(n + m)}, 1);
    rhs_.head(n + m) += turn_;
    rhs_.segment(n + m, n) -= q_per_u * turn_.head(n);
}

bool ImplicitIntegrator::factor_nearly_hard() {
    const PhaseTimer timer(statistics_.seconds.factor);
    saddle_.scale_softness(nearly_hard, values_);
    return solver_.factor(values_).ok();
}

void ImplicitIntegrator::keep_free_part(VecX& x) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    const PhaseTimer timer(statistics_.seconds.solve);
    for (int pass = 0; pass < 2; ++pass) {
        rows_times(system_, ws_, x, rate_change_);
        rhs_.head(n).setZero();
        rhs_.segment(n, m) = -rate_change_;
        solver_.solve({rhs_.data(), static_cast<std::size_t>(n + m)}, 1);
        x += rhs_.head(n);
    }
}

double ImplicitIntegrator::force_of(const VecX& lambda) {
    pushed_.setZero(system_.velocities());
    add_transposed_rows(system_, ws_, lambda, 1.0, pushed_);
    return largest(pushed_);
}

StepOutcome ImplicitIntegrator::advance(double t_stop) {
    if (statistics_.steps >= options_.max_steps)
        return {false, StepReason::none,
                fmt::format("t = {} s: {} steps were allowed", state_.t, options_.max_steps)};
    bool accepted = false;
    while (!accepted) {
        if (h_ < smallest_step())
            return failure(StepReason::step_too_small, fmt::format("the step fell to {:.3g} s", h_));
        if (options_.step > 0)
            h_ = std::min(h_, options_.step);
        if (StepOutcome outcome = attempt(t_stop, accepted); !outcome.ok)
            return outcome;
        if (soft_ && failures_ > most_failures)
            return failure(StepReason::newton, "the corrector converges at ever shorter steps alone");
    }
    return {};
}

// A step that ends next to a singular position does not converge, however short; a little longer or shorter
// it passes over.
double ImplicitIntegrator::other_landing(double h) {
    constexpr std::array<double, 4> landings{0.75, 0.5, 1.25, 0.35};
    if (landings_ == 0)
        failed_landing_ = h;
    return landings_ < landings.size() ? landings[landings_++] * failed_landing_ : 0.25 * h;
}

ImplicitIntegrator::Trial ImplicitIntegrator::next_trial(double t_stop) const {
    const double t = state_.t + h_;
    if (t >= t_stop || t_stop - t < 1e-3 * h_)
        return {t_stop, t_stop - state_.t, true};
    return {t, h_, false};
}

void ImplicitIntegrator::end_at_contact(Trial& trial) {
    const PhaseTimer timer(statistics_.seconds.contact);
    carry_on(trial.t);
    if (const double end = watch_.foresee(state_.t, trial.t, ws_, carried_on_); end < trial.t) {
        full_h_ = std::max(full_h_, h_);
        trial = {end, end - state_.t, false};
    }
}

bool ImplicitIntegrator::contact_too_deep(const Trial& trial, int order) {
    const PhaseTimer timer(statistics_.seconds.contact);
    const ContactWatch::Verdict verdict = watch_.judge(state_.t, trial.t, ws_, motion_at_);
    if (verdict.ok)
        return false;
    if (trial.h <= shortest_for_contact * smallest_step()) {
        ++statistics_.deep_starts; // the start cannot be resolved in time
        return false;
    }
    count_rejection(StepReason::contact, trial.t, order, error_.norm);
    --rejections_in_row_; // says nothing against step and order
    full_h_ = std::max(full_h_, trial.h);
    h_ = std::max(verdict.end - state_.t, smallest_step());
    return true;
}

const Statistics& ImplicitIntegrator::statistics() const {
    statistics_.factorisations = solver_.counts().factorisations;
    statistics_.refactorisations = solver_.counts().refactorisations;
    statistics_.nnz_factors = solver_.factor_nonzeros();
    statistics_.cholmod_factorisations = solver_.counts().cholmod_factorisations;
    statistics_.cholmod_solves = solver_.counts().cholmod_solves;
    statistics_.cholmod_iterations = solver_.counts().cholmod_iterations;
    statistics_.klu_fallbacks = solver_.counts().klu_fallbacks;
    return statistics_;
}

// Scratch that every use fills first (rhs_, source_, decay_, consistent_) is left out.
void ImplicitIntegrator::visit(Archive& archive) {
    if (!goes_on_exactly()) { // CHOLMOD's factors and passes are not kept: anew from the state, work counted
                              // on
        Statistics statistics = statistics_;
        Integrator::visit(archive);
        archive(statistics);
        statistics_ = statistics;
        return;
    }
    archive.section(name());
    bool rows = soft_, projections = consistent_.soft();
    archive(rows, projections);
    if (archive.reading() && rows && !soft_)
        soften();
    if (archive.reading() && projections)
        consistent_.soften();
    coordinates_->visit(archive);
    archive(statistics_, ws_, static_cast<BlockSolver&>(solver_), norm_, watch_, values_, state_, z_rate_, h_,
            full_h_, phi_worst_, rate_worst_, error_, increment_, rejections_in_row_, failures_);
}

void ImplicitIntegrator::begin(const State& state, VecX& acceleration) {
    saddle_.forget_pattern(); // the solvers have made their own of it
    state_ = state;
    ws_.angles = state.angles;
    ws_.z = state.z;
    ws_.lambda = state.lambda;
    set_motion(system_, state_.q, state_.u, ws_);
    update_angles(system_, state_.t, ws_, ws_.angles);
    state_.angles = ws_.angles;
    watch_.begin(state_, ws_);
    VecX lambda;
    if (consistent_.accelerations(state_.t, state_.q, state_.u, ws_, acceleration, lambda))
        state_.lambda = lambda;
    else
        acceleration = VecX::Zero(system_.velocities());
    norm_.set_scale(state_.q, state_.u, state_.z);
    rejections_in_row_ = 0;
}

void ImplicitIntegrator::find_state_rates(double t) {
    if (!has_states())
        return;
    state_terms(system_, t, ws_, source_, decay_);
    z_rate_ = source_ - decay_.cwiseProduct(ws_.z);
}

double ImplicitIntegrator::smallest_step() const {
    return 16 * std::numeric_limits<double>::epsilon() * std::max(std::abs(state_.t), 1e-3);
}

bool ImplicitIntegrator::close_constraints(double t) {
    phi_worst_ = rate_worst_ = 0;
    if (system_.row_count() == 0)
        return true;
    if (!coordinates_->can_drift()) { // as the last sweep saw them
        phi_worst_ = largest(ws_.phi);
        rate_worst_ = largest(ws_.rate);
        return true;
    }
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= most_closings; ++i) {
        {
            const PhaseTimer timer(statistics_.seconds.evaluate);
            set_end_motion();
            evaluate_constraints(system_, t, nullptr, false, ws_);
        }
        phi_worst_ = largest(ws_.phi);
        rate_worst_ = largest(ws_.rate);
        // near a singular position what stays open moves the mechanism by much more: there to round-off
        const double floor = (soft_ ? round_off : 1e-15) * (largest(end_q()) + largest(end_u()));
        const double target = soft_ ? floor : std::max(position_target, floor);
        const double open = std::max(phi_worst_, position_target / velocity_target * rate_worst_);
        if (open <= target)
            return true;
        if (soft_ && open > 0.5 * last)
            break;
        if (!(open < 1e3 * last))
            return false;
        if (open > slow_closing * last && !renew_matrix(t))
            return false;
        last = open;
        rhs_.setZero();
        put_rows(rhs_.segment(n, m), rhs_.tail(m));
        solve_second_order(q_per_u(), phi_worst_ <= target ? 1 : 2); // the second column closes Phi
        ++statistics_.constraint_polish;
        move_end();
    }
    return phi_worst_ <= closed && rate_worst_ <= closed;
}

void ImplicitIntegrator::count_rejection(StepReason reason, double t, int order, double error) {
    ++rejections_in_row_;
    failures_ += reason != StepReason::error_test && reason != StepReason::contact;
    (reason == StepReason::error_test ? statistics_.rejected_error
     : reason == StepReason::contact  ? statistics_.rejected_contact
                                      : statistics_.rejected_newton)++;
    if (on_step)
        on_step({t, t - state_.t, order, reason, error});
}

void ImplicitIntegrator::count_acceptance(double t, double h, int order, double error) {
    if (on_step)
        on_step({t, h, order, StepReason::none, error});
    if (h >= worth_while * statistics_.largest_step)
        failures_ = 0;
    trouble_.clear();
    ++statistics_.steps;
    ++statistics_.order_histogram[order];
    statistics_.smallest_step = std::min(statistics_.smallest_step, h);
    statistics_.largest_step = std::max(statistics_.largest_step, h);
    statistics_.constraint_position_max = std::max(statistics_.constraint_position_max, phi_worst_);
    statistics_.constraint_velocity_max = std::max(statistics_.constraint_velocity_max, rate_worst_);
}

StepReason ImplicitIntegrator::reason_of(Corrector result) {
    return result == Corrector::singular     ? StepReason::singular
           : result == Corrector::non_finite ? StepReason::non_finite
                                             : StepReason::newton;
}

double ImplicitIntegrator::way_to_look() const {
    const double speed = largest(state_.u);
    return std::max(statistics_.largest_step, std::min(longest_look, longest_move / std::max(speed, 1.0)));
}

StepOutcome ImplicitIntegrator::failure(StepReason reason, const std::string& what) {
    const std::string worst = worst_part();
    std::string singular;
    // sweeps that diverge end in no numbers too, but then no element is to blame
    if (reason != StepReason::non_finite || trouble_.empty())
        if (const std::string rows = singular_rows(system_, state_, way_to_look()); !rows.empty())
            singular = fmt::format(
                "; next to a singular position, where the motion may branch: there {} repeat other "
                "constraints",
                rows);
    return {false, reason, fmt::format("at t = {:.9g} s {}; worst: {}{}", state_.t, what, worst, singular)};
}

void ImplicitIntegrator::note_bad_number(double t) {
    if (std::string found = find_bad_number(system_, t, ws_); !found.empty())
        trouble_ = std::move(found);
}

ImplicitIntegrator::Corrector ImplicitIntegrator::factored(const FactorStatus& status, double t) {
    if (status.ok())
        return Corrector::converged;
    if (status.kind == FactorStatus::Kind::singular) {
        trouble_ = "no pivot for " + unknown_name(system_, status.column);
        return Corrector::singular;
    }
    note_bad_number(t);
    return Corrector::non_finite;
}

std::string ImplicitIntegrator::worst_part() const {
    if (!trouble_.empty())
        return trouble_;
    if (system_.row_count() > 0 && std::max(phi_worst_, rate_worst_) > 1e-8) {
        Eigen::Index row = 0;
        ws_.phi.cwiseAbs().maxCoeff(&row);
        return fmt::format("{}, open by {:.3g}", constraint_name(system_, static_cast<int>(row)),
                           ws_.phi[row]);
    }
    const ErrorNorm::Value& worst = error_.body >= 0 && error_.norm > 1 ? error_ : increment_;
    std::string text = worst.body < 0 ? "no body stands out"
                                      : fmt::format("body '{}' ({})", system_.body_names[worst.body],
                                                    ErrorNorm::component_name(worst.component));
    if (std::string contact = watch_.culprit(worst.body); !contact.empty())
        text += "; contact of " + contact;
    return text;
}

} // namespace gudgeon
