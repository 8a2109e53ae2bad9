// The table of all runs: which are made, how they are timed, how they are written.
#pragma once

#include "bench/work_precision/run.hpp"

#include <filesystem>

namespace gudgeon::work_precision {

struct Options {
    std::filesystem::path out = "results/work_precision";
    std::filesystem::path tables = GUDGEON_REFERENCE, data = GUDGEON_BENCH_DATA;
    std::vector<std::string> problems; // globs of ids; empty: all
    int largest = 1000000;             // size of a problem
    std::vector<std::string> integrators{"gear", "radau", "auto", "erk", "ida", "rk4", "bayo"};
    std::vector<std::string> formulations{"saddle-point", "augmented-lagrangian"}; // of gear and radau
    std::vector<double> tolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11};
    int fixed_steps = 7; // steps of rk4 and bayo, each half of the one before
    int repeats = 5;     // of a timed run; 0: timed by the run with samples
    double budget = 2;   // s of CPU time for the repeats of the runs that are timed together
    double longest = 20; // s: no tighter tolerance is run after one that took longer
};

/// Writes work_precision.csv and work_precision.json into the folder, anew after every problem.
void measure_all(const Options& options);

/// What other programs need to take part: <id>.csv per problem with times and reference values, and
/// problems.csv with mechanism, size, parameters, end and channels.
void write_problems(const Options& options);

} // namespace gudgeon::work_precision
