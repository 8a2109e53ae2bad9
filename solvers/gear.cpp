// Gear's method: start, acceptance, choice of step and order, dense output.

#include "solvers/gear.hpp"

#include "solvers/phase_timer.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {
// BDF of order 3 and more is unstable in lobes of lightly damped modes; there it is rejected again and
// again. Two rejections close to each other bar the order for a while (order 2 has no lobe), not for good.
// With contacts a lengthened step is rejected for the kinks of their forces too: that bars nothing.
constexpr long rejection_window = 20; // steps
constexpr int cap_length = 30;        // steps
constexpr double lengthened = 1.01;   // of the step before
constexpr int most_lambda_points = 3; // a parabola
// A contact's force sets in with about the 3/2th power of time, the velocity with the 5/2th: so does the
// error of the first step after an onset, whatever the order. Its scale is the contact's, not that of the
// last step.
constexpr double onset_power = 2.5, onset_cut = 1e-3;
constexpr int most_onset_cuts = 3;
constexpr double stiff_share = 0.3; // of an error: omega h above 2 (order 2) to 3.5 (order 5)
constexpr double growth_limit = 2.0;
constexpr double growth_worth = 1.2; // smaller growth is not worth a new matrix
constexpr double closing = 0.7;      // of the constraints once
} // namespace

Gear::Gear(const System& system, const IntegratorOptions& options) : ImplicitIntegrator(system, options) {
    const Eigen::Index n = system.velocities();
    options_.max_order = std::clamp(options_.max_order, 1, 5);
    history_.reserve(coordinates_->coordinates(), coordinates_->speeds(), system.row_count(),
                     system.friction_states(), options.threads);
    z_predicted_ = beta_z_ = z_change_ = VecX::Zero(system.friction_states());
    if (on_tree() && !watch_.idle())
        bodies_.reserve(system.positions(), n, 0);
    for (VecX* x : {&q_predicted_, &beta_q_, &q_between_})
        *x = VecX::Zero(coordinates_->coordinates());
    for (VecX* x : {&u_predicted_, &beta_u_, &speeds_, &u_between_})
        *x = VecX::Zero(coordinates_->speeds());
    momentum_ = step_ = VecX::Zero(n);
    power_.fill(VecX::Zero(work_count(system)));
}

void Gear::start(const State& state) {
    VecX x, w, q_rate, u_rate, x_rate, w_rate;
    State closed = state;
    coordinates_->load(state, x, w);
    coordinates_->store(x, w, closed);
    begin(closed, u_rate);
    coordinate_rates(system_, state_.q, state_.u, q_rate);
    coordinates_->set_motion(x, w, ws_);
    coordinates_->rates(x, w, u_rate, x_rate, w_rate);
    find_state_rates(state_.t);
    h_ = first_step(q_rate, u_rate);
    // a second point along the slope makes the first predictor Euler's
    history_.clear();
    history_.next_q() = x - h_ * x_rate;
    history_.next_u() = w - h_ * w_rate;
    history_.next_z() = state_.z - h_ * z_rate_;
    history_.push(state_.t - h_);
    history_.next_q() = x;
    history_.next_u() = w;
    history_.next_z() = state_.z;
    history_.next_lambda() = state_.lambda;
    history_.push(state_.t);
    if (on_tree() && !watch_.idle()) {
        bodies_.clear();
        push_bodies(state_.q - h_ * q_rate, state_.u - h_ * u_rate, state_.t - h_);
        push_bodies(state_.q, state_.u, state_.t);
    }
    ws_.z = state_.z;
    set_motion(system_, state_.q, state_.u, ws_);
    order_ = 1;
    real_points_ = 1;
    steps_at_order_ = 0;
    order_cap_ = 5;
    cap_steps_ = 0;
    last_rejection_ = -1000;
    contraction_ = 0.5;
    matrix_a0_ = 0;
    refresh_wanted_ = false;
    full_h_ = 0;
    kink_ = -1e300;
    contact_begun_ = false;
    lambda_points_ = 1;
    powers_ = 0;
    integrate_powers(state_.t);
}

