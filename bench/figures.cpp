// gudgeon_figures: tables of work and time, as CSV and as text. See bench/README.md.

#include "bench/figures/tables.hpp"
#include "bench/work_precision/machine.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

using gudgeon::figures::Options;

/// The machine and the build, beside the tables.
void write_machine(const std::filesystem::path& folder) {
    const nlohmann::json machine = gudgeon::work_precision::describe_machine();
    const auto text = [&](const char* key) { return machine[key].get<std::string>(); };
    std::ofstream(folder / "machine.txt")
        << fmt::format("processor: {}\ncores: {}\nload at the start: {}\ncompiler: {}\nbuild: {}\n"
                       "version: {}\n",
                       text("processor"), machine["cores"].get<unsigned>(), machine["load"].get<double>(),
                       text("compiler"), text("build"), text("version"));
}

/// Small sizes, to see that everything works.
void make_quick(Options& options) {
    options.bodies = {10, 100};
    options.repeats = 1;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    bool quick = false;
    CLI::App app("Tables of work and time");
    app.require_subcommand(1);
    app.fallthrough();
    app.add_option("--out", options.out, "folder for the tables")->capture_default_str();
    app.add_option("--integrators", options.formulation_integrators)->delimiter(',')->capture_default_str();
    app.add_option("--bodies", options.bodies, "formulations: sizes")->delimiter(',');
    app.add_option("--formulations", options.formulations, "formulations: these")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--mechanisms", options.formulation_mechanisms, "formulations: chain, four-bar, ...")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--span", options.formulation_end, "formulations: length of a run, s")
        ->capture_default_str();
    app.add_option("--rtol", options.formulation_rtol, "formulations: tolerance")->capture_default_str();
    app.add_option("--repeats", options.repeats, "of a timed run")->capture_default_str();
    app.add_option("--budget", options.budget, "s of CPU time for the repeats of a line")
        ->capture_default_str();
    app.add_flag("--quick", quick, "small sizes, one repeat: a check that everything works");
    const auto* all = app.add_subcommand("all", "every table");
    const auto* both = app.add_subcommand("formulations", "blocks, KLU and CHOLMOD, 10 to 10000 bodies");
    CLI11_PARSE(app, argc, argv);
    try {
        if (quick)
            make_quick(options);
        std::filesystem::create_directories(options.out);
        write_machine(options.out);
        if (all->parsed() || both->parsed())
            gudgeon::figures::formulations(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "gudgeon_figures: {}\n", error.what());
        return 1;
    }
    return 0;
}
