#include "solvers/erk.hpp"

#include "core/assembly.hpp"
#include "core/bad_numbers.hpp"
#include "solvers/phase_timer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {

constexpr double safety = 0.9, least_factor = 0.2, most_factor = 6;
constexpr double memory_of_error = 0.04;   // share of the last error in the choice of the step (Gustafsson)
constexpr double smallest_share = 4e-15;   // of t: shorter steps do not move it
constexpr double deep_share = 100;         // of the smallest step: contacts are not resolved below
constexpr double loosest_of_eighth = 1e-3; // rtol from which on order 5 needs less work

} // namespace

Erk::Erk(const System& system, const IntegratorOptions& options, const char* name, int order)
    : system_(system), options_(options), name_(name), pair_(explicit_pair(order)),
      equations_(make_motion_equations(system, options)), x_(equations_->coordinates()),
      w_(equations_->speeds()), z_(system.friction_states()), ws_(make_workspace(system, options.threads)),
      watch_(system, options), rates_(equations_->make_rates()) {
    if (!(options.rtol >= 0) || !(options.atol > 0) || !(options.step >= 0))
        throw std::invalid_argument(fmt::format(
            "{}: rtol {}, atol {}, step {} are not allowed; rtol and step at least 0, atol positive", name,
            options.rtol, options.atol, options.step));
    const Eigen::Index n = x_ + w_ + z_ + work_count(system);
    slope_.assign(pair_.all_stages(), VecX::Zero(n));
    for (VecX* v : {&first_slope_, &y_, &weight_})
        *v = VecX::Zero(n);
    for (Point* point : {&before_, &now_, &next_}) {
        point->state = initial_state(system);
        point->y = VecX::Zero(n);
        point->acceleration = VecX::Zero(watch_.idle() ? 0 : system.velocities());
    }
    x_now_ = VecX::Zero(x_);
    w_now_ = VecX::Zero(w_);
    z_now_ = VecX::Zero(z_);
    dense_weight_.assign(pair_.all_stages(), 0.0);
    error_sum_.assign(pair_.error.size(), 0.0);
    external_ = ws_.external;
}

void Erk::start(const State& state) {
    now_.state = state;
    ws_.remember(state);
    equations_->load(state, x_now_, w_now_);
    equations_->set_motion(x_now_, w_now_, ws_);
    equations_->store(x_now_, w_now_, now_.state);
    watch_.begin(now_.state, ws_);
    now_.y << x_now_, w_now_, state.z, state.work;
    known_ = 0;
    error_ = 1;
    reason_ = StepReason::none;
    started_ = {};
    refresh();
    before_ = now_;
    if (started_.ok)
        first_step();
}

// Everything at now_ that forces decide.
void Erk::refresh() {
    fresh_ = true;
    external_ = ws_.external;
    started_ = {};
    if (!rates(now_.state.t, now_.y, first_slope_)) {
        reason_ =
            status_.kind == FactorStatus::Kind::singular ? StepReason::singular : StepReason::non_finite;
        trouble_ = find_bad_number(system_, now_.state.t, ws_);
        started_ = stuck({now_.state.t, 0, false});
        return;
    }
    if (rates_.lambda.size() == now_.state.lambda.size())
        now_.state.lambda = rates_.lambda;
    if (!watch_.idle())
        equations_->body_accelerations(ws_, rates_.speeds, now_.acceleration);
    update_angles(system_, now_.state.t, ws_, ws_.angles);
    now_.state.angles = ws_.angles;
}

bool Erk::rates(double t, const VecX& y, VecX& slope) const {
    x_now_ = y.head(x_);
    w_now_ = y.segment(x_, w_);
    z_now_ = y.segment(x_ + w_, z_);
    status_ = equations_->rates(t, x_now_, w_now_, z_now_, nullptr, ws_, rates_);
    if (!status_.ok())
        return false;
    slope << rates_.coordinates, rates_.speeds, rates_.states, rates_.powers;
    if (slope.allFinite())
        return true;
    status_ = {FactorStatus::Kind::non_finite, -1};
    return false;
}

// Length of the first step from the curvature of the motion (Hairer, Norsett, Wanner, II.4).
void Erk::first_step() {
    weigh();
    const Eigen::Index n = x_ + w_ + z_;
    const auto size = [&](const VecX& v) {
        return n > 0 ? v.head(n).cwiseProduct(weight_.head(n)).cwiseAbs().maxCoeff() : 0.0;
    };
    const double level = size(now_.y), rate = size(first_slope_);
    double h = level < 1e-5 || rate < 1e-5 ? 1e-6 : 0.01 * level / rate;
    if (options_.step > 0)
        h = std::min(h, options_.step);
    y_ = now_.y + h * first_slope_;
    VecX& later = slope_[1];
    const double bend = rates(now_.state.t + h, y_, later) ? size(later - first_slope_) / h : 0;
    const double largest = std::max(rate, bend);
    h_ = std::min(100 * h,
                  largest < 1e-15 ? std::max(1e-6, 1e-3 * h) : std::pow(0.01 / largest, 1.0 / pair_.order));
}