void Gear::push_bodies(const VecX& q, const VecX& u, double t) {
    bodies_.next_q() = q;
    bodies_.next_u() = u;
    bodies_.push(t);
}

// What predict() and correct() fill before they use it is left out.
void Gear::visit(Archive& archive) {
    ImplicitIntegrator::visit(archive);
    if (!goes_on_exactly())
        return;
    archive(history_, bodies_, order_, kink_, contact_begun_, step_order_, t_try_, a0_, matrix_a0_,
            lambda_points_, matrix_fresh_, refresh_wanted_, matrix_work_, matrix_steps_, contraction_,
            real_points_, order_cap_, cap_steps_, last_rejection_, steps_at_order_, power_t_, power_,
            powers_);
}

// Step for which the first-order error, 1/2 h^2 |y''|, is a quarter of the limit; y'' by a trial difference.
double Gear::first_step(const VecX& q_rate, const VecX& u_rate) {
    const VecX z_slope = z_rate_;
    const double slope = std::max(norm_.rates(q_rate, u_rate).norm, norm_.states(z_slope).norm);
    const double size = norm_.rates(state_.q, state_.u).norm;
    const double trial = slope > 0 ? std::min(0.01 * size / slope, 1e-4) : 1e-4;
    VecX q = state_.q + trial * q_rate, u = state_.u + trial * u_rate, rate, lambda;
    double h = 100 * trial;
    ws_.z = state_.z + trial * z_slope;
    if (consistent_.accelerations(state_.t + trial, q, u, ws_, rate, lambda)) {
        VecX later;
        coordinate_rates(system_, q, u, later);
        find_state_rates(state_.t + trial);
        const double curvature =
            std::max(norm_.rates(later - q_rate, rate - u_rate).norm, norm_.states(z_rate_ - z_slope).norm) /
            trial;
        if (std::isfinite(curvature) && curvature > 0)
            h = std::min(h, std::sqrt(0.5 / curvature));
    }
    z_rate_ = z_slope;
    return options_.step > 0 ? std::min(h, options_.step) : h;
}

StepOutcome Gear::attempt(double t_stop, bool& accepted) {
    work_before_ = work();
    Trial trial = next_trial(t_stop);
    if (!trial.last && t_stop - trial.t < h_) { // two equal steps instead of a long and a very short one
        trial.h = 0.5 * (t_stop - state_.t);
        trial.t = state_.t + trial.h;
    }
    if (!watch_.idle() && real_points_ > order_)
        end_at_contact(trial);
    const auto [t, h, last] = trial;
    t_try_ = t;
    predict(t);
    Corrector result = correct(t);
    if (result == Corrector::slow && matrix_fresh_ && soft())
        result = correct_exactly(t);
    if (softened(result, h)) {
        matrix_a0_ = 0;
        return {};
    }
    if (result != Corrector::converged) {
        const bool renewed = matrix_fresh_;
        matrix_a0_ = 0;
        if (!renewed && result == Corrector::slow) {
            refresh_wanted_ = true; // the same step with a new matrix
            return {};
        }
        count_rejection(reason_of(result), t, order_, increment_.norm);
        lambda_points_ = 1; // wild multipliers may be the cause
        full_h_ = 0;
        h_ = soft() ? other_landing(h) : 0.25 * h;
        if (rejections_in_row_ > 20 || h_ < smallest_step())
            return failure(reason_of(result), "the corrector did not converge");
        return {};
    }
    double constant = h / (t - history_.time(order_));
    if (history_.time(order_) < kink_) // the predictor's points lie on both sides of an onset
        constant = std::max(constant, 0.5);
    {
        const PhaseTimer timer(statistics_.seconds.control);
        error_ = coordinates_->distance(norm_, history_.next_q(), q_predicted_, history_.next_u(),
                                        u_predicted_, constant);
    }
    if (error_.norm > 1 && watch_.idle() && !has_states() && !soft())
        forgive_stiff_part(constant);
    if (has_states()) {
        z_change_ = constant * (history_.next_z() - z_predicted_);
        error_ = ErrorNorm::worse(error_, norm_.states(z_change_));
    }
    if (soft() && error_.norm > 1)
        error_ = free_error(t, constant);
    if (error_.norm > 1 || !std::isfinite(error_.norm)) {
        shorten(t, h);
        return {};
    }
    if (!watch_.idle()) {
        set_end_motion();
        if (on_tree()) {
            coordinates_->store(history_.next_q(), history_.next_u(), end_);
            bodies_.next_q() = end_.q;
            bodies_.next_u() = end_.u;
        }
        if (contact_too_deep(trial, order_))
            return {};
    }
    accept(t, h, error_.norm);
    accepted = true;
    return {};
}

