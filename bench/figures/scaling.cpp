// CPU time per body and step, its split, and memory, against the number of bodies.

#include "bench/figures/measure.hpp"
#include "bench/figures/table.hpp"
#include "bench/figures/tables.hpp"
#include "models/mechanisms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace gudgeon::figures {

namespace {

const char* const title = "CPU time per body and step in microseconds, one thread; memory in kB per body.";
constexpr int warm_up = 50; // steps at the start, of low order, that are not counted
constexpr int memory_steps = 20;

Model sized_model(const std::string& mechanism, int bodies) {
    if (mechanism == "chain")
        return build_mechanism("chain", {{"links", std::to_string(bodies)}});
    const int units = std::max(1, static_cast<int>(std::lround(bodies / 7.0)));
    return build_mechanism("suspension-chain", {{"units", std::to_string(units)}});
}

struct Window {
    std::string status = "ok";
    long steps = 0, sweeps = 0, polish = 0, factorisations = 0;
    double seconds = 0, wall = 0, setup = 0, reached = 0;
    PhaseTimes phases; // of the window
    long nnz_matrix = 0, nnz_factors = 0;
    int bodies = 0, rows = 0;
};

PhaseTimes difference(const PhaseTimes& a, const PhaseTimes& b) {
    return {a.evaluate - b.evaluate, a.assemble - b.assemble, a.factor - b.factor,
            a.solve - b.solve,       a.control - b.control,   a.output - b.output};
}

/// Steps of the integrator after the warm-up.
Window measure_window(const std::string& mechanism, int bodies, const std::string& name, const Options& o) {
    Window w;
    const double begin = cpu_seconds();
    Settings settings{name, o.scaling_rtol, 0};
    Simulation sim(sized_model(mechanism, bodies), simulation_options(settings));
    w.setup = cpu_seconds() - begin;
    w.bodies = sim.system().moving;
    w.rows = sim.system().row_count();
    const double end = sim.system().model.end.value_or(1);
    Integrator& integrator = sim.integrator();
    const auto run = [&](int steps) {
        for (int i = 0; i < steps && integrator.state().t < end && w.status == "ok"; ++i)
            if (const StepOutcome outcome = integrator.advance(end); !outcome.ok)
                w.status = "stopped";
    };
    run(warm_up);
    const Statistics before = integrator.statistics();
    const double start = cpu_seconds(), wall = wall_seconds();
    run(o.steps);
    w.seconds = cpu_seconds() - start;
    w.wall = wall_seconds() - wall;
    const Statistics after = integrator.statistics();
    w.steps = after.steps - before.steps;
    w.sweeps = after.newton_sweeps - before.newton_sweeps;
    w.polish = after.constraint_polish - before.constraint_polish;
    w.factorisations =
        after.factorisations + after.refactorisations - before.factorisations - before.refactorisations;
    w.phases = difference(after.seconds, before.seconds);
    w.nnz_matrix = after.nnz_matrix;
    w.nnz_factors = after.nnz_factors;
    w.reached = integrator.state().t;
    return w;
}

/// The window of median time.
Window median_window(const std::string& mechanism, int bodies, const std::string& name, const Options& o) {
    std::vector<Window> windows;
    const double begin = cpu_seconds();
    do
        windows.push_back(measure_window(mechanism, bodies, name, o));
    while (static_cast<int>(windows.size()) < o.repeats && cpu_seconds() - begin < o.budget);
    std::sort(windows.begin(), windows.end(),
              [](const Window& a, const Window& b) { return a.seconds < b.seconds; });
    return windows[(windows.size() - 1) / 2];
}

/// Memory of a fresh process, bytes.
Memory child_memory(const std::string& mechanism, int bodies) {
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command = fmt::format("'{}' memory {} {}", self, mechanism, bodies);
    Memory memory{std::nan(""), std::nan("")};
    if (std::FILE* pipe = popen(command.c_str(), "r")) {
        if (std::fscanf(pipe, "%lf %lf", &memory.now, &memory.peak) != 2)
            memory = {std::nan(""), std::nan("")};
        pclose(pipe);
    }
    return memory;
}

std::vector<std::string> cells(const std::string& mechanism, const std::string& name, const Window& w,
                               double first, const Memory& memory) {
    const double body_steps = std::max(1.0, static_cast<double>(w.bodies) * static_cast<double>(w.steps));
    const auto us = [&](double seconds) { return cell(1e6 * seconds / body_steps); };
    const PhaseTimes& p = w.phases;
    const double rest = w.wall - p.evaluate - p.assemble - p.factor - p.solve - p.control;
    // phases are measured in wall time: their shares of it are shown as CPU time
    const auto share = [&](double seconds) { return us(seconds / w.wall * w.seconds); };
    const double steps = std::max(1.0, static_cast<double>(w.steps)), bodies = w.bodies;
    return {mechanism,
            name,
            cell(static_cast<long>(w.bodies)),
            cell(static_cast<long>(w.rows)),
            w.status,
            cell(w.steps),
            cell(w.reached),
            us(w.seconds),
            cell(1e6 * w.seconds / body_steps / first),
            share(p.evaluate),
            share(p.assemble),
            share(p.factor),
            share(p.solve),
            share(p.control),
            share(rest),
            cell(static_cast<double>(w.sweeps) / steps),
            cell(static_cast<double>(w.polish) / steps),
            cell(static_cast<double>(w.factorisations) / steps),
            cell(w.nnz_matrix),
            cell(w.nnz_factors),
            cell(static_cast<double>(w.nnz_factors) / bodies),
            cell(w.setup),
            cell(memory.now / 1024 / bodies),
            cell(memory.peak / 1024 / bodies)};
}

} // namespace

