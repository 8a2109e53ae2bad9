// Error against tolerance and work.

#include "bench/figures/equal_error.hpp"
#include "bench/figures/measure.hpp"
#include "bench/figures/table.hpp"
#include "bench/figures/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon::figures {

namespace {

const char* const title =
    "Error against tolerance and work. CPU time in s of the integration alone, median of the repeats.";

struct Line {
    Settings settings;
    Accuracy accuracy;
    Timing timing;
};

int highest_order(const Statistics& s) {
    int highest = 0;
    for (int k = 0; k < static_cast<int>(s.order_histogram.size()); ++k)
        if (s.order_histogram[k] > 0)
            highest = k;
    return highest;
}

double share_of_order(const Statistics& s, int order) {
    return s.steps ? static_cast<double>(s.order_histogram[order]) / static_cast<double>(s.steps) : 0;
}

/// gear's time over ida's at the same tolerance.
double ratio_to_ida(const std::vector<Line>& lines, const Line& line) {
    for (const Line& other : lines)
        if (other.settings.integrator == "ida" && other.settings.rtol == line.settings.rtol &&
            line.settings.integrator == "gear" && other.accuracy.ok())
            return line.timing.seconds_median() / other.timing.seconds_median();
    return std::nan("");
}

std::vector<std::string> cells(const Problem& problem, const Line& line, double ratio) {
    const Accuracy& a = line.accuracy;
    const Statistics& s = a.statistics;
    const double steps = std::max(1.0, static_cast<double>(s.steps));
    const bool fixed = line.settings.integrator == "rk4";
    return {problem.name,
            line.settings.integrator,
            cell(fixed ? std::nan("") : line.settings.rtol),
            cell(fixed ? line.settings.step : std::nan("")),
            a.status,
            cell(a.error),
            cell(s.steps),
            cell(s.rejected_error),
            cell(s.rejected_newton),
            cell(s.newton_sweeps),
            cell(static_cast<double>(s.newton_sweeps) / steps),
            cell(s.constraint_polish),
            cell(s.evaluations),
            cell(s.factorisations),
            cell(s.refactorisations),
            cell(static_cast<long>(highest_order(s))),
            cell(share_of_order(s, 5)),
            cell(s.constraint_position_max),
            cell(s.constraint_velocity_max),
            cell(a.phi),
            cell(a.rate),
            cell(line.timing.seconds_median()),
            cell(line.timing.seconds.empty()
                     ? std::nan("")
                     : *std::min_element(line.timing.seconds.begin(), line.timing.seconds.end())),
            cell(static_cast<long>(line.timing.seconds.size())),
            cell(ratio)};
}

std::vector<Line> lines_of(const Problem& problem, const Options& options) {
    std::vector<Line> lines;
    for (const std::string& integrator : options.integrators) {
        if (integrator == "rk4")
            for (const double step : problem.rk4_steps)
                lines.push_back({{integrator, 1e-6, step}, {}, {}});
        else
            for (const double rtol : options.tolerances)
                lines.push_back({{integrator, rtol, 0}, {}, {}});
    }
    return lines;
}

/// All that integrate at one tolerance are timed in turn.
void time_lines(const Problem& problem, const Options& options, std::vector<Line>& lines) {
    for (Line& first : lines) {
        if (!first.accuracy.ok() || !first.timing.seconds.empty())
            continue;
        std::vector<Line*> together{&first};
        for (Line& other : lines)
            if (&other != &first && other.accuracy.ok() && other.settings.integrator != "rk4" &&
                first.settings.integrator != "rk4" && other.settings.rtol == first.settings.rtol)
                together.push_back(&other);
        std::vector<Settings> settings;
        for (const Line* line : together)
            settings.push_back(line->settings);
        const std::vector<Timing> timings = measure_times(problem, settings, options.repeats, options.budget);
        for (std::size_t i = 0; i < together.size(); ++i)
            together[i]->timing = timings[i];
    }
}

std::vector<WorkPoint> work_points(const std::vector<Line>& lines) {
    std::vector<WorkPoint> points;
    for (const Line& line : lines)
        if (line.accuracy.ok())
            points.push_back({line.settings.integrator, line.accuracy.error, line.timing.seconds_median()});
    return points;
}

} // namespace

void work_precision(const Options& options) {
    Table table({"problem",       "integrator",     "rtol",
                 "step",          "status",         "error",
                 "steps",         "rejected_error", "rejected_newton",
                 "sweeps",        "sweeps_step",    "polish",
                 "evaluations",   "factorisations", "refactorisations",
                 "highest_order", "share_order5",   "phi_steps",
                 "rate_steps",    "phi_samples",    "rate_samples",
                 "cpu",           "cpu_min",        "repeats",
                 "gear_over_ida"});
    EqualErrorTable equal(options.integrators);
    for (const Problem& problem : reference_problems(options.reference, options.data)) {
        if (!options.problems.empty() && std::find(options.problems.begin(), options.problems.end(),
                                                   problem.name) == options.problems.end())
            continue;
        fmt::print(stderr, "work-precision: {}\n", problem.name);
        std::vector<Line> lines = lines_of(problem, options);
        for (Line& line : lines)
            line.accuracy = measure_accuracy(problem, line.settings);
        time_lines(problem, options, lines);
        for (const Line& line : lines)
            table.add(cells(problem, line, ratio_to_ida(lines, line)));
        table.write(options.out, "work_precision", title);
        equal.add(problem.name, work_points(lines));
        equal.write(options.out);
    }
}

} // namespace gudgeon::figures
