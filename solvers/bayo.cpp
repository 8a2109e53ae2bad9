#include "solvers/bayo.hpp"

#include "core/assembly.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/contact_watch.hpp"
#include "solvers/index1_equations.hpp"
#include "solvers/phase_timer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {

constexpr double default_step = 1e-3;
constexpr int most_iterations = 40;
constexpr int most_reaction_passes = 60;
constexpr double settled = 1e-14;    // of the coordinates, per iteration: converged
constexpr double round_off = 1e-11;  // likewise: iterations that no longer shrink have converged
constexpr double slow = 0.2;         // share left over by an iteration: a new matrix, then whole solutions
constexpr double penalty = 1e8;      // of the scaled matrices
constexpr double projection = 1e-12; // residual of the projections, relative

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

/// What is known at one end of a step.
struct Point {
    State state;
    VecX acceleration;
    VecX powers; // as State::work
    VecX z_rate; // of the friction states
};

class Bayo final : public Integrator {
  public:
    Bayo(const System& system, const IntegratorOptions& options);

    const char* name() const override { return "bayo"; }
    const char* linear_solver() const override { return "cholmod"; }
    const char* formulation() const override { return formulation_name(Formulation::augmented_lagrangian); }
    const State& state() const override { return now_.state; }
    Workspace& workspace() override { return ws_; }
    const Statistics& statistics() const override;
    void set_on_contact(std::function<void(const ContactEvent&)> f) override {
        watch_.on_contact = std::move(f);
    }
    void start(const State& state) override;
    StepOutcome advance(double t_stop) override;
    void interpolate(double t, State& out) const override;

  private:
    StepOutcome take_step(double h, double t_end);
    StepOutcome iterate(double h, double t_end);
    void residual(double h, double t_end);
    void settle_states(double h, double t);
    FactorStatus factor_tangent(double h, double t);
    StepOutcome project(double t_end);
    StepOutcome accelerations(Point& point);
    void finish_point(Point& point);
    StepOutcome follow_contacts();
    FactorStatus factor_mass();
    void find_gamma(double t);
    StepOutcome failure(double t, const FactorStatus& status) const;
    std::span<double> unknowns() { return {rhs_.data(), static_cast<std::size_t>(rhs_.size())}; }

    const System& system_;
    const double step_;
    const long max_steps_;
    Workspace ws_;
    SaddleMatrix saddle_;
    AugmentedSolver tangent_, mass_;
    std::vector<double> values_;
    ContactWatch watch_;
    const ContactWatch::MotionAt motion_at_;
    State inside_;              // of the last step, for the watch
    Point before_, now_, next_; // begin and end of the last step; the step being taken
    VecX z_, rhs_, gamma_, row_rate_, momentum_, source_, decay_;
    VecX external_; // loads now_ was evaluated with
    StepOutcome started_;
    mutable Statistics statistics_;
};

Bayo::Bayo(const System& system, const IntegratorOptions& options)
    : system_(system), step_(options.step == 0 ? default_step : options.step), max_steps_(options.max_steps),
      ws_(make_workspace(system, options.threads)), saddle_(system),
      tangent_(system.velocities(), {.penalty = penalty}),
      mass_(system.velocities(), {.penalty = penalty, .tolerance = projection}), watch_(system, options),
      motion_at_([this](double t, int body, BodyMotion& out) {
          interpolate(t, inside_);
          out.r = inside_.q.segment<3>(7 * body);
          out.p = inside_.q.segment<4>(7 * body + 3);
          out.A = rotation(out.p);
          out.v = inside_.u.segment<3>(6 * body);
          out.w = inside_.u.segment<3>(6 * body + 3);
      }) {
    if (!(step_ > 0) || !std::isfinite(step_))
        throw std::invalid_argument(fmt::format("bayo: step {} is not allowed; positive, s", step_));
    tangent_.analyse(saddle_.pattern());
    mass_.analyse(saddle_.pattern());
    values_.assign(saddle_.pattern().nonzeros(), 0.0);
    for (Point* point : {&before_, &now_, &next_}) {
        point->state = initial_state(system);
        point->acceleration = VecX::Zero(system.velocities());
        point->powers = VecX::Zero(work_count(system));
        point->z_rate = VecX::Zero(system.friction_states());
    }
    z_ = momentum_ = VecX::Zero(system.velocities());
    rhs_ = VecX::Zero(system.velocities() + system.row_count());
    gamma_ = row_rate_ = VecX::Zero(system.row_count());
    source_ = decay_ = VecX::Zero(system.friction_states());
    external_ = ws_.external;
    statistics_.nnz_matrix = saddle_.pattern().nonzeros();
}

