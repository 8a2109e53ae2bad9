// Blocks, KLU and CHOLMOD: the same runs with all formulations of the linear systems.

#include "bench/formulations/formulations.hpp"
#include "bench/common/measure.hpp"
#include "bench/common/table.hpp"
#include "models/mechanisms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace gudgeon::formulations {

namespace {

using bench::cell, bench::cpu_seconds, bench::median, bench::Settings, bench::simulation_options,
    bench::Table, bench::wall_seconds;

const char* const title =
    "The same runs with the saddle point by blocks and by KLU and the augmented Lagrangian by CHOLMOD.";
constexpr int most_referenced = 1000; // bodies; longer runs are not repeated at a tight tolerance
constexpr double tight = 1e-3;        // of the tolerance, for the reference

struct Run {
    std::string status = "ok";
    std::vector<double> seconds;
    double wall = 0;
    Statistics statistics;
    VecX q;
    int bodies = 0, rows = 0;
    double cpu() const { return median(seconds); }
};

std::map<std::string, std::string> size_of(const std::string& mechanism, int bodies) {
    if (mechanism == "chain")
        return {{"links", std::to_string(bodies)}};
    if (mechanism == "four-bar")
        return {{"loops", std::to_string(std::max(1, bodies / 2))}};
    return {{"units", std::to_string(std::max(1, static_cast<int>(std::lround(bodies / 7.0))))}};
}

void run(const std::string& mechanism, int bodies, Settings settings, double end, Run& out) {
    Simulation sim(build_mechanism(mechanism, size_of(mechanism, bodies)), simulation_options(settings));
    const double begin = cpu_seconds(), wall = wall_seconds();
    if (!sim.advance_to(end).ok)
        out.status = "stopped";
    out.seconds.push_back(cpu_seconds() - begin);
    out.wall = wall_seconds() - wall;
    out.statistics = sim.statistics();
    out.q = sim.state().q;
    out.bodies = sim.system().moving;
    out.rows = sim.system().row_count();
}

/// Largest distance of a mass centre, m.
double distance(const VecX& a, const VecX& b) {
    double worst = 0;
    for (Eigen::Index i = 0; i + 2 < a.size(); i += 7)
        worst = std::max(worst, (a - b).segment<3>(i).norm());
    return worst;
}

std::vector<std::string> cells(const std::string& mechanism, const std::string& integrator,
                               const std::string& formulation, const Run& r, double over, double error) {
    const Statistics& s = r.statistics;
    const double steps = static_cast<double>(std::max(1L, s.steps)), bodies = r.bodies;
    // phases are measured in wall time: their shares of it are shown as CPU time
    const auto us = [&](double wall) { return cell(1e6 * wall / r.wall * r.cpu() / (steps * bodies)); };
    const double solves = static_cast<double>(std::max(1L, s.cholmod_solves));
    return {mechanism,
            integrator,
            formulation,
            cell(static_cast<long>(r.bodies)),
            cell(static_cast<long>(r.rows)),
            r.status,
            cell(s.steps),
            cell(r.cpu()),
            cell(over),
            us(r.wall),
            us(s.seconds.factor),
            us(s.seconds.solve),
            cell(static_cast<double>(s.newton_sweeps) / steps),
            cell(static_cast<double>(s.nnz_factors) / bodies),
            cell(static_cast<double>(s.cholmod_iterations) / solves),
            cell(s.klu_fallbacks),
            cell(error)};
}

/// All formulations of one mechanism, size and integrator, in turn so that a change of the machine's speed
/// meets all.
void compare(const std::string& mechanism, int bodies, const std::string& integrator, const Options& o,
             Table& table) {
    fmt::print(stderr, "formulations: {} {} {}\n", mechanism, integrator, bodies);
    Settings settings{integrator, o.rtol, 0};
    std::vector<Run> runs(o.formulations.size());
    const double begin = cpu_seconds();
    do
        for (std::size_t i = 0; i < runs.size(); ++i) {
            settings.formulation = o.formulations[i];
            run(mechanism, bodies, settings, o.end, runs[i]);
        }
    while (static_cast<int>(runs[0].seconds.size()) < o.repeats && cpu_seconds() - begin < o.budget);
    std::optional<Run> reference;
    if (bodies <= most_referenced) {
        settings.rtol *= tight;
        settings.formulation = "saddle-point";
        run(mechanism, bodies, settings, o.end, reference.emplace());
    }
    for (std::size_t i = 0; i < runs.size(); ++i)
        table.add(
            cells(mechanism, integrator, o.formulations[i], runs[i], runs[i].cpu() / runs[0].cpu(),
                  reference ? distance(runs[i].q, reference->q) : std::numeric_limits<double>::quiet_NaN()));
}

} // namespace

void compare_all(const Options& options) {
    Table table({"mechanism", "integrator", "formulation", "bodies", "rows", "status", "steps", "cpu",
                 "over_first", "us_total", "us_factor", "us_solve", "sweeps_step", "nnz_factors_body",
                 "passes_solve", "klu_fallbacks", "error"});
    for (const std::string& mechanism : options.mechanisms)
        for (const std::string& integrator : options.integrators)
            for (const int bodies : options.bodies) {
                compare(mechanism, bodies, integrator, options, table);
                table.write(options.out, "formulations", title);
            }
}

} // namespace gudgeon::formulations
