#include "bench/figures/problems.hpp"

#include "models/mechanisms.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace gudgeon::figures {

namespace {

using Columns = std::map<std::string, std::vector<double>>;

// Lines with '#' are comments, then a header line, then numbers.
Columns read_table(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in)
        throw std::runtime_error("no reference table " + file.string());
    Columns columns;
    std::vector<std::string> names;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#')
            continue;
        std::vector<std::string> cells;
        std::istringstream row(line);
        for (std::string value; std::getline(row, value, ',');)
            cells.push_back(value);
        if (names.empty()) {
            names = cells;
            continue;
        }
        for (std::size_t i = 0; i < names.size(); ++i)
            columns[names[i]].push_back(std::stod(cells.at(i)));
    }
    return columns;
}

/// pairs: channel -> column of the table.
void set_reference(Problem& problem, const Columns& columns,
                   const std::vector<std::pair<std::string, std::string>>& pairs) {
    problem.times = columns.at("t");
    problem.end = problem.times.back();
    for (const auto& [channel, column] : pairs) {
        problem.channels.push_back(channel);
        problem.reference.push_back(columns.at(column));
    }
}

Problem pendulum() {
    Problem problem{"pendulum", "pendulum", {}, 10, {"bob.x", "bob.z"}, {10}, {}, {}};
    // x = -2 s sqrt(1 - s^2), z = 2 s^2 - 1, s = k cd(sqrt(g) t, k), k = sin 45 degrees
    problem.reference = {{-0.27508746257611686}, {-0.96141920509912506}};
    problem.rk4_steps = {2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4};
    return problem;
}

Problem slider_crank(const std::filesystem::path& folder) {
    Problem problem{"slider-crank", "slider-crank", {}, 5, {}, {}, {}, {}};
    set_reference(problem, read_table(folder / "r1_slider_crank_ideal.csv"), {{"slider.x", "x"}});
    problem.rk4_steps = {1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4};
    return problem;
}

Problem heavy_top(const std::filesystem::path& folder) {
    Problem problem{"heavy-top", "heavy-top", {}, 2, {}, {}, {}, {}};
    set_reference(problem, read_table(folder / "r7_slow_top_b.csv"),
                  {{"top.x", "cx"}, {"top.y", "cy"}, {"top.z", "cz"}});
    problem.rk4_steps = {1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4};
    return problem;
}

Problem chain(int links, const std::filesystem::path& folder) {
    Problem problem{fmt::format("chain-{}", links),
                    "chain",
                    {{"links", std::to_string(links)}, {"thin", "1"}},
                    1,
                    {},
                    {},
                    {},
                    {}};
    set_reference(problem, read_table(folder / fmt::format("r5_chain_N{}.csv", links)),
                  {{"tip.x", "tip_x"}, {"tip.z", "tip_z"}});
    problem.rk4_steps = {1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4};
    return problem;
}

Problem hmmwv_corner(const std::filesystem::path& folder) {
    Problem problem{"hmmwv-corner", "hmmwv-corner", {}, 5, {}, {}, {}, {}};
    std::vector<std::pair<std::string, std::string>> pairs;
    for (const std::string body : {"spindle", "upright"})
        for (const std::string axis : {".x", ".y", ".z"})
            pairs.emplace_back(body + axis, body + axis);
    set_reference(problem, read_table(folder / "hmmwv_corner.csv"), pairs);
    problem.rk4_steps = {1e-4, 5e-5}; // the bushings stop 2e-4
    return problem;
}

} // namespace

Model Problem::model() const { return build_mechanism(mechanism, parameters); }

Problem suspension_problem(int units, const std::filesystem::path& folder) {
    Problem problem{fmt::format("suspension-{}", units),
                    "suspension-chain",
                    {{"units", std::to_string(units)}},
                    5,
                    {},
                    {},
                    {},
                    {}};
    const auto file = folder / fmt::format("suspension_chain_N{}.csv", units);
    if (std::filesystem::exists(file)) {
        std::vector<std::pair<std::string, std::string>> pairs;
        for (int k = 0; k < units; ++k)
            pairs.emplace_back(fmt::format("chassis{}.z", k), fmt::format("chassis{}.z", k));
        set_reference(problem, read_table(file), pairs);
    }
    problem.rk4_steps = {2e-3, 1e-3, 5e-4, 2e-4, 1e-4}; // the bushings stop the longer ones
    return problem;
}

std::vector<Problem> reference_problems(const std::filesystem::path& folder,
                                        const std::filesystem::path& data) {
    return {pendulum(),
            slider_crank(folder),
            heavy_top(folder),
            chain(4, folder),
            chain(16, folder),
            suspension_problem(1, folder),
            suspension_problem(4, folder),
            hmmwv_corner(data)};
}

} // namespace gudgeon::figures