const Statistics& Bayo::statistics() const {
    const LinearSolverCounts &a = tangent_.counts(), &b = mass_.counts();
    statistics_.factorisations = a.factorisations + b.factorisations;
    statistics_.refactorisations = a.refactorisations + b.refactorisations;
    statistics_.cholmod_factorisations = a.cholmod_factorisations + b.cholmod_factorisations;
    statistics_.cholmod_solves = a.cholmod_solves + b.cholmod_solves;
    statistics_.cholmod_iterations = a.cholmod_iterations + b.cholmod_iterations;
    statistics_.klu_fallbacks = a.klu_fallbacks + b.klu_fallbacks;
    statistics_.nnz_factors = tangent_.factor_nonzeros() + mass_.factor_nonzeros();
    return statistics_;
}

void Bayo::start(const State& state) {
    now_.state = state;
    ws_.angles = state.angles;
    ws_.z = state.z;
    ws_.lambda = state.lambda;
    set_motion(system_, state.q, state.u, ws_);
    watch_.begin(now_.state, ws_);
    started_ = accelerations(now_);
    if (started_.ok)
        finish_point(now_);
    before_ = now_;
}

StepOutcome Bayo::advance(double t_stop) {
    const double t = now_.state.t, remaining = t_stop - t;
    if (remaining <= 0 || !started_.ok)
        return started_;
    if (statistics_.steps >= max_steps_)
        return {false, StepReason::none, fmt::format("t = {} s: {} steps were allowed", t, max_steps_)};
    if (external_ != ws_.external) // loads were set from outside since
        if (StepOutcome outcome = accelerations(now_); !outcome.ok)
            return outcome;
    const bool last = remaining <= step_ * (1 + 1e-9);
    const double h = last ? remaining : step_, t_end = last ? t_stop : t + h;
    const StepOutcome outcome = take_step(h, t_end);
    if (on_step)
        on_step({t_end, h, 2, outcome.reason, 0});
    if (!outcome.ok)
        return outcome;
    ++statistics_.steps;
    ++statistics_.order_histogram[2];
    statistics_.smallest_step = std::min(statistics_.smallest_step, h);
    statistics_.largest_step = std::max(statistics_.largest_step, h);
    std::swap(before_, now_);
    std::swap(now_, next_);
    return watch_.idle() ? outcome : follow_contacts();
}

// A fixed step cannot be rejected: contacts that begin too deep are counted.
StepOutcome Bayo::follow_contacts() {
    State& s = now_.state;
    const bool shallow = watch_.judge(before_.state.t, s.t, ws_, motion_at_, ContactEvent::Kind::deep).ok;
    statistics_.deep_starts += !shallow;
    s.contacts = before_.state.contacts;
    s.history = before_.state.history;
    watch_.commit(before_.state.t, s.t, s, ws_);
    return watch_.changed() ? accelerations(now_) : StepOutcome{};
}

// One step from now_ to next_: trapezoidal rule, then projections.
StepOutcome Bayo::take_step(double h, double t_end) {
    const State& from = now_.state;
    State& to = next_.state;
    to.t = t_end;
    to.contacts = from.contacts;
    to.lambda = from.lambda;
    to.z = from.z;
    to.u = from.u + h * now_.acceleration;
    if (StepOutcome outcome = iterate(h, t_end); !outcome.ok)
        return outcome;
    next_.acceleration = (2 / h) * (to.u - from.u) - now_.acceleration;
    if (StepOutcome outcome = project(t_end); !outcome.ok)
        return outcome;
    finish_point(next_);
    to.work = from.work + (0.5 * h) * (now_.powers + next_.powers);
    return {};
}

// Motion at the end of the step by its velocities, residuals there: momentum, and 2/h Phi.
void Bayo::residual(double h, double t_end) {
    const PhaseTimer timer(statistics_.seconds.evaluate);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    const State& from = now_.state;
    State& to = next_.state;
    z_ = (0.5 * h) * (from.u + to.u);
    to.q = from.q;
    move(system_, z_, to.q);
    set_motion(system_, to.q, to.u, ws_);
    settle_states(h, t_end);
    ws_.lambda = to.lambda;
    evaluate_forces(system_, t_end, ws_);
    evaluate_constraints(system_, t_end, to.lambda.data(), false, ws_);
    ++statistics_.evaluations;
    momentum_ = (2 / h) * (to.u - from.u) - now_.acceleration;
    mass_times(system_, momentum_, momentum_);
    rhs_.head(n) = ws_.f - momentum_;
    rhs_.tail(m) = -(2 / h) * ws_.phi;
}

