// gudgeon_figures: tables of work and time, as CSV and as text. See bench/README.md.

#include "bench/figures/tables.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <thread>

namespace {

using gudgeon::figures::Options;

/// The machine and the build, beside the tables.
void write_machine(const std::filesystem::path& folder) {
    std::string processor = "unknown";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) {
            processor = line.substr(line.find(':') + 2);
            break;
        }
    double load = 0;
    std::ifstream("/proc/loadavg") >> load;
    std::ofstream(folder / "machine.txt")
        << fmt::format("processor: {}\ncores: {}\nload at the start: {}\ncompiler: {}\nbuild: {}\n"
                       "version: {}\n",
                       processor, std::thread::hardware_concurrency(), load, __VERSION__, GUDGEON_BUILD_TYPE,
                       GUDGEON_VERSION);
}

/// Small sizes, to see that everything works.
void make_quick(Options& options) {
    options.bodies = {10, 100};
    options.steps = 20;
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
    auto* integrators =
        app.add_option("--integrators", options.integrators, "scaling: gear alone unless given")
            ->delimiter(',')
            ->capture_default_str();
    app.add_option("--bodies", options.bodies, "scaling, formulations: sizes")->delimiter(',');
    app.add_option("--formulations", options.formulations, "formulations: these")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--mechanisms", options.formulation_mechanisms, "formulations: chain, four-bar, ...")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--span", options.formulation_end, "formulations: length of a run, s")
        ->capture_default_str();
    app.add_option("--rtol", options.scaling_rtol, "scaling, formulations: tolerance")->capture_default_str();
    app.add_option("--steps", options.steps, "scaling: steps counted")->capture_default_str();
    app.add_option("--repeats", options.repeats, "of a timed run")->capture_default_str();
    app.add_option("--budget", options.budget, "s of CPU time for the repeats of a line")
        ->capture_default_str();
    app.add_flag("--quick", quick, "small sizes, one repeat: a check that everything works");
    const auto* all = app.add_subcommand("all", "every table");
    const auto* scale = app.add_subcommand("scaling", "time per body and step from 10 to 10000 bodies");
    const auto* both = app.add_subcommand("formulations", "KLU against CHOLMOD, 10 to 10000 bodies");
    std::string mechanism;
    int bodies = 0;
    auto* memory = app.add_subcommand("memory", "bytes a mechanism needs: at rest, at most")->group("");
    memory->add_option("mechanism", mechanism)->required();
    memory->add_option("bodies", bodies)->required();
    CLI11_PARSE(app, argc, argv);
    try {
        if (memory->parsed())
            return gudgeon::figures::print_memory(mechanism, bodies);
        if (quick)
            make_quick(options);
        if (integrators->count() > 0)
            options.scaling_integrators = options.formulation_integrators = options.integrators;
        std::filesystem::create_directories(options.out);
        write_machine(options.out);
        if (all->parsed() || scale->parsed())
            gudgeon::figures::scaling(options);
        if (all->parsed() || both->parsed())
            gudgeon::figures::formulations(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "gudgeon_figures: {}\n", error.what());
        return 1;
    }
    return 0;
}
