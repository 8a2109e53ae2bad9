// gudgeon_formulations: the same runs by blocks, KLU and CHOLMOD, as CSV and as text. See README.md.

#include "bench/common/machine.hpp"
#include "bench/formulations/formulations.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

using gudgeon::formulations::Options;

/// The machine and the build, beside the table.
void write_machine(const std::filesystem::path& folder) {
    const nlohmann::json machine = gudgeon::bench::describe_machine();
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
    CLI::App app("The same runs by blocks, KLU and CHOLMOD");
    app.add_option("--out", options.out, "folder for the table")->capture_default_str();
    app.add_option("--integrators", options.integrators)->delimiter(',')->capture_default_str();
    app.add_option("--bodies", options.bodies, "sizes")->delimiter(',');
    app.add_option("--formulations", options.formulations,
                   "these, the first is what others are compared with")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--mechanisms", options.mechanisms, "chain, four-bar, ...")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--span", options.end, "length of a run, s")->capture_default_str();
    app.add_option("--rtol", options.rtol, "relative and absolute tolerance")->capture_default_str();
    app.add_option("--repeats", options.repeats, "of a timed run")->capture_default_str();
    app.add_option("--budget", options.budget, "s of CPU time for the repeats of a line")
        ->capture_default_str();
    app.add_flag("--quick", quick, "small sizes, one repeat: a check that everything works");
    CLI11_PARSE(app, argc, argv);
    try {
        if (quick)
            make_quick(options);
        std::filesystem::create_directories(options.out);
        write_machine(options.out);
        gudgeon::formulations::compare_all(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "gudgeon_formulations: {}\n", error.what());
        return 1;
    }
    return 0;
}
