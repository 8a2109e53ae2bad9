#include "solvers/bayo.hpp"

#include "core/assembly.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/fixed_step.hpp"
#include "solvers/index1_equations.hpp"
#include "solvers/phase_timer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr int most_iterations = 40;
constexpr int most_reaction_passes = 60;
constexpr double settled = 1e-14;    // of the coordinates, per iteration: converged
constexpr double round_off = 1e-11;  // likewise: iterations that no longer shrink have converged
constexpr double slow = 0.2;         // share left over by an iteration: a new matrix, then whole solutions
constexpr double penalty = 1e8;      // of the scaled matrices
constexpr double projection = 1e-12; // residual of the projections, relative

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

class Bayo final : public FixedStepIntegrator {
  public:
    Bayo(const System& system, const IntegratorOptions& options);

    const char* linear_solver() const override { return "cholmod"; }
    const char* formulation() const override { return formulation_name(Formulation::augmented_lagrangian); }
    const Statistics& statistics() const override;

  private:
    StepOutcome take_step(double h, double t_end) override;
    StepOutcome finish_point(Point& point) override;
    StepOutcome iterate(double h, double t_end);
    void residual(double h, double t_end);
    void settle_states(double h, double t);
    FactorStatus factor_tangent(double h, double t);
    StepOutcome project(double t_end);
    StepOutcome accelerations(Point& point);
    void finish_motion(Point& point);
    void evaluate_at(const State& state);
    FactorStatus factor_mass();
    void find_gamma(double t);
    StepOutcome failure(double t, const FactorStatus& status);
    std::span<double> unknowns() { return {rhs_.data(), static_cast<std::size_t>(rhs_.size())}; }

    SaddleMatrix saddle_;
    AugmentedSolver tangent_, mass_;
    std::vector<double> values_;
    VecX z_, rhs_, gamma_, row_rate_, momentum_;
};

Bayo::Bayo(const System& system, const IntegratorOptions& options)
    : FixedStepIntegrator(system, options, "bayo", 2), saddle_(system),
      tangent_(system.velocities(), {.penalty = penalty}),
      mass_(system.velocities(), {.penalty = penalty, .tolerance = projection}) {
    tangent_.analyse(saddle_.pattern());
    mass_.analyse(saddle_.pattern());
    values_.assign(saddle_.pattern().nonzeros(), 0.0);
    z_ = momentum_ = VecX::Zero(system.velocities());
    rhs_ = VecX::Zero(system.velocities() + system.row_count());
    gamma_ = row_rate_ = VecX::Zero(system.row_count());
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
    finish_motion(next_);
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

void Bayo::evaluate_at(const State& s) {
    ws_.z = s.z;
    ws_.lambda = s.lambda;
    external_ = ws_.external;
    set_motion(system_, s.q, s.u, ws_);
}

// Consistent accelerations and multipliers from the acceleration equations: at a start, and where forces
// jump.
StepOutcome Bayo::accelerations(Point& point) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    State& s = point.state;
    evaluate_at(s);
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

StepOutcome Bayo::finish_point(Point& point) {
    const StepOutcome outcome = accelerations(point);
    if (outcome.ok)
        finish_motion(point);
    return outcome;
}

// Powers, rates of the friction states, angles and the violations at an end of a step.
void Bayo::finish_motion(Point& point) {
    const PhaseTimer timer(statistics_.seconds.control);
    State& s = point.state;
    evaluate_at(s);
    evaluate_constraints(system_, s.t, nullptr, false, ws_);
    record_violations();
    powers(system_, s.t, s.lambda.data(), ws_, point.powers);
    find_state_rates(s.t, point.z_rate);
    update_angles(system_, s.t, ws_, ws_.angles);
    s.angles = ws_.angles;
}

StepOutcome Bayo::failure(double t, const FactorStatus& status) {
    if (status.kind == FactorStatus::Kind::non_finite)
        return bad_number(t);
    const int n = system_.velocities();
    return {false, StepReason::singular,
            fmt::format("t = {} s: the matrix of the step has no pivot; first at {}", t,
                        status.column < 0   ? "an unknown place"
                        : status.column < n ? "body " + system_.body_names[status.column / 6]
                                            : row_name(system_, status.column - n))};
}

} // namespace

std::unique_ptr<Integrator> make_bayo(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Bayo>(system, options);
}

} // namespace gudgeon
