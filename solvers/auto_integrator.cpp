#include "solvers/auto_integrator.hpp"

#include "core/assembly.hpp"
#include "solvers/consistent.hpp"
#include "solvers/gear.hpp"
#include "solvers/radau.hpp"

#include <Eigen/Eigenvalues>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr double fast = 30;            // rad/s: slower modes limit no step
constexpr double light = 0.7;          // damping ratio; above, every order of BDF is stable
constexpr long window_length = 150;    // accepted steps between two looks at the run
constexpr double barred_share = 0.08;  // rejections per step that say a method does not fit
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

} // namespace

AutoIntegrator::AutoIntegrator(const System& system, const IntegratorOptions& options)
    : system_(system), options_(options) {
    radau_ = make_radau(system, options);
    active_ = radau_.get();
}

AutoIntegrator::Choice AutoIntegrator::first_choice(const State& state) {
    Workspace ws = make_workspace(system_);
    ws.angles = state.angles;
    set_motion(system_, state.q, state.u, ws);
    linearise(system_, state.t, state.lambda.data(), ws);
    LocalMode worst;
    for (int i = 0; i < system_.moving; ++i)
        for (const bool rotation : {false, true})
            if (const LocalMode mode = local_mode(system_, ws, i, rotation);
                mode.omega > worst.omega && mode.ratio < light)
                worst = mode;
    fastest_ = worst.omega;
    if (worst.omega > fast)
        return {true, fmt::format("body '{}' can swing at {:.3g} rad/s with a damping ratio of {:.2g}",
                                  system_.body_names[worst.body], worst.omega, worst.ratio)};
    return {true, "smooth at the start: few long steps of order 5"};
}

Integrator& AutoIntegrator::method(bool radau) {
    std::unique_ptr<Integrator>& wanted = radau ? radau_ : gear_;
    if (!wanted)
        wanted = radau ? make_radau(system_, options_) : make_gear(system_, options_);
    return *wanted;
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
    activate(method(choice.radau));
    active_->workspace().external = external;
    window_ = {};
    uses_.push_back({state.t, active_->name(), choice.why});
    active_->start(state);
}

// Both methods: the work of the one that rests is part of the statistics, and its matrix, pivots and size of
// step serve again when it comes back.
void AutoIntegrator::visit(Archive& archive) {
    archive.section(name());
    bool radau = active_ == radau_.get(), gear = gear_ != nullptr;
    archive(radau, gear, uses_, window_, fastest_, changes_, radau_barred_);
    if (archive.reading()) {
        if (gear)
            method(false);
        else
            gear_.reset();
        activate(method(radau));
    }
    radau_->visit(archive);
    if (gear)
        gear_->visit(archive);
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
    if (active_ == gear_.get()) {
        if (!radau_barred_ && rejected > barred_share && order < low_order) {
            ++changes_;
            use({true, fmt::format("Gear's method fell to order {:.1f} with {:.0f} % of its steps rejected",
                                   order, 100 * rejected)},
                now);
        }
    } else if (const double astray = double(seen.not_converged) / double(seen.steps);
               astray > barred_sweeps && seen.error_sum < idle_error * double(seen.steps)) {
        ++changes_;
        radau_barred_ = true;
        use({false, fmt::format("Radau's sweeps failed at {:.0f} % of steps of little error", 100 * astray)},
            now);
    } else if (fastest_ <= fast && rejected > 4 * barred_share) {
        ++changes_;
        use({false, fmt::format("{:.0f} % of Radau's steps were rejected", 100 * rejected)}, now);
    }
}

StepOutcome AutoIntegrator::advance(double t_stop) {
    if (window_.steps >= window_length)
        look_at_the_run();
    StepOutcome outcome = active_->advance(t_stop);
    if (!outcome.ok && active_ == radau_.get() && outcome.reason != StepReason::non_finite) {
        ++changes_;
        radau_barred_ = true;
        use({false, "Radau's sweeps did not converge, however short the step: " + outcome.message},
            active_->state());
        outcome = active_->advance(t_stop);
    }
    return outcome;
}

const Statistics& AutoIntegrator::statistics() const {
    statistics_ = radau_->statistics();
    if (gear_)
        statistics_ += gear_->statistics();
    return statistics_;
}

std::unique_ptr<Integrator> make_auto(const System& system, const IntegratorOptions& options) {
    return std::make_unique<AutoIntegrator>(system, options);
}

} // namespace gudgeon