// Weights 1 / (rtol |y| + atol); of a friction state as in error_norm.hpp, none of energies.
void Erk::weigh() {
    const Eigen::Index n = x_ + w_;
    weight_.head(n) = (options_.rtol * now_.y.head(n).array().abs() + options_.atol).inverse();
    for (Eigen::Index j = 0; j < z_; ++j)
        weight_[n + j] =
            1 / (options_.rtol * std::abs(now_.y[n + j]) + options_.atol * system_.state_scales[j]);
}

StepOutcome Erk::advance(double t_stop) {
    if (!started_.ok || t_stop <= now_.state.t)
        return started_;
    if (statistics_.steps >= options_.max_steps)
        return {false, StepReason::none,
                fmt::format("t = {} s: {} steps were allowed", now_.state.t, options_.max_steps)};
    if (!fresh_ || external_ != ws_.external)
        refresh();
    if (!started_.ok)
        return started_;
    known_ = 0;
    slope_[0] = first_slope_;
    weigh();
    for (bool accepted = false; !accepted;) {
        const Attempt trial = next_attempt(t_stop);
        if (trial.h < smallest_step() && !trial.last)
            return started_ = stuck(trial);
        accepted = attempt(trial);
    }
    return started_;
}

double Erk::smallest_step() const { return smallest_share * std::max(std::abs(now_.state.t), 1e-3); }

Erk::Attempt Erk::next_attempt(double t_stop) {
    const double t = now_.state.t, rest = t_stop - t;
    double h = options_.step > 0 ? std::min(h_, options_.step) : h_;
    bool last = h >= rest * (1 - 1e-3);
    if (last)
        h = rest;
    else if (2 * h > rest) // two equal steps instead of a long and a very short one
        h = 0.5 * rest;
    double end = last ? t_stop : t + h;
    if (!watch_.idle()) {
        const double foreseen = watch_.foresee(t, end, ws_, [this](double at, int body, BodyMotion& out) {
            motion_carried_on(end_of(now_), at, body, out);
        });
        if (foreseen < end && foreseen - t > smallest_step()) {
            end = foreseen;
            last = false;
        }
    }
    return {end, end - t, last};
}

// False: rejected, h_ is shorter.
bool Erk::attempt(const Attempt& trial) {
    if (!find_stages(now_.state.t, trial.h, 1, pair_.stages))
        return reject(status_.kind == FactorStatus::Kind::singular ? StepReason::singular
                                                                   : StepReason::non_finite,
                      trial, 0.25, 0);
    combine(now_.y, pair_.a[pair_.stages], trial.h, next_.y);
    const bool ends_in_error = pair_.error[0].back().stage == pair_.stages;
    const bool drifts = equations_->can_drift();
    if (ends_in_error || !drifts)
        if (!rates(trial.t, next_.y, slope_[pair_.stages]))
            return reject(StepReason::non_finite, trial, 0.25, 0);
    const double error = error_of(trial.h);
    if (!(error <= 1))
        return reject(StepReason::error_test, trial,
                      std::isfinite(error)
                          ? std::max(least_factor, safety * std::pow(error, -1.0 / pair_.error_order))
                          : least_factor,
                      error);
    if (drifts && !(close_end(trial.t) && rates(trial.t, next_.y, slope_[pair_.stages])))
        return reject(StepReason::constraints, trial, 0.25, 0);
    finish(trial);
    if (!watch_.idle()) {
        const ContactWatch::Verdict verdict =
            watch_.judge(now_.state.t, trial.t, ws_, [this](double at, int body, BodyMotion& out) {
                hermite_motion(end_of(now_), end_of(next_), at, body, out);
            });
        const double h = verdict.end - now_.state.t;
        if (!verdict.ok && h > deep_share * smallest_step())
            return reject(StepReason::contact, trial, h / trial.h, error);
        statistics_.deep_starts += !verdict.ok;
    }
    accept(trial, error);
    return true;
}

/// Stages first ... end - 1 of a step from now_.
bool Erk::find_stages(double t, double h, int first, int end) const {
    for (int j = first; j < end; ++j) {
        combine(now_.y, pair_.a[j], h, y_);
        if (!rates(t + pair_.c[j] * h, y_, slope_[j]))
            return false;
    }
    return true;
}

/// from + h sum a_i k_i
void Erk::combine(const VecX& from, const std::vector<PairTerm>& row, double h, VecX& out) const {
    const PhaseTimer timer(statistics_.seconds.control);
    out = from;
    for (const PairTerm& term : row)
        out += (h * term.weight) * slope_[term.stage];
}