// Along stiff springs an error e of the coordinates is one of e/h in the velocities, which a shorter step
// makes larger; a sweep takes it out, by K^-1 a0 M (Shampine & Baca, Numer. Math. 44, 1984). An error of
// which most goes that way is judged by what is left of it. Not with contacts and bristles: theirs are kinks.
void Gear::forgive_stiff_part(double constant) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    speeds_ = history_.next_u() - u_predicted_;
    coordinates_->velocities_of(speeds_, momentum_);
    mass_times(system_, momentum_, momentum_);
    rhs_.head(n) = matrix_a0_ * momentum_;
    rhs_.segment(n, m).setZero();
    {
        const PhaseTimer timer(statistics_.seconds.solve);
        solver_.solve({rhs_.data(), static_cast<std::size_t>(n + m)}, 1);
    }
    coordinates_->speeds_of(rhs_, speeds_);
    speeds_ = history_.next_u() - speeds_;
    const ErrorNorm::Value left =
        coordinates_->distance(norm_, history_.next_q(), q_predicted_, history_.next_u(), speeds_, constant);
    if (left.norm < stiff_share * error_.norm)
        error_ = left;
}

void Gear::carry_on(double t) {
    if (on_tree()) {
        for (int i = 0; i < system_.moving; ++i)
            motion_carried_on(t, i, ws_.motion[i]);
        return;
    }
    std::array<double, BdfHistory::capacity> w{};
    interpolation_weights(history_.times(order_ + 1), t, w.data());
    history_.combine(order_ + 1, w.data(), q_predicted_, u_predicted_);
    set_motion(system_, q_predicted_, u_predicted_, ws_);
}

void Gear::motion_carried_on(double t, int body, BodyMotion& out) const {
    std::array<double, BdfHistory::capacity> w{};
    interpolation_weights(history_.times(order_ + 1), t, w.data());
    Eigen::Matrix<double, 7, 1> q = w[0] * bodies().q(0).segment<7>(7 * body);
    Vec6 u = w[0] * bodies().u(0).segment<6>(6 * body);
    for (int i = 1; i <= order_; ++i) {
        q += w[i] * bodies().q(i).segment<7>(7 * body);
        u += w[i] * bodies().u(i).segment<6>(6 * body);
    }
    set_body_motion(q, u, out);
}

void Gear::motion_in_step(double t, int body, BodyMotion& out) const {
    std::array<double, BdfHistory::capacity> times{t_try_}, w{};
    for (int i = 0; i < order_; ++i)
        times[i + 1] = history_.time(i);
    interpolation_weights({times.data(), static_cast<std::size_t>(order_ + 1)}, t, w.data());
    Eigen::Matrix<double, 7, 1> q = w[0] * bodies().next_q().segment<7>(7 * body);
    Vec6 u = w[0] * bodies().next_u().segment<6>(6 * body);
    for (int i = 0; i < order_; ++i) {
        q += w[i + 1] * bodies().q(i).segment<7>(7 * body);
        u += w[i + 1] * bodies().u(i).segment<6>(6 * body);
    }
    set_body_motion(q, u, out);
}

