// gudgeon_scaling: CPU time and memory per body against the number of bodies. See README.md.

#include "bench/common/table.hpp"
#include "bench/scaling/case.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace {

using gudgeon::bench::cell;
using gudgeon::bench::Table;
using namespace gudgeon::scaling;

struct Options {
    std::string out = "scaling";
    std::vector<std::string> mechanisms{"suspension-chain", "chain"},
        joints{"bushing", "perfect", "clearance", "mixed"};
    std::vector<std::string> integrators{"gear", "radau"};
    std::vector<int> units{1, 15, 143, 1429, 15000}, threads{1};
    Case common;
};

constexpr int bodies_per_unit = 7;
constexpr int first_flat = 1000; // bodies, where flatness begins

double number(const Record& r, const char* name) {
    const auto found = r.find(name);
    return found == r.end() ? std::nan("") : std::stod(found->second);
}

/// Every case that the options ask for; sizes innermost.
std::vector<Case> cases(const Options& o, const std::vector<std::string>& integrators,
                        const std::vector<int>& threads) {
    std::vector<Case> out;
    for (const std::string& mechanism : o.mechanisms)
        for (const std::string& joints :
             mechanism == "chain" ? std::vector<std::string>{"revolute"} : o.joints)
            for (const std::string& integrator : integrators)
                for (const int n : threads)
                    for (const int units : o.units) {
                        Case c = o.common;
                        c.mechanism = mechanism;
                        c.joints = joints;
                        c.integrator = integrator;
                        c.threads = n;
                        c.units = mechanism == "chain" ? bodies_per_unit * units : units;
                        out.push_back(c);
                    }
    return out;
}

const std::vector<std::string> step_columns{
    "mechanism", "joints",    "integrator", "threads",  "bodies",   "rows",         "status",  "us_cpu",
    "growth",    "us_wall",   "evaluate",   "assemble", "factor",   "solve",        "control", "contact",
    "rest",      "us_sample", "sweeps",     "factored", "nnz_body", "factors_body", "kB_body", "kB_peak"};

/// CPU time at the first size above 1000 bodies, of each mechanism, joints, integrator and number of threads.
using References = std::map<std::string, double>;

std::vector<std::string> step_cells(const Case& c, const Record& r, References& references) {
    const double bodies = number(r, "bodies"), steps = number(r, "steps"), wall = number(r, "wall");
    const double us = 1e6 / (bodies * steps), cpu = us * number(r, "cpu");
    const std::string key = fmt::format("{} {} {} {}", c.mechanism, c.joints, c.integrator, c.threads);
    if (bodies >= first_flat)
        references.try_emplace(key, cpu);
    const double reference = references.contains(key) ? references[key] : std::nan("");
    double rest = 1;
    std::vector<std::string> out{c.mechanism,
                                 c.joints,
                                 c.integrator,
                                 std::to_string(c.threads),
                                 r.contains("bodies") ? r.at("bodies") : "-",
                                 r.contains("rows") ? r.at("rows") : "-",
                                 r.at("status"),
                                 cell(cpu),
                                 cell(cpu / reference),
                                 cell(us * wall)};
    for (const char* phase : {"evaluate", "assemble", "factor", "solve", "control", "contact"}) {
        const double share = number(r, phase) / wall;
        rest -= share;
        out.push_back(cell(us * wall * share));
    }
    out.push_back(cell(us * wall * rest));
    out.push_back(cell(1e6 * number(r, "sample") / bodies));
    for (const char* count : {"sweeps", "factorisations"})
        out.push_back(cell(number(r, count) / steps));
    for (const char* count : {"nnz", "factors"})
        out.push_back(cell(number(r, count) / bodies));
    for (const char* memory : {"steady", "peak"})
        out.push_back(cell(number(r, memory) / 1024 / bodies));
    return out;
}

void step_table(const Options& o) {
    Table table(step_columns);
    References references;
    for (const Case& c : cases(o, o.integrators, o.threads)) {
        fmt::print(stderr, "steps: {} {} {} {} threads {}\n", c.mechanism, c.joints, c.units, c.integrator,
                   c.threads);
        table.add(step_cells(c, measured_apart(c, "steps", o.out), references));
        table.write(o.out, "steps",
                    "Microseconds per body and step, least of the repeats; memory in KiB per body.");
    }
}

