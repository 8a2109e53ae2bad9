#include "solvers/auto_integrator.hpp"

#include "core/assembly.hpp"
#include "core/spanning_tree.hpp"
#include "solvers/consistent.hpp"
#include "solvers/erk.hpp"
#include "solvers/gear.hpp"
#include "solvers/radau.hpp"

#include <Eigen/Eigenvalues>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gudgeon {

namespace {

constexpr double fast = 30;            // rad/s: slower modes limit no step
constexpr double light = 0.7;          // damping ratio; above, every order of BDF is stable
constexpr long window_length = 150;    // accepted steps between two looks at the run
constexpr double barred_share = 0.08;  // rejections per step that say a method does not fit
constexpr double stiff_share = 0.25;   // the same for explicit steps that stability limits
constexpr double low_order = 3.2;      // mean order of a Gear that cannot use its high orders
constexpr double barred_sweeps = 0.05; // steps without convergence per step, while the error ...
constexpr double idle_error = 0.01;    // ... would allow far longer ones
constexpr int most_changes = 6;

// A body alone between its force elements: its fastest mode.
struct LocalMode {
    double omega = 0, ratio = 0;
    int body = -1;
};

LocalMode local_mode(const System& system, const Workspace& ws, int body, bool rotation) {
    const std::size_t id = 4 * std::size_t(body) + (rotation ? 3 : 0);
    const Mat3 stiffness = Eigen::Map<const Mat3>(ws.lin.S.data() + 9 * id);
    const Mat3 damping = Eigen::Map<const Mat3>(ws.lin.C.data() + 9 * id);
    const Mat3 mass = rotation ? system.inertia[body] : Mat3(system.mass[body] * Mat3::Identity());
    const Eigen::GeneralizedSelfAdjointEigenSolver<Mat3> modes(0.5 * (stiffness + stiffness.transpose()),
                                                               mass);
    const double square = modes.eigenvalues()[2];
    if (!(square > 0))
        return {};
    const Vec3 shape = modes.eigenvectors().col(2); // of unit modal mass
    const double omega = std::sqrt(square);
    return {omega, shape.dot(damping * shape) / (2 * omega), body};
}

/// Largest rate at which the forces on a body alone change its velocity, 1/s: of spring or damper.
double local_rate(const System& system, const Workspace& ws, int body, bool rotation) {
    const std::size_t id = 4 * std::size_t(body) + (rotation ? 3 : 0);
    const double mass = rotation ? 1 / system.inverse_inertia[body].norm() : system.mass[body];
    const double stiffness = Eigen::Map<const Mat3>(ws.lin.S.data() + 9 * id).norm();
    const double damping = Eigen::Map<const Mat3>(ws.lin.C.data() + 9 * id).norm();
    return std::max(std::sqrt(stiffness / mass), damping / mass);
}

bool may_be_explicit(const System& system, const IntegratorOptions& options) {
    return (options.formulation == Formulation::automatic || options.formulation == Formulation::tree) &&
           system.contacts.empty() && system.friction_states() == 0 && !system.reaction_friction &&
           system.moving > 0 && spanning_tree(system).cut_rows == 0;
}

IntegratorOptions with(IntegratorOptions options, Formulation formulation) {
    options.formulation = formulation;
    return options;
}

} // namespace

AutoIntegrator::AutoIntegrator(const System& system, const IntegratorOptions& options)
    : system_(system), options_(options) {
    active_ = &method(may_be_explicit(system, options) ? Method::erk : Method::radau);
}

// No force changes a body's velocity faster than motions that need steps as short all the same. Gyroscopic
// terms and reactions are part of the motion.
bool AutoIntegrator::explicit_serves(const State& state, Workspace& ws) const {
    if (!erk_)
        return false;
    Workspace at_rest = ws;
    VecX none = VecX::Zero(system_.row_count());
    for (BodyMotion& m : at_rest.motion)
        m.w.setZero();
    linearise(system_, state.t, none.data(), at_rest);
    for (int i = 0; i < system_.moving; ++i)
        for (const bool rotation : {false, true})
            if (local_rate(system_, at_rest, i, rotation) > fast)
                return false;
    return true;
}

AutoIntegrator::Choice AutoIntegrator::first_choice(const State& state) {
    Workspace ws = make_workspace(system_);
    ws.angles = state.angles;
    set_motion(system_, state.q, state.u, ws);
    const bool smooth = explicit_serves(state, ws);
    linearise(system_, state.t, state.lambda.data(), ws);
    LocalMode worst;
    for (int i = 0; i < system_.moving; ++i)
        for (const bool rotation : {false, true})
            if (const LocalMode mode = local_mode(system_, ws, i, rotation);
                mode.omega > worst.omega && mode.ratio < light)
                worst = mode;
    fastest_ = worst.omega;
    if (smooth)
        return {Method::erk, "an open tree without stiff forces: explicit in joint coordinates"};
    if (worst.omega > fast)
        return {Method::radau,
                fmt::format("body '{}' can swing at {:.3g} rad/s with a damping ratio of {:.2g}",
                            system_.body_names[worst.body], worst.omega, worst.ratio)};
    return {Method::radau, "smooth at the start: few long steps of order 5"};
}