// After a failed error test: a shorter step, perhaps at a lower order.
void Gear::shorten(double t, double h) {
    count_rejection(StepReason::error_test, t, order_, error_.norm);
    full_h_ = 0; // the longer step would fail too
    if (contact_begun_ && rejections_in_row_ <= most_onset_cuts && std::isfinite(error_.norm)) {
        h_ = h * std::clamp(0.9 * std::pow(2 * error_.norm, -1 / onset_power), onset_cut, 0.9);
        return;
    }
    const bool longer = h > lengthened * (history_.time(0) - history_.time(1));
    if (order_ > 2 && (watch_.idle() || !longer)) {
        if (statistics_.steps - last_rejection_ < rejection_window) {
            order_cap_ = order_ - 1;
            cap_steps_ = cap_length;
        }
        last_rejection_ = statistics_.steps;
    }
    if (rejections_in_row_ > 1 || !std::isfinite(error_.norm)) {
        h_ = 0.25 * h;
        if (rejections_in_row_ > 2) {
            order_ = 1;
            steps_at_order_ = 0;
        }
        return;
    }
    double factor = 0.9 * std::pow(2 * error_.norm, -1.0 / (order_ + 1));
    if (order_ > 1) {
        const double lower = error_at_order(order_ - 1, history_.next_q(), history_.next_u());
        if (const double at_lower = 0.9 * std::pow(2 * lower, -1.0 / order_); at_lower > factor) {
            factor = at_lower;
            --order_;
            steps_at_order_ = 0;
        }
    }
    h_ = h * std::clamp(factor, 0.25, 0.9);
}

void Gear::accept(double t, double h, double error) {
    count_acceptance(t, h, order_, error);
    weigh_matrix();
    if (soft())
        drop_idle_part(history_.next_lambda());
    step_order_ = order_;
    landings_ = 0;
    contact_begun_ = false;
    {
        const PhaseTimer timer(statistics_.seconds.control);
        h_ = h;
        ++steps_at_order_;
        lambda_points_ = std::min(lambda_points_ + 1, most_lambda_points);
        rejections_in_row_ = 0;
        choose_next(error);
        coordinates_->store(history_.next_q(), history_.next_u(), state_);
        state_.z = history_.next_z();
        state_.lambda = history_.next_lambda();
        state_.t = t;
        history_.push(t);
        if (on_tree() && !watch_.idle())
            push_bodies(state_.q, state_.u, t);
        ++real_points_;
        norm_.set_scale(state_.q, state_.u, state_.z);
    }
    {
        const PhaseTimer timer(statistics_.seconds.evaluate);
        set_motion(system_, state_.q, state_.u, ws_);
        update_angles(system_, t, ws_, ws_.angles);
        state_.angles = ws_.angles;
    }
    {
        const PhaseTimer timer(statistics_.seconds.contact);
        watch_.commit(t - h, t, state_, ws_);
    }
    if (const double follow = watch_.suggested_step(); std::isfinite(follow)) {
        h_ = std::min(std::max(h_, full_h_), follow);
        kink_ = t;
        contact_begun_ = true;
        order_ = step_order_;
        steps_at_order_ = 0;
    } else if (full_h_ > 0) {
        h_ = std::max(h_, full_h_);
    }
    full_h_ = 0;
    const PhaseTimer timer(statistics_.seconds.evaluate);
    integrate_powers(t);
}

// A matrix grows old: steps need more and more sweeps. It is renewed when a step costs more than the steps
// with it have cost on average, its making counted in.
void Gear::weigh_matrix() {
    const double step = work() - work_before_;
    matrix_work_ += step;
    ++matrix_steps_;
    if (!matrix_fresh_ && !soft() && step * matrix_steps_ > matrix_work_)
        refresh_wanted_ = true;
}

double Gear::work() const {
    return double(statistics_.newton_sweeps) + closing * double(statistics_.constraint_polish);
}

