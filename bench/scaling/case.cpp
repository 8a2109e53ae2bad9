#include "bench/scaling/case.hpp"

#include "app/clocks.hpp"
#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "core/reader.hpp"
#include "core/writer.hpp"
#include "models/mechanisms.hpp"
#include "solvers/initial.hpp"
#include "solvers/redundancy.hpp"
#include "solvers/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

namespace gudgeon::scaling {

namespace {

constexpr int samples = 3;

/// Resident memory of this process in bytes (Linux, /proc/self/status): now and at its largest.
struct Memory {
    double now = 0, peak = 0;
};

Memory resident_memory() {
    Memory memory;
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        double kilobytes = 0;
        if (word == "VmRSS:" && status >> kilobytes)
            memory.now = 1024 * kilobytes;
        if (word == "VmHWM:" && status >> kilobytes)
            memory.peak = 1024 * kilobytes;
    }
    return memory;
}

Model model_of(const Case& c) {
    if (c.mechanism == "chain")
        return build_mechanism("chain", {{"links", std::to_string(c.units)}, {"joint", c.joints}});
    return build_mechanism(c.mechanism, {{"units", std::to_string(c.units)}, {"joints", c.joints}});
}

SimulationOptions options_of(const Case& c) {
    SimulationOptions options;
    options.integrator = c.integrator;
    options.integration.rtol = options.integration.atol = c.rtol;
    options.integration.threads = c.threads;
    return options;
}

/// Steps of one run after its warm-up.
struct Window {
    std::string status = "ok";
    double cpu = 0, wall = 0;
    Statistics before, after;
};

Window run_window(Simulation& sim, const Case& c) {
    Window w;
    Integrator& integrator = sim.integrator();
    const auto run = [&](int steps) {
        for (int i = 0; i < steps && w.status == "ok"; ++i)
            if (!integrator.advance(std::numeric_limits<double>::infinity()).ok)
                w.status = "stopped";
    };
    run(c.warm_up);
    w.before = integrator.statistics();
    const double cpu = cpu_seconds(), wall = wall_seconds();
    run(c.steps);
    w.cpu = cpu_seconds() - cpu;
    w.wall = wall_seconds() - wall;
    w.after = integrator.statistics();
    return w;
}

std::string word(double value) { return fmt::format("{:.9g}", value); }

void put_window(const Window& w, Record& out) {
    const PhaseTimes &a = w.after.seconds, &b = w.before.seconds;
    out["status"] = w.status;
    out["steps"] = std::to_string(w.after.steps - w.before.steps);
    out["wall"] = word(w.wall);
    out["evaluate"] = word(a.evaluate - b.evaluate);
    out["assemble"] = word(a.assemble - b.assemble);
    out["factor"] = word(a.factor - b.factor);
    out["solve"] = word(a.solve - b.solve);
    out["control"] = word(a.control - b.control);
    out["contact"] = word(a.contact - b.contact);
    out["sweeps"] = std::to_string(w.after.newton_sweeps - w.before.newton_sweeps);
    out["factorisations"] = std::to_string(w.after.factorisations + w.after.refactorisations -
                                           w.before.factorisations - w.before.refactorisations);
    out["nnz"] = std::to_string(w.after.nnz_matrix);
    out["factors"] = std::to_string(w.after.nnz_factors);
}

} // namespace

Record measure_steps(const Case& c) {
    Record out;
    const Memory start = resident_memory();
    Window best;
    double cpu = 0, sample = std::numeric_limits<double>::infinity();
    const double begin = cpu_seconds();
    int runs = 0;
    do {
        Simulation sim(model_of(c), options_of(c));
        const Window w = run_window(sim, c);
        if (runs++ == 0) { // before the heap is used again
            const Memory end = resident_memory();
            out["steady"] = word(end.now - start.now);
            out["peak"] = word(end.peak - start.now);
            out["bodies"] = std::to_string(sim.system().moving);
            out["rows"] = std::to_string(sim.system().row_count());
            best = w;
            cpu = w.cpu;
        }
        if (w.wall < best.wall)
            best = w;
        cpu = std::min(cpu, w.cpu);
        for (int i = 0; i < samples; ++i) {
            const double now = cpu_seconds();
            sim.sample();
            sample = std::min(sample, cpu_seconds() - now);
        }
    } while (cpu_seconds() - begin < c.budget * runs / (runs + 1));
    put_window(best, out);
    out["cpu"] = word(cpu);
    out["sample"] = word(sample);
    out["runs"] = std::to_string(runs);
    return out;
}

Record measure_set_up(const Case& c, const std::string& folder) {
    Record out;
    const std::filesystem::path file = std::filesystem::path(folder) / fmt::format("{}.json", c.mechanism);
    std::ofstream(file) << write_model(model_of(c));
    out["file"] = std::to_string(std::filesystem::file_size(file));
    const auto timed = [&](const char* name, auto&& work) {
        const double begin = cpu_seconds();
        work();
        out[name] = word(cpu_seconds() - begin);
    };
    const double cpu = cpu_seconds(), wall = wall_seconds();
    { // as a run does it
        const Simulation sim(read_model(file), options_of(c));
        out["total_cpu"] = word(cpu_seconds() - cpu);
        out["total_wall"] = word(wall_seconds() - wall);
        out["bodies"] = std::to_string(sim.system().moving);
    }
    // and its parts again, one by one
    Model model;
    System system;
    State state;
    timed("read", [&] { model = read_model(file); });
    timed("check", [&] { validate(model); });
    timed("compile", [&] { system = compile(std::move(model), standard_force_builders()); });
    state = initial_state(system);
    timed("assemble", [&] {
        if (!assemble_start(system, state).ok)
            throw std::runtime_error("the mechanism cannot be assembled");
    });
    timed("rank", [&] { find_redundancy(system, state); });
    timed("prepare", [&] { make_integrator(c.integrator, system, options_of(c).integration)->start(state); });
    std::filesystem::remove(file);
    out["status"] = "ok";
    return out;
}

Record measured_apart(const Case& c, const std::string& what, const std::string& folder) {
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command = fmt::format(
        "'{}' case {} --mechanisms {} --joints {} --units {} --integrators {} --threads {} --rtol {} "
        "--warm-up {} --steps {} --budget {} --out '{}'",
        self, what, c.mechanism, c.joints, c.units, c.integrator, c.threads, c.rtol, c.warm_up, c.steps,
        c.budget, folder);
    std::FILE* pipe = popen(command.c_str(), "r");
    if (!pipe)
        return {{"status", "failed"}};
    Record out;
    std::array<char, 256> name{}, value{};
    while (std::fscanf(pipe, "%255s %255s", name.data(), value.data()) == 2)
        out[name.data()] = value.data();
    if (pclose(pipe) != 0)
        out = {{"status", "failed"}};
    return out;
}

void print(const Record& record) {
    for (const auto& [name, value] : record)
        fmt::print("{} {}\n", name, value);
}

} // namespace gudgeon::scaling
