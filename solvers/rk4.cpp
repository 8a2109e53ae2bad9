#include "solvers/rk4.hpp"

#include "core/bad_numbers.hpp"
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
constexpr double baumgarte_rate = 1.5;     // 2 alpha h
constexpr double baumgarte_position = 1.0; // (beta h)^2
constexpr double stability_bound = 2.785;  // of step times rate, on the negative real axis
constexpr std::array<double, 4> node{0, 0.5, 0.5, 1};
constexpr std::array<double, 4> weight{1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};

/// What is known at one end of a step.
struct Point {
    State state;
    VecX acceleration;
    VecX powers; // as State::work
    VecX z_rate; // of the friction states
    void visit(Archive& archive) { archive(state, acceleration, powers, z_rate); }
};

/// q' = T(q) u
void position_rate(int moving, const VecX& q, const VecX& u, VecX& out) {
    for (int i = 0; i < moving; ++i) {
        out.segment<3>(7 * i) = u.segment<3>(6 * i);
        out.segment<4>(7 * i + 3) = 0.5 * lt_times(q.segment<4>(7 * i + 3), u.segment<3>(6 * i + 3));
    }
}

class Rk4 final : public Integrator {
  public:
    Rk4(const System& system, const IntegratorOptions& options)
        : system_(system), step_(options.step == 0 ? default_step : options.step),
          max_steps_(options.max_steps), equations_(system, rows_of(options)),
          ws_(make_workspace(system, options.threads)), watch_(system, options),
          motion_at_([this](double t, int body, BodyMotion& out) {
              interpolate(t, inside_);
              out.r = inside_.q.segment<3>(7 * body);
              out.p = inside_.q.segment<4>(7 * body + 3);
              out.A = rotation(out.p);
              out.v = inside_.u.segment<3>(6 * body);
              out.w = inside_.u.segment<3>(6 * body + 3);
          }),
          driven_(std::any_of(system.model.joints.begin(), system.model.joints.end(),
                              [](const Joint& joint) { return !joint.drives.empty(); })) {
        if (!(step_ > 0) || !std::isfinite(step_))
            throw std::invalid_argument(fmt::format("rk4: step {} is not allowed; positive, s", step_));
        for (Point* point : {&before_, &now_, &next_}) {
            point->state = initial_state(system);
            point->acceleration = VecX::Zero(system.velocities());
            point->powers = VecX::Zero(work_count(system));
        }
        power_ = power_sum_ = VecX::Zero(work_count(system));
        for (VecX* z : {&source_, &decay_, &slope_z_, &sum_z_, &before_.z_rate, &now_.z_rate, &next_.z_rate})
            *z = VecX::Zero(system.friction_states());
        external_ = ws_.external;
        stage_.q = before_.state.q;
        for (VecX* u : {&stage_.u, &slope_u_, &sum_u_, &response_})
            *u = VecX::Zero(system.velocities());
        for (VecX* q : {&slope_q_, &sum_q_})
            *q = VecX::Zero(system.positions());
        for (VecX* row : {&phi_, &rate_, &baumgarte_, &stage_.lambda})
            *row = VecX::Zero(system.row_count());
    }

    const char* name() const override { return "rk4"; }
    const char* linear_solver() const override { return "klu"; }
    const State& state() const override { return now_.state; }
    Workspace& workspace() override { return ws_; }

    const Statistics& statistics() const override {
        equations_.report(statistics_);
        return statistics_;
    }

    void visit(Archive& archive) override;
    bool goes_on_exactly() const override { return true; }

    void set_on_contact(std::function<void(const ContactEvent&)> f) override {
        watch_.on_contact = std::move(f);
    }
    void start(const State& state) override {
        now_.state = state;
        ws_.angles = state.angles;
        ws_.z = state.z;
        ws_.lambda = state.lambda;
        set_motion(system_, state.q, state.u, ws_);
        watch_.begin(now_.state, ws_);
        started_ = finish_point(now_);
        before_ = now_;
    }

    StepOutcome advance(double t_stop) override;
    void interpolate(double t, State& out) const override;

  private:
    StepOutcome take_step(double h, double t_end);
    StepOutcome finish_point(Point& point);
    StepOutcome follow_contacts();
    StepOutcome evaluate_stage(double t);
    StepOutcome failure(double t, const FactorStatus& status);
    StepOutcome bad_number(double t);
    StepOutcome check_finite(const State& state) const;
    void find_powers(double t, const VecX& lambda, VecX& out);
    void find_state_rates(double t, VecX& out);
    void record(const StepOutcome& outcome, double h, double t_end);

    const System& system_;
    const double step_;
    const long max_steps_;
    Index1Equations equations_;
    Workspace ws_;
    ContactWatch watch_;
    const ContactWatch::MotionAt motion_at_;
    State inside_; // of the last step, for the watch
    const bool driven_;
    Point before_, now_, next_; // begin and end of the last step; the step being taken
    State stage_;
    VecX power_, power_sum_;
    VecX slope_q_, slope_u_, sum_q_, sum_u_, response_;
    VecX source_, decay_, slope_z_, sum_z_; // friction states
    VecX phi_, rate_, baumgarte_;           // residuals at now_ and the terms made of them
    VecX external_;                         // loads now_ was evaluated with
    StepOutcome started_;
    mutable Statistics statistics_;
};