// Error of the step, had it been taken at another order (its polynomial through order + 1 past points).
double Gear::error_at_order(int order, const VecX& q, const VecX& u) {
    const double t = t_try_;
    std::array<double, BdfHistory::capacity> w{};
    interpolation_weights(history_.times(order + 1), t, w.data());
    history_.combine(order + 1, w.data(), beta_q_, beta_u_); // free between corrector and next predictor
    const double constant = (t - history_.time(0)) / (t - history_.time(order));
    const ErrorNorm::Value error = coordinates_->distance(norm_, q, beta_q_, u, beta_u_, constant);
    if (!has_states())
        return error.norm;
    history_.combine_z(order + 1, w.data(), beta_z_);
    z_change_ = constant * (history_.next_z() - beta_z_);
    return ErrorNorm::worse(error, norm_.states(z_change_)).norm;
}

// Longest next step over orders k - 1, k, k + 1.
void Gear::choose_next(double error) {
    const VecX &q = history_.next_q(), &u = history_.next_u();
    const auto factor = [](double e, int order, double bias) {
        return std::pow(bias * std::max(e, 1e-10), -1.0 / (order + 1));
    };
    if (cap_steps_ > 0 && --cap_steps_ == 0)
        order_cap_ = 5;
    int best = order_;
    double growth = factor(error, order_, 2.0);
    if (steps_at_order_ > order_) {
        if (order_ > 1) {
            const double lower = factor(error_at_order(order_ - 1, q, u), order_ - 1, 2.0);
            if (lower > growth) {
                growth = lower;
                best = order_ - 1;
            }
        }
        if (order_ < std::min(options_.max_order, order_cap_) && real_points_ >= order_ + 2) {
            const double higher = factor(error_at_order(order_ + 1, q, u), order_ + 1, 3.0);
            if (higher > growth) {
                growth = higher;
                best = order_ + 1;
            }
        }
    }
    if (best != order_) {
        order_ = best;
        steps_at_order_ = 0;
    }
    if (growth >= growth_worth)
        h_ *= std::min(growth, growth_limit);
    else if (growth < 1)
        h_ *= std::max(growth, 0.5);
}

// Dissipated energy and input by integrating the polynomial through the newest powers.
void Gear::integrate_powers(double t) {
    const int kept = std::min(powers_, 5);
    for (int i = kept; i > 0; --i) {
        power_t_[i] = power_t_[i - 1];
        std::swap(power_[i], power_[i - 1]);
    }
    power_t_[0] = t;
    powers(system_, t, state_.lambda.data(), ws_, power_[0], !watch_.idle());
    powers_ = kept + 1;
    if (powers_ == 1)
        return;
    const int n = std::min(powers_, std::max(order_, step_order_) + 2);
    std::array<double, BdfHistory::capacity> w{};
    integration_weights({power_t_.data(), static_cast<std::size_t>(n)}, power_t_[1], t, w.data());
    for (int i = 0; i < n; ++i)
        state_.work += w[i] * power_[i];
}

void Gear::interpolate(double t, State& out) const {
    const int n = std::min(history_.points(), std::max({order_, step_order_, 1}) + 1);
    std::array<double, BdfHistory::capacity> w{};
    interpolation_weights(history_.times(n), t, w.data());
    out.t = t;
    history_.combine(n, w.data(), q_between_, u_between_);
    coordinates_->normalise(q_between_);
    coordinates_->store(q_between_, u_between_, out);
    out.lambda = state_.lambda;
    out.contacts = state_.contacts;
    watch_.memory_inside(out.contacts);
    out.z = state_.z;
    if (has_states())
        history_.combine_z(n, w.data(), out.z);
    out.history = state_.history;
    out.angles = state_.angles;
    out.work = state_.work;
    if (powers_ < 2 || t == state_.t)
        return;
    const int k = std::min(powers_, std::max(order_, step_order_) + 2);
    integration_weights({power_t_.data(), static_cast<std::size_t>(k)}, t, state_.t, w.data());
    for (int i = 0; i < k; ++i)
        out.work -= w[i] * power_[i];
}

std::unique_ptr<Integrator> make_gear(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Gear>(system, options);
}

} // namespace gudgeon
