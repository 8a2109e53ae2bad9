#include "solvers/fixed_step.hpp"

#include "core/assembly.hpp"
#include "core/bad_numbers.hpp"
#include "solvers/hermite_motion.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/singular_position.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gudgeon {

namespace {
constexpr double default_step = 1e-3;
constexpr double least_kick = 1e-3, kick_factor = 5; // of velocities; of the jump before
constexpr double steps_around = 3;
} // namespace

FixedStepIntegrator::FixedStepIntegrator(const System& system, const IntegratorOptions& options,
                                         const char* name, int order)
    : system_(system), step_(options.step == 0 ? default_step : options.step),
      ws_(make_workspace(system, options.threads)), watch_(system, options), name_(name), order_(order),
      max_steps_(options.max_steps),
      motion_at_([this](double t, int body, BodyMotion& out) { motion_inside(t, body, out); }) {
    if (!(step_ > 0) || !std::isfinite(step_))
        throw std::invalid_argument(fmt::format("{}: step {} is not allowed; positive, s", name, step_));
    for (Point* point : {&before_, &now_, &next_}) {
        point->state = initial_state(system);
        point->acceleration = VecX::Zero(system.velocities());
        point->powers = VecX::Zero(work_count(system));
        point->z_rate = VecX::Zero(system.friction_states());
    }
    source_ = decay_ = VecX::Zero(system.friction_states());
    external_ = ws_.external;
}

void FixedStepIntegrator::start(const State& state) {
    now_.state = state;
    enter(now_);
    ws_.angles = state.angles;
    ws_.z = state.z;
    ws_.lambda = state.lambda;
    set_motion(system_, now_.state.q, now_.state.u, ws_);
    watch_.begin(now_.state, ws_);
    started_ = finish_point(now_);
    before_ = now_;
    jump_ = 0;
}

StepOutcome FixedStepIntegrator::advance(double t_stop) {
    const double t = now_.state.t, remaining = t_stop - t;
    if (remaining <= 0 || !started_.ok)
        return started_;
    if (statistics_.steps >= max_steps_)
        return {false, StepReason::none, fmt::format("t = {} s: {} steps were allowed", t, max_steps_)};
    if (external_ != ws_.external) { // loads were set from outside since
        if (StepOutcome outcome = finish_point(now_); !outcome.ok)
            return outcome;
    }
    const bool last = remaining <= step_ * (1 + 1e-9);
    const double h = last ? remaining : step_, t_end = last ? t_stop : t + h;
    StepOutcome outcome = take_step(h, t_end);
    if (outcome.ok && system_.row_count() > 0 && watch_.idle())
        outcome = check_branch();
    record(outcome, h, t_end);
    if (!outcome.ok) {
        external_.setConstant(std::nan("")); // the matrix is not that of now_ any more
        return outcome;
    }
    std::swap(before_, now_);
    std::swap(now_, next_);
    return watch_.idle() ? outcome : follow_contacts();
}

// A stage next to a singular position kicks the mechanism out of its branch, and nothing rejects the step.
StepOutcome FixedStepIntegrator::check_branch() {
    const State &a = before_.state, &b = now_.state, &c = next_.state;
    if (!(a.t < b.t))
        return {};
    const double h = c.t - b.t, ratio = h / (b.t - a.t);
    double jump = 0;
    for (Eigen::Index j = 0; j < c.u.size(); ++j)
        jump = std::max(jump, std::abs(c.u[j] - b.u[j] - ratio * (b.u[j] - a.u[j])));
    const double usual = std::exchange(jump_, jump);
    if (jump <= least_kick * (1 + b.u.cwiseAbs().maxCoeff()) || jump <= kick_factor * usual)
        return {};
    const std::string rows = singular_rows(system_, b, steps_around * h);
    if (rows.empty())
        return {};
    return {
        false, StepReason::singular,
        fmt::format(
            "at t = {:.9g} s velocities jump by {:.3g} next to a singular position, where {} repeat other "
            "constraints: the motion may leave its branch; another step may miss it",
            b.t, jump, rows)};
}

void FixedStepIntegrator::record(const StepOutcome& outcome, double h, double t_end) {
    if (outcome.ok) {
        ++statistics_.steps;
        ++statistics_.order_histogram[order_];
        statistics_.smallest_step = std::min(statistics_.smallest_step, h);
        statistics_.largest_step = std::max(statistics_.largest_step, h);
    }
    if (on_step)
        on_step({t_end, h, order_, outcome.reason, 0});
}

