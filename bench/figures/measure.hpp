// Runs of one mechanism: error against a reference, work, CPU time.
#pragma once

#include "bench/figures/problems.hpp"
#include "solvers/simulation.hpp"

#include <string>
#include <vector>

namespace gudgeon::figures {

/// CPU time of this process, all threads, s.
double cpu_seconds();
double wall_seconds();

double median(std::vector<double> values);

struct Settings {
    std::string integrator = "gear";
    double rtol = 1e-6; // and atol
    double step = 0;    // rk4
    std::string formulation = "saddle-point";
};

SimulationOptions simulation_options(const Settings& settings);

/// One run with samples at the reference's times.
struct Accuracy {
    std::string status = "ok"; // or why it stopped; "unstable" when the error exceeds 1 m
    double error = 0;          // m, largest over channels and times; NaN: no reference or not reached
    double phi = 0, rate = 0;  // largest constraint residuals at the samples (m, rad; m/s, rad/s)
    Statistics statistics;
    int bodies = 0, rows = 0;
    bool ok() const { return status == "ok"; }
};
Accuracy measure_accuracy(const Problem& problem, const Settings& settings);

struct Timing {
    std::vector<double> seconds; // CPU time of the integration alone, one per repeat
    double setup = 0;            // CPU time of the last set-up (compile, assemble, rank, ordering)
    PhaseTimes phases;           // wall time, of the last run
    double wall = 0;             // all of it, of the last run
    double seconds_median() const { return median(seconds); }
};

/// Integrates without samples, once for each of the settings in turn (so that a change of the machine's
/// speed meets all), until every one has been run `repeats` times; at least once, and no more when
/// the total exceeds `budget` seconds.
std::vector<Timing> measure_times(const Problem& problem, const std::vector<Settings>& settings, int repeats,
                                  double budget);

} // namespace gudgeon::figures
