#include "bench/work_precision/reference.hpp"

#include "bench/common/measure.hpp"
#include "bench/work_precision/solution_table.hpp"
#include "core/channels.hpp"
#include "solvers/simulation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon::work_precision {

namespace {

struct Made {
    SolutionTable table;
    double seconds = 0;
};

Made make(const Problem& problem, const Making& making) {
    const double begin = bench::cpu_seconds();
    Simulation sim(
        problem.model(),
        bench::simulation_options({making.integrator, making.rtol > 0 ? making.rtol : 1e-6, making.step}));
    const Channels channels(sim.system(), problem.channels);
    Made made;
    made.table.names = {"t"};
    made.table.values.resize(1 + channels.names().size());
    for (const std::string& name : channels.names())
        made.table.names.push_back(name);
    std::vector<double> values(channels.names().size());
    for (const double t : problem.times) {
        const StepOutcome outcome = sim.advance_to(t);
        if (!outcome.ok)
            throw std::runtime_error(
                fmt::format("{} by {}: {}", problem.id(), making.integrator, outcome.message));
        channels.read(sim.sample(), values);
        made.table.values[0].push_back(t);
        for (std::size_t c = 0; c < values.size(); ++c)
            made.table.values[c + 1].push_back(values[c]);
    }
    made.seconds = bench::cpu_seconds() - begin;
    return made;
}

std::string how(const Making& making) {
    return making.step > 0 ? fmt::format("{}, step {} s", making.integrator, making.step)
                           : fmt::format("{}, rtol = atol = {}", making.integrator, making.rtol);
}

} // namespace

void make_references(const Problem& problem, const std::filesystem::path& data) {
    if (problem.makings.empty())
        return;
    std::vector<Made> made;
    for (const Making& making : problem.makings) {
        made.push_back(make(problem, making));
        fmt::print(stderr, "{} by {}: {:.3g} s\n", problem.id(), how(making), made.back().seconds);
    }
    double difference = 0;
    for (std::size_t c = 1; c < made[0].table.values.size(); ++c)
        for (std::size_t k = 0; k < made[0].table.values[c].size(); ++k)
            difference =
                std::max(difference, std::abs(made[0].table.values[c][k] - made[1].table.values[c][k]));
    fmt::print(stderr, "    they differ by {:.2e}\n", difference);
    std::vector<std::string> parameters;
    for (const auto& [name, value] : problem.parameters)
        parameters.push_back(name + "=" + value);
    std::filesystem::create_directories(data);
    for (std::size_t i = 0; i < made.size(); ++i) {
        const Making& other = problem.makings[1 - i];
        made[i].table.comments = {
            fmt::format("{} {}to {} s by {}; steps end at these times", problem.base,
                        parameters.empty() ? "" : fmt::format("({}) ", fmt::join(parameters, ", ")),
                        problem.end, how(problem.makings[i])),
            fmt::format("believed to {:.1e} (m, rad): the largest difference from {}, {}", difference,
                        data_file(problem, other, "").string(), how(other)),
            "judges runs of other methods only; a fault of the model or of its forces would not show",
            fmt::format("made anew by: gudgeon_work_precision reference --problems {}", problem.id())};
        write_table(data_file(problem, problem.makings[i], data), made[i].table);
    }
}

} // namespace gudgeon::work_precision
