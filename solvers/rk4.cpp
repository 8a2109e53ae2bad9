#include "solvers/rk4.hpp"

#include "core/assembly.hpp"
#include "solvers/fixed_step.hpp"
#include "solvers/motion_equations.hpp"
#include "solvers/phase_timer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr double baumgarte_rate = 1.5;     // 2 alpha h
constexpr double baumgarte_position = 1.0; // (beta h)^2
constexpr double stability_bound = 2.785;  // of step times rate, on the negative real axis
constexpr std::array<double, 4> node{0, 0.5, 0.5, 1};
constexpr std::array<double, 4> weight{1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};

class Rk4 final : public FixedStepIntegrator {
  public:
    Rk4(const System& system, const IntegratorOptions& options);

    const char* linear_solver() const override { return equations_->linear_solver(); }
    const char* formulation() const override { return formulation_name(equations_->formulation()); }
    const Statistics& statistics() const override {
        equations_->report(statistics_);
        return statistics_;
    }
    void visit(Archive& archive) override;
    bool goes_on_exactly() const override { return true; }

  private:
    void enter(Point& point) override;
    StepOutcome take_step(double h, double t_end) override;
    StepOutcome finish_point(Point& point) override;
    void begin_stages();
    StepOutcome evaluate_stage(double t, const VecX& z);
    StepOutcome failure(double t, const FactorStatus& status);
    StepOutcome check_finite(const State& state) const;

    const std::unique_ptr<MotionEquations> equations_;
    const bool drifts_;
    VecX x_, w_, z_; // of a stage
    MotionRates rates_, sum_;
    VecX phi_, rate_, baumgarte_, response_; // residuals at now_, the terms made of them, what they do to w'
};

Rk4::Rk4(const System& system, const IntegratorOptions& options)
    : FixedStepIntegrator(system, options, "rk4", 4), equations_(make_motion_equations(system, options)),
      drifts_(equations_->can_drift()), rates_(equations_->make_rates()), sum_(rates_),
      response_(VecX::Zero(equations_->speeds())) {
    phi_ = rate_ = baumgarte_ = VecX::Zero(system.row_count());
    for (Point* point : {&before_, &now_, &next_}) {
        point->coordinates = point->coordinate_rate = rates_.coordinates;
        point->speeds = point->speed_rate = rates_.speeds;
    }
}

// The slopes and sums of a step are formed anew in it.
void Rk4::visit(Archive& archive) {
    archive.section(name());
    archive(*equations_, phi_, rate_);
    visit_steps(archive);
}

void Rk4::enter(Point& point) {
    equations_->load(point.state, point.coordinates, point.speeds);
    equations_->store(point.coordinates, point.speeds, point.state);
}

// Slopes at the begin of the step are known, but for the Baumgarte terms that its four stages share.
void Rk4::begin_stages() {
    rates_.coordinates = now_.coordinate_rate;
    rates_.speeds = now_.speed_rate;
    rates_.states = now_.z_rate;
    rates_.powers = now_.powers;
    for (VecX* sum : {&sum_.coordinates, &sum_.speeds, &sum_.states, &sum_.powers})
        sum->setZero();
    if (!drifts_)
        return;
    // the full step, also in a shortened one: Phi / h^2 would shake the mechanism
    baumgarte_ = -(baumgarte_rate / step_) * rate_ - (baumgarte_position / (step_ * step_)) * phi_;
    equations_->respond(ws_, baumgarte_, response_);
    rates_.speeds += response_;
}

StepOutcome Rk4::take_step(double h, double t_end) {
    const State& from = now_.state;
    begin_stages();
    for (int k = 0; k < 4; ++k) {
        if (k > 0) {
            const double share = h * node[k];
            x_ = now_.coordinates + share * rates_.coordinates;
            w_ = now_.speeds + share * rates_.speeds;
            z_ = from.z + share * rates_.states;
            if (StepOutcome outcome = evaluate_stage(k == 3 ? t_end : from.t + share, z_); !outcome.ok)
                return outcome;
        }
        const PhaseTimer timer(statistics_.seconds.control);
        sum_.coordinates += weight[k] * rates_.coordinates;
        sum_.speeds += weight[k] * rates_.speeds;
        sum_.states += weight[k] * rates_.states;
        sum_.powers += weight[k] * rates_.powers;
    }
    {
        const PhaseTimer timer(statistics_.seconds.control);
        next_.coordinates = now_.coordinates + h * sum_.coordinates;
        next_.speeds = now_.speeds + h * sum_.speeds;
        equations_->normalise(next_.coordinates);
        State& to = next_.state;
        to.t = t_end;
        equations_->store(next_.coordinates, next_.speeds, to);
        to.z = from.z + h * sum_.states;
        to.work = from.work + h * sum_.powers;
    }
    const StepOutcome finite = check_finite(next_.state);
    return finite.ok ? finish_point(next_) : finite;
}

StepOutcome Rk4::evaluate_stage(double t, const VecX& z) {
    const FactorStatus status = equations_->rates(t, x_, w_, z, &baumgarte_, ws_, rates_);
    if (!status.ok())
        return failure(t, status);
    return all_finite(rates_) ? StepOutcome{} : bad_number(t);
}

// Accelerations, multipliers, residuals, powers and angles at an end of a step.
StepOutcome Rk4::finish_point(Point& point) {
    State& s = point.state;
    external_ = ws_.external;
    rates_.lambda = s.lambda;
    const FactorStatus status =
        equations_->rates(s.t, point.coordinates, point.speeds, s.z, nullptr, ws_, rates_);
    if (!status.ok())
        return failure(s.t, status);
    if (!all_finite(rates_))
        return bad_number(s.t);
    const PhaseTimer timer(statistics_.seconds.control);
    point.coordinate_rate = rates_.coordinates;
    point.speed_rate = rates_.speeds;
    point.z_rate = rates_.states;
    point.powers = rates_.powers;
    s.lambda = rates_.lambda;
    equations_->body_accelerations(ws_, rates_.speeds, point.acceleration);
    if (drifts_) {
        phi_ = ws_.phi;
        rate_ = ws_.rate;
        record_violations();
    }
    update_angles(system_, s.t, ws_, ws_.angles);
    s.angles = ws_.angles;
    return {};
}

StepOutcome Rk4::failure(double t, const FactorStatus& status) {
    if (status.kind == FactorStatus::Kind::non_finite)
        return bad_number(t);
    return {false, StepReason::singular,
            fmt::format("t = {} s: the acceleration equations are singular (constraints repeat each other?); "
                        "first at {}",
                        t, equations_->name_of(status.column))};
}

StepOutcome Rk4::check_finite(const State& s) const {
    for (int i = 0; i < system_.moving; ++i)
        if (!s.q.segment<7>(7 * i).allFinite() || !s.u.segment<6>(6 * i).allFinite())
            return {false, StepReason::non_finite,
                    fmt::format("t = {} s: the motion grew beyond all numbers, first at body {}; a smaller "
                                "step than {} s may be stable",
                                s.t, system_.body_names[i], step_)};
    // beyond its bound of stability the method makes up friction without growing
    if (const double rate = equations_->largest_decay(); rate * step_ > stability_bound)
        return {
            false, StepReason::error_test,
            fmt::format("t = {} s: the bristles of a friction follow at {:.3g} 1/s, too fast for steps of "
                        "{} s; at this rate steps below {:.2g} s are stable",
                        s.t, rate, step_, stability_bound / rate)};
    return {};
}

} // namespace

std::unique_ptr<Integrator> make_rk4(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Rk4>(system, options);
}

} // namespace gudgeon
