#include "solvers/rk4.hpp"

#include "core/assembly.hpp"
#include "solvers/fixed_step.hpp"
#include "solvers/index1_equations.hpp"
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

/// q' = T(q) u
void position_rate(int moving, const VecX& q, const VecX& u, VecX& out) {
    for (int i = 0; i < moving; ++i) {
        out.segment<3>(7 * i) = u.segment<3>(6 * i);
        out.segment<4>(7 * i + 3) = 0.5 * lt_times(q.segment<4>(7 * i + 3), u.segment<3>(6 * i + 3));
    }
}

class Rk4 final : public FixedStepIntegrator {
  public:
    Rk4(const System& system, const IntegratorOptions& options);

    const char* linear_solver() const override { return "klu"; }
    const Statistics& statistics() const override {
        equations_.report(statistics_);
        return statistics_;
    }
    void visit(Archive& archive) override;
    bool goes_on_exactly() const override { return true; }

  private:
    StepOutcome take_step(double h, double t_end) override;
    StepOutcome finish_point(Point& point) override;
    StepOutcome evaluate_stage(double t);
    StepOutcome failure(double t, const FactorStatus& status);
    StepOutcome check_finite(const State& state) const;
    void find_powers(double t, const VecX& lambda, VecX& out);

    Index1Equations equations_;
    const bool driven_;
    State stage_;
    VecX power_, power_sum_;
    VecX slope_q_, slope_u_, sum_q_, sum_u_, response_, slope_z_, sum_z_;
    VecX phi_, rate_, baumgarte_; // residuals at now_ and the terms made of them
};

Rk4::Rk4(const System& system, const IntegratorOptions& options)
    : FixedStepIntegrator(system, options, "rk4", 4), equations_(system, rows_of(options)),
      driven_(std::any_of(system.model.joints.begin(), system.model.joints.end(),
                          [](const Joint& joint) { return !joint.drives.empty(); })) {
    power_ = power_sum_ = VecX::Zero(work_count(system));
    slope_z_ = sum_z_ = VecX::Zero(system.friction_states());
    stage_.q = now_.state.q;
    for (VecX* u : {&stage_.u, &slope_u_, &sum_u_, &response_})
        *u = VecX::Zero(system.velocities());
    for (VecX* q : {&slope_q_, &sum_q_})
        *q = VecX::Zero(system.positions());
    for (VecX* row : {&phi_, &rate_, &baumgarte_, &stage_.lambda})
        *row = VecX::Zero(system.row_count());
}

// The slopes and sums of a step are formed anew in it.
void Rk4::visit(Archive& archive) {
    archive.section(name());
    archive(equations_, phi_, rate_);
    visit_steps(archive);
}

StepOutcome Rk4::take_step(double h, double t_end) {
    const State& from = now_.state;
    // the full step, also in a shortened one: Phi / h^2 would shake the mechanism
    baumgarte_ = -(baumgarte_rate / step_) * rate_ - (baumgarte_position / (step_ * step_)) * phi_;
    equations_.respond(ws_, baumgarte_, response_);
    power_ = now_.powers;
    power_sum_.setZero();
    sum_q_.setZero();
    sum_u_.setZero();
    sum_z_.setZero();
    for (int k = 0; k < 4; ++k) {
        if (k == 0) {
            stage_.q = from.q;
            stage_.u = from.u;
            slope_u_ = now_.acceleration + response_;
            slope_z_ = now_.z_rate;
        } else {
            stage_.q = from.q + (h * node[k]) * slope_q_;
            stage_.u = from.u + (h * node[k]) * slope_u_;
            ws_.z = from.z + (h * node[k]) * slope_z_;
            if (StepOutcome outcome = evaluate_stage(k == 3 ? t_end : from.t + h * node[k]); !outcome.ok)
                return outcome;
        }
        const PhaseTimer timer(statistics_.seconds.control);
        position_rate(system_.moving, stage_.q, stage_.u, slope_q_);
        sum_q_ += weight[k] * slope_q_;
        sum_u_ += weight[k] * slope_u_;
        sum_z_ += weight[k] * slope_z_;
        power_sum_ += weight[k] * power_;
    }
    const PhaseTimer timer(statistics_.seconds.control);
    State& to = next_.state;
    to.t = t_end;
    to.q = from.q + h * sum_q_;
    to.u = from.u + h * sum_u_;
    to.z = from.z + h * sum_z_;
    to.work = from.work + h * power_sum_;
    for (int i = 0; i < system_.moving; ++i)
        to.q.segment<4>(7 * i + 3).normalize();
    const StepOutcome finite = check_finite(to);
    return finite.ok ? finish_point(next_) : finite;
}

StepOutcome Rk4::evaluate_stage(double t) {
    set_motion(system_, stage_.q, stage_.u, ws_);
    const FactorStatus status = equations_.solve(t, ws_, &baumgarte_, slope_u_, stage_.lambda);
    if (!status.ok())
        return failure(t, status);
    if (!slope_u_.allFinite() || !stage_.lambda.allFinite())
        return bad_number(t);
    find_powers(t, stage_.lambda, power_);
    find_state_rates(t, slope_z_);
    return {};
}

// Accelerations, multipliers, residuals, powers and angles at an end of a step.
StepOutcome Rk4::finish_point(Point& point) {
    State& s = point.state;
    ws_.z = s.z;
    set_motion(system_, s.q, s.u, ws_);
    external_ = ws_.external;
    const FactorStatus status = equations_.solve(s.t, ws_, nullptr, point.acceleration, s.lambda);
    if (!status.ok())
        return failure(s.t, status);
    if (!point.acceleration.allFinite() || !s.lambda.allFinite())
        return bad_number(s.t);
    const PhaseTimer timer(statistics_.seconds.control);
    phi_ = ws_.phi;
    rate_ = ws_.rate;
    record_violations();
    find_powers(s.t, s.lambda, point.powers);
    find_state_rates(s.t, point.z_rate);
    update_angles(system_, s.t, ws_, ws_.angles);
    s.angles = ws_.angles;
    return {};
}

void Rk4::find_powers(double t, const VecX& lambda, VecX& out) {
    const PhaseTimer timer(statistics_.seconds.control);
    powers(system_, t, driven_ ? lambda.data() : nullptr, ws_, out);
}

StepOutcome Rk4::failure(double t, const FactorStatus& status) {
    if (status.kind == FactorStatus::Kind::non_finite)
        return bad_number(t);
    return {false, StepReason::singular,
            fmt::format("t = {} s: the acceleration equations are singular (constraints repeat each other?); "
                        "first at {}",
                        t, equations_.name_of(status.column))};
}

StepOutcome Rk4::check_finite(const State& s) const {
    for (int i = 0; i < system_.moving; ++i)
        if (!s.q.segment<7>(7 * i).allFinite() || !s.u.segment<6>(6 * i).allFinite())
            return {false, StepReason::non_finite,
                    fmt::format("t = {} s: the motion grew beyond all numbers, first at body {}; a smaller "
                                "step than {} s may be stable",
                                s.t, system_.body_names[i], step_)};
    // beyond its bound of stability the method makes up friction without growing
    if (const double rate = decay_.size() ? decay_.maxCoeff() : 0.0; rate * step_ > stability_bound)
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