// 2/h (z1 - z0) - z0' = source - decay z1
void Bayo::settle_states(double h, double t) {
    if (system_.friction_states() == 0)
        return;
    State& to = next_.state;
    ws_.z = to.z;
    state_terms(system_, t, ws_, source_, decay_);
    to.z = ((2 / h) * now_.state.z + now_.z_rate + source_).cwiseQuotient((2 / h + decay_.array()).matrix());
    ws_.z = to.z;
}

FactorStatus Bayo::factor_tangent(double h, double t) {
    {
        const PhaseTimer timer(statistics_.seconds.assemble);
        linearise(system_, t, next_.state.lambda.data(), ws_);
        saddle_.assemble(system_, ws_, 2 / h, h / 2, values_);
    }
    const PhaseTimer timer(statistics_.seconds.factor);
    return tangent_.factor(values_);
}

StepOutcome Bayo::iterate(double h, double t_end) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    State& to = next_.state;
    double last = 0, ratio = 1;
    bool whole = false; // single passes are slow
    for (int i = 0; i < most_iterations; ++i) {
        residual(h, t_end);
        if (i == 0 || ratio > slow) {
            whole = whole || i > 2;
            if (const FactorStatus status = factor_tangent(h, t_end); !status.ok())
                return failure(t_end, status);
        }
        {
            const PhaseTimer timer(statistics_.seconds.solve);
            if (!whole && tangent_.factored_by_cholmod())
                tangent_.pass(unknowns());
            else
                tangent_.solve(unknowns());
        }
        ++statistics_.newton_sweeps;
        to.u += rhs_.head(n);
        to.lambda += rhs_.tail(m);
        const double change = 0.5 * h * largest(rhs_.head(n)), size = 1 + largest(now_.state.q);
        if (!std::isfinite(change))
            break;
        ratio = last > 0 ? change / last : 0;
        if (change <= settled * size || (ratio > slow && change <= round_off * size)) {
            residual(h, t_end);
            return {};
        }
        last = change;
    }
    return {false, StepReason::newton,
            fmt::format("t = {} s: the iteration of a step of {} s did not converge; a smaller step may",
                        t_end, h)};
}

FactorStatus Bayo::factor_mass() {
    {
        const PhaseTimer timer(statistics_.seconds.assemble);
        saddle_.assemble_mass(system_, ws_, 1.0, values_);
    }
    const PhaseTimer timer(statistics_.seconds.factor);
    return mass_.factor(values_);
}

void Bayo::find_gamma(double t) {
    const Evaluation e = evaluation(system_, ws_, t);
    for (const auto& batch : system_.constraints)
        batch->acceleration_rhs(e, gamma_.data());
}

// Velocities, then accelerations, to the nearest that satisfy the constraints in the mass norm.
StepOutcome Bayo::project(double t_end) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    State& to = next_.state;
    if (m == 0)
        return {};
    evaluate_constraints(system_, t_end, nullptr, true, ws_);
    if (const FactorStatus status = factor_mass(); !status.ok())
        return failure(t_end, status);
    const PhaseTimer timer(statistics_.seconds.solve);
    for (int i = 0; i < 2; ++i) { // the second takes round-off out
        rhs_.head(n).setZero();
        rhs_.tail(m) = -ws_.rate;
        mass_.solve(unknowns());
        to.u += rhs_.head(n);
        set_motion(system_, to.q, to.u, ws_);
        evaluate_constraints(system_, t_end, nullptr, false, ws_);
    }
    find_gamma(t_end);
    rows_times(system_, ws_, next_.acceleration, row_rate_);
    rhs_.head(n).setZero();
    rhs_.tail(m) = gamma_ - row_rate_;
    mass_.solve(unknowns());
    next_.acceleration += rhs_.head(n);
    to.lambda += rhs_.tail(m); // now those of the projected accelerations
    return {};
}

