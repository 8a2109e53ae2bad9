// CPU time of the suspension chains at a given error of the chassis heights.

#include "bench/figures/measure.hpp"
#include "bench/figures/table.hpp"
#include "bench/figures/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon::figures {

namespace {

constexpr int per_decade = 4; // tolerances tried
constexpr double loosest = 1e-1;
constexpr int decades = 9;
constexpr int in_a_row = 3; // tolerances that must reach the target, so that no lucky one is taken

/// The loosest tolerance that keeps the error below the target, as do the next tighter ones; 0: none.
double tolerance_for(const Problem& problem, const std::string& integrator, double target) {
    double found = 0;
    int good = 0;
    for (int k = 0; k <= decades * per_decade && good < in_a_row; ++k) {
        const double rtol = loosest * std::pow(10.0, -static_cast<double>(k) / per_decade);
        const Accuracy a = measure_accuracy(problem, {integrator, rtol, 0});
        if (a.ok() && a.error < target) {
            if (good++ == 0)
                found = rtol;
        } else {
            good = 0;
        }
    }
    return good > 0 ? found : 0;
}

std::vector<std::string> cells(int units, double target, const Settings& settings, const Accuracy& a,
                               const Timing& timing, double ratio) {
    const Statistics& s = a.statistics;
    const double steps = std::max(1.0, static_cast<double>(s.steps)), body_steps = steps * a.bodies;
    const PhaseTimes& p = timing.phases;
    const double seconds = timing.seconds_median();
    const auto share = [&](double phase) { return cell(phase / timing.wall * seconds); };
    return {cell(static_cast<long>(units)),
            cell(target),
            settings.integrator,
            cell(settings.rtol),
            a.status,
            cell(a.error),
            cell(s.steps),
            cell(s.rejected_error),
            cell(s.rejected_newton),
            cell(static_cast<double>(s.newton_sweeps) / steps),
            cell(static_cast<double>(s.constraint_polish) / steps),
            cell(static_cast<double>(s.factorisations + s.refactorisations) / steps),
            cell(seconds),
            cell(1e6 * seconds / body_steps),
            share(p.evaluate),
            share(p.assemble),
            share(p.factor),
            share(p.solve),
            share(p.control),
            cell(timing.setup),
            cell(static_cast<long>(timing.seconds.size())),
            cell(ratio)};
}

const char* const title =
    "Suspension chains, 5 s at a chassis-height error below the target (m); CPU time in s, one thread.";

/// All integrators at one size and target, timed in turn.
void add_lines(Table& table, const Options& options, const Problem& problem, int units, double target,
               const std::vector<Settings>& settings) {
    std::vector<Settings> usable;
    std::vector<Accuracy> accuracy;
    for (const Settings& s : settings) {
        if (s.rtol == 0) {
            fmt::print(stderr, "no tolerance of {} reaches {} m\n", s.integrator, target);
            continue;
        }
        usable.push_back(s);
        accuracy.push_back(measure_accuracy(problem, s));
    }
    const std::vector<Timing> timings = measure_times(problem, usable, options.repeats, options.budget);
    double gear = std::nan("");
    for (std::size_t i = 0; i < usable.size(); ++i)
        if (usable[i].integrator == "gear")
            gear = timings[i].seconds_median();
    for (std::size_t i = 0; i < usable.size(); ++i)
        table.add(
            cells(units, target, usable[i], accuracy[i], timings[i], timings[i].seconds_median() / gear));
}

} // namespace

void suspension(const Options& options) {
    Table table({"units",   "target",         "integrator",      "rtol",        "status",      "error",
                 "steps",   "rejected_error", "rejected_newton", "sweeps_step", "polish_step", "factor_step",
                 "cpu",     "us_body_step",   "evaluate",        "assemble",    "factor",      "solve",
                 "control", "setup",          "repeats",         "over_gear"});
    for (const double target : options.targets) {
        std::vector<Settings> settings;
        for (const std::string& name : options.integrators)
            if (name != "rk4")
                settings.push_back({name, 0, 0});
        for (const int units : options.units) {
            fmt::print(stderr, "suspension: {} units, {} m\n", units, target);
            const Problem problem = suspension_problem(units, options.reference);
            if (!problem.reference.empty())
                for (Settings& s : settings)
                    s.rtol = tolerance_for(problem, s.integrator, target);
            add_lines(table, options, problem, units, target, settings);
            table.write(options.out, "suspension", title);
        }
    }
}

} // namespace gudgeon::figures