StepOutcome FixedStepIntegrator::follow_contacts() {
    State& s = now_.state;
    const bool shallow = watch_.judge(before_.state.t, s.t, ws_, motion_at_, ContactEvent::Kind::deep).ok;
    statistics_.deep_starts += !shallow;
    s.contacts = before_.state.contacts;
    s.history = before_.state.history;
    watch_.commit(before_.state.t, s.t, s, ws_);
    return watch_.changed() ? finish_point(now_) : StepOutcome{};
}

void FixedStepIntegrator::motion_inside(double t, int body, BodyMotion& out) {
    interpolate(t, inside_);
    out.r = inside_.q.segment<3>(7 * body);
    out.p = inside_.q.segment<4>(7 * body + 3);
    out.A = rotation(out.p);
    out.v = inside_.u.segment<3>(6 * body);
    out.w = inside_.u.segment<3>(6 * body + 3);
}

void FixedStepIntegrator::record_violations() {
    if (system_.row_count() == 0)
        return;
    statistics_.constraint_position_max =
        std::max(statistics_.constraint_position_max, ws_.phi.cwiseAbs().maxCoeff());
    statistics_.constraint_velocity_max =
        std::max(statistics_.constraint_velocity_max, ws_.rate.cwiseAbs().maxCoeff());
}

void FixedStepIntegrator::find_state_rates(double t, VecX& out) {
    if (system_.friction_states() == 0)
        return;
    state_terms(system_, t, ws_, source_, decay_);
    out = source_ - decay_.cwiseProduct(ws_.z);
}

StepOutcome FixedStepIntegrator::bad_number(double t) {
    const std::string found = find_bad_number(system_, t, ws_);
    return {false, StepReason::non_finite,
            found.empty()
                ? fmt::format("t = {} s: accelerations beyond all numbers; a smaller step than {} s "
                              "may be stable",
                              now_.state.t, step_)
                : fmt::format("at t = {:.9g} s: {}", now_.state.t, found)};
}

// started_ of a run that goes on is ok.
void FixedStepIntegrator::visit_steps(Archive& archive) {
    archive(ws_, watch_, before_, now_, next_, decay_, external_, statistics_, jump_);
    if (archive.reading())
        started_ = {};
}

void FixedStepIntegrator::interpolate(double t, State& out) const {
    const PhaseTimer timer(statistics_.seconds.output);
    const State &a = before_.state, &b = now_.state;
    out = b;
    const double h = b.t - a.t;
    if (!(h > 0) || t >= b.t)
        return;
    const double s = std::max(0.0, (t - a.t) / h);
    const HermiteWeights weights(s);
    const auto& [value, slope0, slope1, bend0, bend1, c, c0, c1] = weights;
    const auto blend = [&](const auto& x0, const auto& x1, const auto& v0, const auto& v1, const auto& w0,
                           const auto& w1) {
        return (x0 + value * (x1 - x0) + h * (slope0 * v0 + slope1 * v1) + h * h * (bend0 * w0 + bend1 * w1))
            .eval();
    };
    out.t = t;
    for (int i = 0; i < system_.moving; ++i) {
        const int j = 7 * i, k = 6 * i;
        const Vec3 w0 = a.u.segment<3>(k + 3), w1 = b.u.segment<3>(k + 3);
        const Vec4 p0 = a.q.segment<4>(j + 3), p1 = b.q.segment<4>(j + 3);
        const Vec4 v0 = 0.5 * lt_times(p0, w0), v1 = 0.5 * lt_times(p1, w1);
        const Vec4 g0 = 0.5 * (lt_times(v0, w0) + lt_times(p0, before_.acceleration.segment<3>(k + 3)));
        const Vec4 g1 = 0.5 * (lt_times(v1, w1) + lt_times(p1, now_.acceleration.segment<3>(k + 3)));
        out.q.segment<3>(j) =
            blend(a.q.segment<3>(j), b.q.segment<3>(j), a.u.segment<3>(k), b.u.segment<3>(k),
                  before_.acceleration.segment<3>(k), now_.acceleration.segment<3>(k));
        out.q.segment<4>(j + 3) = blend(p0, p1, v0, v1, g0, g1).normalized();
    }
    out.u = a.u + c * (b.u - a.u) + h * (c0 * before_.acceleration + c1 * now_.acceleration);
    out.lambda = a.lambda + s * (b.lambda - a.lambda);
    if (system_.friction_states() > 0)
        out.z = a.z + c * (b.z - a.z) + h * (c0 * before_.z_rate + c1 * now_.z_rate);
    out.contacts = b.contacts;
    watch_.memory_inside(out.contacts);
    out.work = a.work + c * (b.work - a.work) + h * (c0 * before_.powers + c1 * now_.powers);
}

} // namespace gudgeon