// Consistent accelerations and multipliers from the acceleration equations: at a start, and where forces
// jump.
StepOutcome Bayo::accelerations(Point& point) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    State& s = point.state;
    ws_.z = s.z;
    ws_.lambda = s.lambda;
    external_ = ws_.external;
    set_motion(system_, s.q, s.u, ws_);
    evaluate_constraints(system_, s.t, nullptr, true, ws_);
    if (const FactorStatus status = factor_mass(); !status.ok())
        return failure(s.t, status);
    find_gamma(s.t);
    for (int pass = 0; pass < (system_.reaction_friction ? most_reaction_passes : 1); ++pass) {
        evaluate_forces(system_, s.t, ws_);
        ++statistics_.evaluations;
        rhs_.head(n) = ws_.f;
        rhs_.tail(m) = gamma_;
        mass_.solve(unknowns());
        point.acceleration = rhs_.head(n);
        s.lambda = rhs_.tail(m);
        if (largest(s.lambda - ws_.lambda) <= 1e-14 * largest(s.lambda))
            break;
        ws_.lambda = s.lambda;
    }
    return {};
}

// Powers, rates of the friction states, angles and the violations at an end of a step (ws_.motion).
void Bayo::finish_point(Point& point) {
    const PhaseTimer timer(statistics_.seconds.control);
    State& s = point.state;
    ws_.z = s.z;
    ws_.lambda = s.lambda;
    external_ = ws_.external;
    set_motion(system_, s.q, s.u, ws_);
    evaluate_constraints(system_, s.t, nullptr, false, ws_);
    statistics_.constraint_position_max = std::max(statistics_.constraint_position_max, largest(ws_.phi));
    statistics_.constraint_velocity_max = std::max(statistics_.constraint_velocity_max, largest(ws_.rate));
    powers(system_, s.t, s.lambda.data(), ws_, point.powers);
    if (system_.friction_states() > 0) {
        state_terms(system_, s.t, ws_, source_, decay_);
        point.z_rate = source_ - decay_.cwiseProduct(ws_.z);
    }
    update_angles(system_, s.t, ws_, ws_.angles);
    s.angles = ws_.angles;
}

StepOutcome Bayo::failure(double t, const FactorStatus& status) const {
    if (status.kind == FactorStatus::Kind::non_finite)
        return {
            false, StepReason::non_finite,
            fmt::format("t = {} s: the matrix of the step has entries that are no numbers; a smaller step "
                        "than {} s may be stable",
                        t, step_)};
    const int n = system_.velocities();
    return {false, StepReason::singular,
            fmt::format("t = {} s: the matrix of the step has no pivot; first at {}", t,
                        status.column < 0   ? "an unknown place"
                        : status.column < n ? "body " + system_.body_names[status.column / 6]
                                            : row_name(system_, status.column - n))};
}

void Bayo::interpolate(double t, State& out) const {
    const PhaseTimer timer(statistics_.seconds.output);
    const State &a = before_.state, &b = now_.state;
    out = b;
    const double h = b.t - a.t;
    if (!(h > 0) || t >= b.t)
        return;
    const double s = std::max(0.0, (t - a.t) / h), s2 = s * s, r = 1 - s;
    const double c = s2 * (3 - 2 * s), c0 = h * s * r * r, c1 = -h * s2 * r; // Hermite weights
    out.t = t;
    for (int i = 0; i < system_.moving; ++i) {
        const int j = 7 * i, k = 6 * i;
        const Vec4 p0 = a.q.segment<4>(j + 3), p1 = b.q.segment<4>(j + 3);
        const Vec4 v0 = 0.5 * lt_times(p0, a.u.segment<3>(k + 3)),
                   v1 = 0.5 * lt_times(p1, b.u.segment<3>(k + 3));
        out.q.segment<3>(j) = a.q.segment<3>(j) + c * (b.q.segment<3>(j) - a.q.segment<3>(j)) +
                              c0 * a.u.segment<3>(k) + c1 * b.u.segment<3>(k);
        out.q.segment<4>(j + 3) = (p0 + c * (p1 - p0) + c0 * v0 + c1 * v1).normalized();
    }
    out.u = a.u + c * (b.u - a.u) + c0 * before_.acceleration + c1 * now_.acceleration;
    out.lambda = a.lambda + s * (b.lambda - a.lambda);
    if (system_.friction_states() > 0)
        out.z = a.z + c * (b.z - a.z) + c0 * before_.z_rate + c1 * now_.z_rate;
    out.contacts = b.contacts;
    watch_.memory_inside(out.contacts);
    out.work = a.work + c * (b.work - a.work) + c0 * before_.powers + c1 * now_.powers;
}

} // namespace

std::unique_ptr<Integrator> make_bayo(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Bayo>(system, options);
}

} // namespace gudgeon