/// Largest weighted error, 1 is the limit. Of two estimates as DOP853 does: h e5^2 / sqrt(e5^2 + e3^2 / 100).
double Erk::error_of(double h) {
    const PhaseTimer timer(statistics_.seconds.control);
    const Eigen::Index n = x_ + w_ + z_;
    for (std::size_t i = 0; i < pair_.error.size(); ++i) {
        y_.setZero();
        for (const PairTerm& term : pair_.error[i])
            y_ += term.weight * slope_[term.stage];
        const auto parts = y_.head(n).cwiseProduct(weight_.head(n)).cwiseAbs();
        error_sum_[i] = n == 0 ? 0.0 : parts.maxCoeff<Eigen::PropagateNaN>();
    }
    const double e = error_sum_[0];
    if (error_sum_.size() == 1 || e == 0)
        return h * e;
    return h * e * e / std::sqrt(e * e + 0.01 * error_sum_[1] * error_sum_[1]);
}

bool Erk::close_end(double t) {
    x_now_ = next_.y.head(x_);
    w_now_ = next_.y.segment(x_, w_);
    if (!equations_->close(t, x_now_, w_now_, ws_))
        return false;
    next_.y.head(x_) = x_now_;
    next_.y.segment(x_, w_) = w_now_;
    return true;
}

/// The state at the end of the step, by the rates there.
void Erk::finish(const Attempt& trial) {
    const PhaseTimer timer(statistics_.seconds.control);
    x_now_ = next_.y.head(x_);
    equations_->normalise(x_now_);
    next_.y.head(x_) = x_now_;
    w_now_ = next_.y.segment(x_, w_);
    State& s = next_.state;
    s.t = trial.t;
    equations_->store(x_now_, w_now_, s);
    s.z = next_.y.segment(x_ + w_, z_);
    s.work = next_.y.tail(next_.y.size() - x_ - w_ - z_);
    if (rates_.lambda.size() == s.lambda.size())
        s.lambda = rates_.lambda;
    if (!watch_.idle()) {
        equations_->body_accelerations(ws_, rates_.speeds, next_.acceleration);
        s.contacts = now_.state.contacts;
        s.history = now_.state.history;
    }
}

void Erk::accept(const Attempt& trial, double error) {
    ++statistics_.steps;
    ++statistics_.order_histogram[pair_.order];
    statistics_.smallest_step = std::min(statistics_.smallest_step, trial.h);
    statistics_.largest_step = std::max(statistics_.largest_step, trial.h);
    if (equations_->can_drift()) {
        statistics_.constraint_position_max =
            std::max(statistics_.constraint_position_max, ws_.phi.lpNorm<Eigen::Infinity>());
        statistics_.constraint_velocity_max =
            std::max(statistics_.constraint_velocity_max, ws_.rate.lpNorm<Eigen::Infinity>());
    }
    update_angles(system_, trial.t, ws_, ws_.angles);
    next_.state.angles = ws_.angles;
    std::swap(before_, now_);
    std::swap(now_, next_);
    first_slope_ = slope_[pair_.stages];
    known_ = pair_.stages + 1;
    const double power = 1.0 / pair_.error_order;
    const double e = std::max(error, 1e-10);
    double factor = safety * std::pow(e, -power + 0.75 * memory_of_error) * std::pow(error_, memory_of_error);
    factor = std::clamp(factor, least_factor, reason_ == StepReason::none ? most_factor : 1.0);
    // a step that ended early at a stop says nothing against the length before
    h_ = trial.h < h_ ? std::max(h_, trial.h * factor) : trial.h * factor;
    error_ = std::max(e, 1e-4);
    reason_ = StepReason::none;
    if (on_step)
        on_step({trial.t, trial.h, pair_.order, StepReason::none, error});
    if (watch_.idle())
        return;
    watch_.commit(before_.state.t, trial.t, now_.state, ws_);
    if (const double follow = watch_.suggested_step(); std::isfinite(follow))
        h_ = std::min(h_, follow);
    if (watch_.changed())
        fresh_ = false;
}

bool Erk::reject(StepReason reason, const Attempt& trial, double factor, double error) {
    if (reason == StepReason::error_test)
        ++statistics_.rejected_error;
    else if (reason == StepReason::contact)
        ++statistics_.rejected_contact;
    else
        ++statistics_.rejected_newton;
    reason_ = reason;
    if (reason == StepReason::non_finite)
        trouble_ = find_bad_number(system_, trial.t, ws_);
    h_ = factor * trial.h;
    if (on_step)
        on_step({trial.t, trial.h, pair_.order, reason, error});
    return false;
}

namespace {
/// Left to the program: joint coordinates, in which loops pass singular positions too.
std::unique_ptr<Integrator> make(const System& system, IntegratorOptions options, const char* name,
                                 int order) {
    if (options.formulation == Formulation::automatic)
        options.formulation = Formulation::tree;
    return std::make_unique<Erk>(system, options, name, order);
}
} // namespace

std::unique_ptr<Integrator> make_erk5(const System& system, const IntegratorOptions& options) {
    return make(system, options, "erk5", 5);
}

std::unique_ptr<Integrator> make_erk8(const System& system, const IntegratorOptions& options) {
    return make(system, options, "erk8", 8);
}

std::unique_ptr<Integrator> make_erk(const System& system, const IntegratorOptions& options) {
    return make(system, options, "erk", options.rtol > loosest_of_eighth ? 5 : 8);
}

} // namespace gudgeon
