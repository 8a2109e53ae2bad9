#include "bench/work_precision/run.hpp"

#include "core/channels.hpp"
#include "solvers/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gudgeon::work_precision {

namespace {

using bench::cpu_seconds;

constexpr double lost_error = 1;      // m
constexpr double certain_factor = 10; // errors below this many uncertainties of the reference say nothing

/// Largest error at a sample; the channels' list is in the order of the system.
class Comparison {
  public:
    Comparison(const System& system, const Problem& problem, const Solution& solution)
        : channels_(system, problem.channels), solution_(solution), values_(channels_.names().size()) {
        for (const std::string& channel : problem.channels)
            place_.push_back(std::find(channels_.names().begin(), channels_.names().end(), channel) -
                             channels_.names().begin());
    }
    double error_at(const Sample& sample, std::size_t time) {
        channels_.read(sample, values_);
        double worst = 0;
        for (std::size_t c = 0; c < place_.size(); ++c) {
            const double error = std::abs(values_[place_[c]] - solution_.values[c][time]);
            worst = std::isfinite(error) ? std::max(worst, error) : std::numeric_limits<double>::infinity();
        }
        return worst;
    }

  private:
    Channels channels_;
    const Solution& solution_;
    std::vector<double> values_;
    std::vector<std::size_t> place_;
};

void follow(Simulation& sim, const Problem& problem, Row& row) {
    Comparison comparison(sim.system(), problem, problem.solution_for(row.settings.integrator));
    for (std::size_t k = 0; k < problem.times.size(); ++k) {
        const StepOutcome outcome = sim.advance_past(problem.times[k], problem.end);
        if (!outcome.ok) {
            row.status = step_reason_name(outcome.reason);
            return;
        }
        row.error = std::max(row.error, comparison.error_at(sim.sample_at(problem.times[k]), k));
    }
    row.status = row.error > lost_error                          ? "lost"
                 : row.error < certain_factor * problem.believed ? "below-reference"
                                                                 : "ok";
}

} // namespace

Row measure_error(const Problem& problem, const Settings& settings) {
    Row row;
    row.settings = settings;
    const double before = cpu_seconds();
    try {
        Simulation sim(problem.model(), bench::simulation_options(settings));
        const double begin = cpu_seconds();
        row.setup = begin - before;
        row.bodies = sim.system().moving;
        row.unknowns = sim.system().velocities() + sim.system().row_count();
        follow(sim, problem, row);
        row.statistics = sim.statistics();
        row.seconds = {cpu_seconds() - begin};
    } catch (const std::runtime_error&) { // of the start, or a sample whose constraints cannot be closed
        row.status = "refused";
    }
    if (row.status != "ok")
        row.error = std::numeric_limits<double>::quiet_NaN();
    return row;
}

void measure_times(const Problem& problem, const std::vector<Row*>& rows, int repeats, double budget) {
    for (Row* row : rows)
        row->seconds.clear();
    const double start = cpu_seconds();
    for (int repeat = 0; repeat < repeats; ++repeat) {
        for (Row* row : rows) {
            const double before = cpu_seconds();
            Simulation sim(problem.model(), bench::simulation_options(row->settings));
            const double begin = cpu_seconds();
            sim.advance_past(problem.end, problem.end);
            row->seconds.push_back(cpu_seconds() - begin);
            row->setup = begin - before;
        }
        if (cpu_seconds() - start > budget)
            break;
    }
}

} // namespace gudgeon::work_precision
