#include "bench/figures/measure.hpp"

#include "core/channels.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>

namespace gudgeon::figures {

namespace {

constexpr double unstable_error = 1; // m

/// Residuals of the constraints at a sample.
class ConstraintWatch {
  public:
    explicit ConstraintWatch(const System& system) : system_(system), ws_(make_workspace(system)) {}
    void look(const Sample& sample, Accuracy& result) {
        if (system_.row_count() == 0)
            return;
        ws_.motion = sample.motion;
        ws_.angles = sample.state.angles;
        evaluate_constraints(system_, sample.state.t, nullptr, false, ws_);
        result.phi = std::max(result.phi, ws_.phi.cwiseAbs().maxCoeff());
        result.rate = std::max(result.rate, ws_.rate.cwiseAbs().maxCoeff());
    }

  private:
    const System& system_;
    Workspace ws_;
};

} // namespace

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
    if (values.empty())
        return std::numeric_limits<double>::quiet_NaN();
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

SimulationOptions simulation_options(const Settings& settings) {
    SimulationOptions options;
    options.integrator = settings.integrator;
    options.integration.rtol = options.integration.atol = settings.rtol;
    options.integration.step = settings.step;
    options.integration.formulation = formulation_named(settings.formulation);
    return options;
}

Accuracy measure_accuracy(const Problem& problem, const Settings& settings) {
    Accuracy result;
    Simulation sim(problem.model(), simulation_options(settings));
    result.bodies = sim.system().moving;
    result.rows = sim.system().row_count();
    const Channels channels(sim.system(), problem.channels);
    // the list of columns is in the system's order
    std::vector<std::size_t> place;
    for (const std::string& channel : problem.channels)
        place.push_back(std::find(channels.names().begin(), channels.names().end(), channel) -
                        channels.names().begin());
    std::vector<double> values(channels.names().size());
    ConstraintWatch watch(sim.system());
    for (std::size_t k = 0; k < problem.times.size() && result.ok(); ++k) {
        const StepOutcome outcome = sim.advance_past(problem.times[k], problem.end);
        if (!outcome.ok) {
            result.status = step_reason_name(outcome.reason);
            break;
        }
        const Sample& sample = sim.sample_at(problem.times[k]);
        watch.look(sample, result);
        channels.read(sample, values);
        for (std::size_t c = 0; c < place.size(); ++c) {
            const double error = std::abs(values[place[c]] - problem.reference[c][k]);
            if (!(error < unstable_error))
                result.status = "unstable";
            result.error = std::max(result.error, error);
        }
    }
    if (problem.times.empty()) {
        const StepOutcome outcome = sim.advance_past(problem.end, problem.end);
        if (!outcome.ok)
            result.status = step_reason_name(outcome.reason);
    }
    if (problem.times.empty() || !result.ok())
        result.error = std::numeric_limits<double>::quiet_NaN();
    result.statistics = sim.statistics();
    return result;
}

std::vector<Timing> measure_times(const Problem& problem, const std::vector<Settings>& settings, int repeats,
                                  double budget) {
    std::vector<Timing> timings(settings.size());
    const double begin = cpu_seconds();
    for (int repeat = 0; repeat < repeats; ++repeat) {
        for (std::size_t i = 0; i < settings.size(); ++i) {
            const double before = cpu_seconds();
            Simulation sim(problem.model(), simulation_options(settings[i]));
            const double start = cpu_seconds(), wall = wall_seconds();
            sim.advance_past(problem.end, problem.end);
            timings[i].seconds.push_back(cpu_seconds() - start);
            timings[i].wall = wall_seconds() - wall;
            timings[i].setup = start - before;
            timings[i].phases = sim.statistics().seconds;
        }
        if (cpu_seconds() - begin > budget)
            break;
    }
    return timings;
}

} // namespace gudgeon::figures