void set_up_table(const Options& o) {
    const std::vector<std::string> parts{"read", "check", "compile", "assemble", "rank", "prepare"};
    std::vector<std::string> columns{"mechanism", "joints", "bodies", "status",
                                     "MB_file",   "cpu",    "wall",   "us_body"};
    columns.insert(columns.end(), parts.begin(), parts.end());
    Table table(columns);
    for (const Case& c : cases(o, {"gear"}, {1})) {
        fmt::print(stderr, "set-up: {} {} {}\n", c.mechanism, c.joints, c.units);
        const Record r = measured_apart(c, "set-up", o.out);
        std::vector<std::string> cells{c.mechanism,
                                       c.joints,
                                       r.contains("bodies") ? r.at("bodies") : "-",
                                       r.at("status"),
                                       cell(1e-6 * number(r, "file")),
                                       cell(number(r, "total_cpu")),
                                       cell(number(r, "total_wall")),
                                       cell(1e6 * number(r, "total_cpu") / number(r, "bodies"))};
        for (const std::string& part : parts)
            cells.push_back(cell(number(r, part.c_str())));
        table.add(cells);
        table.write(o.out, "set_up", "Set-up from a model file, seconds of CPU time.");
    }
}

Case single_case(const Options& o) {
    Case c = o.common;
    c.mechanism = o.mechanisms.at(0);
    c.joints = o.joints.at(0);
    c.integrator = o.integrators.at(0);
    c.units = o.units.at(0);
    c.threads = o.threads.at(0);
    return c;
}

} // namespace

int main(int argc, char** argv) {
    Options o;
    bool quick = false;
    std::string what;
    CLI::App app("CPU time and memory per body against the number of bodies");
    app.require_subcommand(1);
    app.fallthrough();
    app.add_option("--out", o.out, "folder for the tables")->capture_default_str();
    app.add_option("--mechanisms", o.mechanisms)->delimiter(',')->capture_default_str();
    app.add_option("--joints", o.joints, "of the suspension chain")->delimiter(',')->capture_default_str();
    app.add_option("--integrators", o.integrators)->delimiter(',')->capture_default_str();
    app.add_option("--units", o.units, "sizes; a unit has 7 bodies")->delimiter(',')->capture_default_str();
    app.add_option("--threads", o.threads)->delimiter(',')->capture_default_str();
    app.add_option("--rtol", o.common.rtol, "tolerance")->capture_default_str();
    app.add_option("--warm-up", o.common.warm_up, "steps before the counted ones")->capture_default_str();
    app.add_option("--steps", o.common.steps, "steps counted")->capture_default_str();
    app.add_option("--budget", o.common.budget, "s of CPU time for repeats of a line")->capture_default_str();
    app.add_flag("--quick", quick, "small sizes: a check that everything works");
    const auto* all = app.add_subcommand("all", "both tables");
    const auto* steps = app.add_subcommand("steps", "time of a step and memory");
    const auto* set_up = app.add_subcommand("set-up", "read, check, compile, analyse");
    auto* one = app.add_subcommand("case", "one case, as name and value")->group("");
    one->add_option("what", what)->required();
    CLI11_PARSE(app, argc, argv);
    try {
        if (one->parsed()) {
            const Case c = single_case(o);
            print(what == "steps" ? measure_steps(c) : measure_set_up(c, o.out));
            return 0;
        }
        if (quick) {
            o.units = {1, 15};
            o.common.warm_up = o.common.steps = 5;
            o.common.budget = 0;
        }
        std::filesystem::create_directories(o.out);
        if (all->parsed() || set_up->parsed())
            set_up_table(o);
        if (all->parsed() || steps->parsed())
            step_table(o);
    } catch (const std::exception& error) {
        fmt::print(stderr, "gudgeon_scaling: {}\n", error.what());
        return 1;
    }
    return 0;
}
