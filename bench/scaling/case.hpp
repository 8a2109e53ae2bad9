// One case of the scaling tables, measured in a process of its own.
#pragma once

#include <map>
#include <string>

namespace gudgeon::scaling {

struct Case {
    std::string mechanism = "suspension-chain"; // or "chain"
    std::string joints = "bushing";             // of the suspension chain; chain: revolute, ...
    int units = 1;                              // of 7 bodies; chain: links
    std::string integrator = "gear";
    int threads = 1;
    double rtol = 1e-5;
    int warm_up = 30;  // steps at the start, of low order, that are not counted
    int steps = 60;    // counted
    double budget = 3; // s of CPU time for repeats; one run is always made whole
};

/// Measured quantities by name; a word is a status.
using Record = std::map<std::string, std::string>;

/// CPU and wall time of the steps after the warm-up, the least over the repeats, their phases, and what the
/// resident memory grew by. Names: bodies, rows, status, steps, cpu, wall (s), evaluate ... control (s, wall,
/// of the run with the least), sample (s, one), sweeps, factorisations, nnz, factors, steady, peak (bytes).
Record measure_steps(const Case& c);

/// Set-up from a model file: read, check, compile, assemble, rank, prepare (s, CPU), total_cpu, total_wall,
/// file, peak (bytes). `file`: folder for the model file.
Record measure_set_up(const Case& c, const std::string& folder);

/// The case in a process of its own, by the program's own command line; `what` is "steps" or "set-up".
/// Status "failed" where that process fails.
Record measured_apart(const Case& c, const std::string& what, const std::string& folder);

/// Prints a record for measured_apart().
void print(const Record& record);

} // namespace gudgeon::scaling