// The slopes and sums of a step are formed anew in it. started_ of a run that goes on is ok.
void Rk4::visit(Archive& archive) {
    archive.section(name());
    archive(equations_, ws_, watch_, before_, now_, next_, phi_, rate_, decay_, external_, statistics_);
    if (archive.reading())
        started_ = {};
}

StepOutcome Rk4::advance(double t_stop) {
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
    if (outcome.ok)
        outcome = finish_point(next_);
    record(outcome, h, t_end);
    if (!outcome.ok) {
        external_.setConstant(std::nan("")); // the matrix is not that of now_ any more
        return outcome;
    }
    std::swap(before_, now_);
    std::swap(now_, next_);
    return watch_.idle() ? outcome : follow_contacts();
}

void Rk4::record(const StepOutcome& outcome, double h, double t_end) {
    if (outcome.ok) {
        ++statistics_.steps;
        ++statistics_.order_histogram[4];
        statistics_.smallest_step = std::min(statistics_.smallest_step, h);
        statistics_.largest_step = std::max(statistics_.largest_step, h);
    }
    if (on_step)
        on_step({t_end, h, 4, outcome.reason, 0});
}

// A fixed step cannot be rejected: contacts that begin too deep are counted.
StepOutcome Rk4::follow_contacts() {
    State& s = now_.state;
    const bool shallow = watch_.judge(before_.state.t, s.t, ws_, motion_at_, ContactEvent::Kind::deep).ok;
    statistics_.deep_starts += !shallow;
    s.contacts = before_.state.contacts;
    s.history = before_.state.history;
    watch_.commit(before_.state.t, s.t, s, ws_);
    return watch_.changed() ? finish_point(now_) : StepOutcome{};
}

// One step from now_ to the coordinates and energies of next_.
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
    return check_finite(to);
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
    if (system_.row_count() > 0) {
        statistics_.constraint_position_max =
            std::max(statistics_.constraint_position_max, phi_.cwiseAbs().maxCoeff());
        statistics_.constraint_velocity_max =
            std::max(statistics_.constraint_velocity_max, rate_.cwiseAbs().maxCoeff());
    }
    find_powers(s.t, s.lambda, point.powers);
    find_state_rates(s.t, point.z_rate);
    update_angles(system_, s.t, ws_, ws_.angles);
    s.angles = ws_.angles;
    return {};
}

void Rk4::find_state_rates(double t, VecX& out) {
    if (system_.friction_states() == 0)
        return;
    state_terms(system_, t, ws_, source_, decay_);
    out = source_ - decay_.cwiseProduct(ws_.z);
}

void Rk4::find_powers(double t, const VecX& lambda, VecX& out) {
    const PhaseTimer timer(statistics_.seconds.control);
    powers(system_, t, driven_ ? lambda.data() : nullptr, ws_, out);
}

StepOutcome Rk4::bad_number(double t) {
    const std::string found = find_bad_number(system_, t, ws_);
    return {false, StepReason::non_finite,
            fmt::format("at t = {:.9g} s: {}", now_.state.t,
                        found.empty() ? "accelerations beyond all numbers" : found)};
}

StepOutcome Rk4::failure(double t, const FactorStatus& status) {
    if (status.kind == FactorStatus::Kind::non_finite)
        if (StepOutcome outcome = bad_number(t); outcome.message.find("no finite") != std::string::npos)
            return outcome;
    const bool finite = status.kind == FactorStatus::Kind::singular;
    const char* what = finite ? "the acceleration equations are singular (constraints repeat each other?)"
                              : "the acceleration equations have entries that are no numbers";
    return {false, finite ? StepReason::singular : StepReason::non_finite,
            fmt::format("t = {} s: {}; first at {}", t, what, equations_.name_of(status.column))};
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

void Rk4::interpolate(double t, State& out) const {
    const PhaseTimer timer(statistics_.seconds.output);
    const State &a = before_.state, &b = now_.state;
    out = b;
    const double h = b.t - a.t;
    if (!(h > 0) || t >= b.t)
        return;
    const double s = std::max(0.0, (t - a.t) / h), s2 = s * s, s3 = s2 * s, r = 1 - s;
    const double value = s3 * (10 - 15 * s + 6 * s2);  // quintic Hermite weights: end value,
    const double slope0 = s * r * r * r * (1 + 3 * s); // rates at both ends,
    const double slope1 = -s3 * r * (4 - 3 * s);       //
    const double bend0 = 0.5 * s2 * r * r * r, bend1 = 0.5 * s3 * r * r; // second derivatives
    const auto blend = [&](const auto& x0, const auto& x1, const auto& v0, const auto& v1, const auto& w0,
                           const auto& w1) {
        return (x0 + value * (x1 - x0) + h * (slope0 * v0 + slope1 * v1) + h * h * (bend0 * w0 + bend1 * w1))
            .eval();
    };
    const double c = s2 * (3 - 2 * s), c0 = s * r * r, c1 = -s2 * r; // cubic
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

} // namespace

std::unique_ptr<Integrator> make_rk4(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Rk4>(system, options);
}

} // namespace gudgeon