Integrator& AutoIntegrator::method(Method wanted) {
    std::unique_ptr<Integrator>& made = place(wanted);
    if (!made)
        made = wanted == Method::erk     ? make_erk(system_, with(options_, Formulation::tree))
               : wanted == Method::radau ? make_radau(system_, options_)
                                         : make_gear(system_, options_);
    return *made;
}

void AutoIntegrator::activate(Integrator& method) {
    active_ = &method;
    active_->on_step = [this](const StepRecord& step) {
        if (step.reason == StepReason::none) {
            ++window_.steps;
            window_.order_sum += step.order;
            window_.error_sum += step.error;
        } else {
            ++window_.rejected;
            window_.not_converged += step.reason == StepReason::newton;
        }
        if (on_step)
            on_step(step);
    };
    active_->set_on_contact(on_contact_);
}

void AutoIntegrator::use(const Choice& choice, const State& state) {
    const VecX external = active_->workspace().external;
    activate(method(choice.method));
    active_->workspace().external = external;
    window_ = {};
    uses_.push_back({state.t, active_->name(), choice.why});
    active_->start(state);
}

// All methods: the work of those that rest is part of the statistics, and their matrices, pivots and sizes of
// step serve again when they come back.
void AutoIntegrator::visit(Archive& archive) {
    archive.section(name());
    constexpr std::array<Method, 3> methods{Method::erk, Method::radau, Method::gear};
    std::array<bool, 3> made{};
    int active = 0;
    for (int i = 0; i < 3; ++i) {
        made[i] = place(methods[i]) != nullptr;
        if (place(methods[i]).get() == active_)
            active = i;
    }
    archive(made[0], made[1], made[2], active, uses_, window_, fastest_, changes_, radau_barred_);
    if (archive.reading()) {
        for (int i = 0; i < 3; ++i)
            if (made[i])
                method(methods[i]);
            else
                place(methods[i]).reset();
        activate(method(methods[std::clamp(active, 0, 2)]));
    }
    for (const Method each : methods)
        if (place(each))
            place(each)->visit(archive);
}

void AutoIntegrator::start(const State& state) {
    if (uses_.empty())
        use(first_choice(state), state);
    else
        active_->start(state); // after a discontinuity: what served before
}

// Changes the method where the last steps speak against it. Radau stays where modes are stiff and lightly
// damped, whatever its error test rejects: Gear's method would fare worse.
void AutoIntegrator::look_at_the_run() {
    const Window seen = std::exchange(window_, {});
    if (changes_ >= most_changes)
        return;
    const double rejected = double(seen.rejected) / double(seen.steps);
    const double order = double(seen.order_sum) / double(seen.steps);
    const State now = active_->state();
    if (active_ == erk_.get()) {
        if (rejected > stiff_share) {
            ++changes_;
            use({Method::radau, fmt::format("{:.0f} % of the explicit steps were rejected", 100 * rejected)},
                now);
        }
    } else if (active_ == gear_.get()) {
        if (!radau_barred_ && rejected > barred_share && order < low_order) {
            ++changes_;
            use({Method::radau,
                 fmt::format("Gear's method fell to order {:.1f} with {:.0f} % of its steps rejected", order,
                             100 * rejected)},
                now);
        }
    } else if (const double astray = double(seen.not_converged) / double(seen.steps);
               astray > barred_sweeps && seen.error_sum < idle_error * double(seen.steps)) {
        ++changes_;
        radau_barred_ = true;
        use({Method::gear,
             fmt::format("Radau's sweeps failed at {:.0f} % of steps of little error", 100 * astray)},
            now);
    } else if (fastest_ <= fast && rejected > 4 * barred_share) {
        ++changes_;
        use({Method::gear, fmt::format("{:.0f} % of Radau's steps were rejected", 100 * rejected)}, now);
    }
}

StepOutcome AutoIntegrator::advance(double t_stop) {
    if (window_.steps >= window_length)
        look_at_the_run();
    StepOutcome outcome = active_->advance(t_stop);
    if (!outcome.ok && active_ == erk_.get() && outcome.reason != StepReason::non_finite) {
        ++changes_;
        use({Method::radau, "the explicit method stopped: " + outcome.message}, active_->state());
        outcome = active_->advance(t_stop);
    }
    if (!outcome.ok && active_ == radau_.get() && outcome.reason != StepReason::non_finite) {
        ++changes_;
        radau_barred_ = true;
        use({Method::gear, "Radau's sweeps did not converge, however short the step: " + outcome.message},
            active_->state());
        outcome = active_->advance(t_stop);
    }
    return outcome;
}

const Statistics& AutoIntegrator::statistics() const {
    statistics_ = {};
    for (const auto* each : {&erk_, &radau_, &gear_})
        if (*each)
            statistics_ += (*each)->statistics();
    return statistics_;
}

std::unique_ptr<Integrator> make_auto(const System& system, const IntegratorOptions& options) {
    return std::make_unique<AutoIntegrator>(system, options);
}

} // namespace gudgeon
