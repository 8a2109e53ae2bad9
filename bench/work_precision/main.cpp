// gudgeon_work_precision: what the ready mechanisms cost for how exact a result. See README.md.

#include "bench/work_precision/measurement.hpp"
#include "bench/work_precision/reference.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <exception>

namespace {

using gudgeon::work_precision::Options;

/// Seconds in all: that everything works.
void make_quick(Options& options) {
    options.tolerances = {1e-3, 1e-4};
    options.fixed_steps = 1;
    options.repeats = 0;
    options.longest = 0.05;
    options.largest = 10;
}

} // namespace

int main(int argc, char** argv) {
    using namespace gudgeon::work_precision;
    Options options;
    bool quick = false;
    CLI::App app("Error and CPU time of every ready mechanism by every integrator");
    app.fallthrough();
    app.add_option("--out", options.out, "folder for the results")->capture_default_str();
    app.add_option("--tables", options.tables, "folder of the tables computed elsewhere")
        ->capture_default_str();
    app.add_option("--data", options.data, "folder of the converged references")->capture_default_str();
    app.add_option("--problems", options.problems, "only these (globs of what `list` shows)")->delimiter(',');
    app.add_option("--integrators", options.integrators)->delimiter(',')->capture_default_str();
    app.add_option("--formulations", options.formulations, "of gear and radau")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--tolerances", options.tolerances, "rtol = atol")->delimiter(',')->capture_default_str();
    app.add_option("--fixed-steps", options.fixed_steps, "steps of rk4 and bayo tried, halves of each other")
        ->capture_default_str();
    app.add_option("--repeats", options.repeats, "of a timed run; the least time counts")
        ->capture_default_str();
    app.add_option("--budget", options.budget, "s of CPU time for the repeats of one tolerance")
        ->capture_default_str();
    app.add_option("--longest", options.longest, "s; after a run that took longer no tighter one is made")
        ->capture_default_str();
    app.add_flag("--quick", quick, "two tolerances, small problems: a check that everything works");
    const auto* list = app.add_subcommand("list", "the problems, one a line");
    const auto* reference = app.add_subcommand("reference", "makes the converged references anew (--data)");
    const auto* problems =
        app.add_subcommand("problems", "writes problems and reference values for other programs");
    app.require_subcommand(0, 1);
    CLI11_PARSE(app, argc, argv);
    try {
        if (quick)
            make_quick(options);
        if (list->parsed())
            for (const Problem& problem : chosen_problems(options.problems, options.largest))
                fmt::print("{}\n", problem.id());
        else if (reference->parsed())
            for (const Problem& problem : chosen_problems(options.problems, options.largest))
                make_references(problem, options.data);
        else if (problems->parsed())
            write_problems(options);
        else
            measure_all(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "gudgeon_work_precision: {}\n", error.what());
        return 1;
    }
    return 0;
}
