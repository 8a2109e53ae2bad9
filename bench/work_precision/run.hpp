// Runs of a problem: error against its reference, work, CPU time.
#pragma once

#include "bench/common/measure.hpp"
#include "bench/work_precision/problems.hpp"

#include <string>
#include <vector>

namespace gudgeon::work_precision {

using Settings = bench::Settings;

/// One line of the table.
struct Row {
    Settings settings;
    std::string status; // ok; below-reference: closer to the reference than that is to the truth; lost: error
                        // above 1 m, another motion; not-run: a looser tolerance took too long; else why it
                        // stopped
    double error = 0;   // m, largest over channels and times; NaN unless the status is ok
    std::vector<double> seconds; // CPU time of the integration alone, one per repeat
    double setup = 0;            // CPU time of the last set-up (read, compile, assemble, rank, ordering), s
    Statistics statistics;
    int bodies = 0, unknowns = 0; // velocities and multipliers
    bool measured() const { return status == "ok" || status == "below-reference"; }
};

/// A run with samples at the reference's times; its CPU time is the first of the seconds.
Row measure_error(const Problem& problem, const Settings& settings);

/// Integrates without samples, once for each of the rows in turn (so that a change of the machine's speed
/// meets all), `repeats` times; at least once, and no more when all together exceed `budget` s. Replaces the
/// seconds.
void measure_times(const Problem& problem, const std::vector<Row*>& rows, int repeats, double budget);

} // namespace gudgeon::work_precision