Memory resident_memory() {
    Memory memory;
    std::FILE* status = std::fopen("/proc/self/status", "r");
    if (!status)
        return memory;
    char line[256];
    while (std::fgets(line, sizeof line, status)) {
        long kilobytes = 0;
        if (std::sscanf(line, "VmRSS: %ld", &kilobytes) == 1)
            memory.now = 1024.0 * static_cast<double>(kilobytes);
        if (std::sscanf(line, "VmHWM: %ld", &kilobytes) == 1)
            memory.peak = 1024.0 * static_cast<double>(kilobytes);
    }
    std::fclose(status);
    return memory;
}

int print_memory(const std::string& mechanism, int bodies) {
    const Memory before = resident_memory();
    Simulation sim(sized_model(mechanism, bodies));
    for (int i = 0; i < memory_steps; ++i)
        if (!sim.integrator().advance(std::numeric_limits<double>::infinity()).ok)
            return 1;
    const Memory after = resident_memory();
    fmt::print("{} {}\n", after.now - before.now, after.peak - before.now);
    return 0;
}

void scaling(const Options& options) {
    Table table(
        {"mechanism", "integrator",  "bodies",           "rows",        "status",      "steps",
         "reached",   "us_total",    "growth",           "us_evaluate", "us_assemble", "us_factor",
         "us_solve",  "us_control",  "us_rest",          "sweeps_step", "polish_step", "factor_step",
         "nnz",       "nnz_factors", "nnz_factors_body", "setup_s",     "kB_body",     "kB_body_peak"});
    for (const char* mechanism : {"chain", "suspension-chain"}) {
        for (const std::string& name : options.scaling_integrators) {
            if (name == "rk4" || name == "bayo")
                continue;
            double first = std::nan("");
            for (const int bodies : options.bodies) {
                fmt::print(stderr, "scaling: {} {} {}\n", mechanism, name, bodies);
                const Window w = median_window(mechanism, bodies, name, options);
                if (std::isnan(first))
                    first = 1e6 * w.seconds / w.bodies / static_cast<double>(std::max(1L, w.steps));
                const Memory memory =
                    name == "gear" ? child_memory(mechanism, bodies) : Memory{std::nan(""), std::nan("")};
                table.add(cells(mechanism, name, w, first, memory));
                table.write(options.out, "scaling", title);
            }
        }
    }
}

} // namespace gudgeon::figures
