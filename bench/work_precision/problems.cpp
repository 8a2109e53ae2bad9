#include "bench/work_precision/problems.hpp"

#include "bench/work_precision/solution_table.hpp"
#include "models/mechanisms.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>

namespace gudgeon::work_precision {

namespace {

constexpr int compared_times = 50; // of converged references
constexpr double fine_step = 2e-5; // s, of single differential equations: they have 15 digits then

/// A table that was computed elsewhere.
struct Independent {
    std::string file;
    std::vector<std::string> columns; // one per channel; "-name": with the other sign
    double believed;                  // m
    std::string what;
};

/// What the list below says of a problem.
struct Entry {
    Problem problem;
    std::optional<Independent> table;
    std::function<Solution(const std::vector<double>& times)> exact;
    double exact_believed = 0;
};

std::vector<std::string> axes(const std::vector<std::string>& points) {
    std::vector<std::string> channels;
    for (const std::string& point : points)
        for (const char* axis : {".x", ".y", ".z"})
            channels.push_back(point + axis);
    return channels;
}

Entry entry(const std::string& mechanism, int size, const std::string& base,
            const std::map<std::string, std::string>& parameters, double end,
            const std::vector<std::string>& channels) {
    Entry e;
    e.problem.mechanism = mechanism;
    e.problem.size = size;
    e.problem.base = base;
    e.problem.parameters = parameters;
    e.problem.end = end;
    e.problem.channels = channels;
    return e;
}

Entry with_steps(Entry e, double rk4, double bayo) {
    e.problem.rk4_step = rk4;
    e.problem.bayo_step = bayo;
    return e;
}

Entry with_table(Entry e, const Independent& table) {
    e.table = table;
    return e;
}

Entry converged(Entry e, const Making& one, const Making& other = {"radau", 1e-12, 0}) {
    e.problem.makings = {one, other};
    return e;
}
const Making ida{"ida", 1e-12, 0};

/// Of one angle of the time; the position of a point follows from it.
Entry with_angle(Entry e, int times,
                 const std::function<std::vector<double>(const std::vector<double>&)>& angles,
                 const std::function<std::array<double, 2>(double)>& point, const std::string& what) {
    for (int k = 1; k <= times; ++k)
        e.problem.times.push_back(e.problem.end * k / times);
    e.exact = [angles, point](const std::vector<double>& at) {
        Solution solution{"", {{}, {}}};
        for (const double angle : angles(at))
            for (int c : {0, 1})
                solution.values[c].push_back(point(angle)[c]);
        return solution;
    };
    e.exact_believed = 1e-12;
    e.problem.reference = what;
    return with_steps(e, 2e-2, 2e-2);
}

Entry pendulum() {
    return with_angle(
        entry("pendulum", 1, "pendulum", {}, 10, {"bob.x", "bob.z"}), 100,
        [](const std::vector<double>& times) { return pendulum_angle(times, fine_step); },
        [](double a) {
            return std::array{-std::cos(a), -std::sin(a)};
        },
        "one ordinary differential equation of the angle, elliptic functions");
}

Entry four_bar(int loops) {
    return with_angle(
        entry("four-bar", loops, "four-bar", {{"loops", std::to_string(loops)}}, 10, {"top0.x", "top0.z"}),
        100, [loops](const std::vector<double>& times) { return four_bar_angle(loops, times, fine_step); },
        [](double a) {
            return std::array{std::sin(a), std::cos(a)};
        },
        "one ordinary differential equation of the cranks' common angle");
}

Entry chain(int links) {
    Entry e = with_steps(entry("chain", links, "chain", {{"links", std::to_string(links)}, {"thin", "1"}}, 1,
                               {"tip.x", "tip.z"}),
                         5e-2, 1e-2);
    if (links > 16)
        return converged(e, {"rk4", 0, 5e-5});
    return with_table(
        e, {fmt::format("r5_chain_N{}.csv", links), {"tip_x", "tip_z"}, 1e-12, "minimal coordinates"});
}

Entry suspension(int units, const std::string& joints) {
    const bool contacts = joints == "clearance" || joints == "mixed";
    std::vector<std::string> heights;
    for (int k = 0; k < units; ++k)
        heights.push_back(fmt::format("chassis{}.z", k));
    double end = 5;
    if (contacts) // later both references part: tenfold every 0.15 s
        end = units == 1 ? 1 : units > 4 && joints == "clearance" ? 0.1 : 0.25;
    Entry e = entry(joints == "bushing" ? "suspension-chain" : "suspension-chain " + joints, units,
                    "suspension-chain", {{"units", std::to_string(units)}, {"joints", joints}}, end, heights);
    e = with_steps(e, joints == "perfect" ? 2e-2 : 1e-3, 1e-2);
    const double rtol = units == 1 ? 1e-12 : units <= 4 ? 1e-11 : 1e-10; // tighter ones take hours
    if (contacts)
        return converged(e, {"ida", rtol, 0}, {"radau", rtol, 0});
    return converged(e, {"rk4", 0, 5e-5}, {"radau", rtol, 0});
}

Entry hmmwv_corner(const std::string& joints) {
    Entry e = entry(joints == "bushing" ? "hmmwv-corner" : "hmmwv-corner perfect", 1, "hmmwv-corner",
                    {{"joints", joints}}, 5, axes({"spindle", "upright"}));
    return converged(with_steps(e, joints == "perfect" ? 1e-2 : 1e-4, 1e-2), {"rk4", 0, 5e-5});
}

std::vector<Entry> rigid() {
    std::vector<Entry> list{pendulum(), chain(4), chain(16), chain(64), four_bar(1), four_bar(10)};
    list.push_back(
        with_table(with_steps(entry("slider-crank", 1, "slider-crank", {}, 5, {"slider.x"}), 1e-2, 1e-2),
                   {"r1_slider_crank_ideal.csv", {"x"}, 1e-12, "energy integral"}));
    list.push_back(with_table(
        with_steps(entry("heavy-top", 1, "heavy-top", {}, 2, {"top.x", "top.y", "top.z"}), 4e-2, 1e-2),
        {"r7_slow_top_b.csv", {"cx", "cy", "cz"}, 1e-15, "elliptic functions"}));
    list.push_back(converged(with_steps(entry("triple-pendulum free", 1, "triple-pendulum", {{"stops", "0"}},
                                              4, axes({"body1", "body2", "body3"})),
                                        4e-2, 2e-2),
                             {"rk4", 0, 5e-5}));
    return list;
}

std::vector<Entry> compliant() {
    std::vector<Entry> list;
    for (const char* joints : {"bushing", "perfect"})
        for (const int units : {1, 4, 16})
            list.push_back(suspension(units, joints));
    for (const char* joints : {"bushing", "perfect"})
        list.push_back(hmmwv_corner(joints));
    return list;
}

std::vector<Entry> touching() {
    std::vector<Entry> list;
    list.push_back(
        with_table(with_steps(entry("slider-crank spherical", 1, "slider-crank", {{"joint", "spherical"}}, 5,
                                    {"slider.x"}),
                              1e-3, 1e-3),
                   {"r2_spherical_c100um.csv", {"x"}, 1e-11, "minimal coordinates, events located"}));
    list.push_back(
        with_table(with_steps(entry("slider-crank revolute", 1, "slider-crank", {{"joint", "revolute"}}, 0.5,
                                    {"slider.x"}),
                              1e-3, 1e-3),
                   {"r10_mid_c100um_clipped.csv", {"x"}, 1e-11, "minimal coordinates, events located"}));
    list.push_back(
        with_table(with_steps(entry("triple-pendulum", 1, "triple-pendulum", {}, 4,
                                    {"J1.angle", "J2.slide", "J2.angle", "J3.angle"}),
                              2e-3, 2e-3),
                   {"r3_Z_LN.csv", {"q1", "s", "phi", "psi"}, 1e-11, "minimal coordinates, events located"}));
    list.push_back(converged(
        with_steps(entry("triple-pendulum kelvin-voigt", 1, "triple-pendulum", {{"law", "kelvin-voigt"}}, 4,
                         {"J1.angle", "J2.slide", "J2.angle", "J3.angle"}),
                   2e-3, 2e-3),
        ida));
    for (const char* joints : {"clearance", "mixed"})
        for (const int units : {1, 4, 16})
            list.push_back(suspension(units, joints));
    list.push_back(with_table(
        with_steps(entry("bouncing-journal", 1, "bouncing-journal", {}, 1, {"journal.z"}), 1e-3, 1e-3),
        {"r4_LN_e75.csv", {"-u"}, 3e-14, "one ordinary differential equation, events located"}));
    list.push_back(
        with_table(with_steps(entry("bouncing-journal cylinder", 1, "bouncing-journal", {{"law", "cylinder"}},
                                    1, {"journal.z"}),
                              1e-4, 1e-4),
                   {"r4_CYL_e75.csv", {"-u"}, 1e-13, "one ordinary differential equation, events located"}));
    list.push_back(with_table(
        with_steps(entry("tilted-journal", 1, "tilted-journal", {}, 0.2, axes({"journal"})), 1e-4, 1e-4),
        {"r9_a_clipped.csv", {"cx", "cy", "cz"}, 1e-13, "free body, events located"}));
    list.push_back(converged(with_steps(entry("tilted-journal cylinder", 1, "tilted-journal",
                                              {{"law", "cylinder"}}, 0.1, axes({"journal"})),
                                        2e-5, 2e-5),
                             ida));
    list.push_back(converged(
        with_steps(entry("stick-slip", 1, "stick-slip", {}, 40, {"block.x"}), 2e-4, 1e-2), {"rk4", 0, 2e-5}));
    return list;
}

const std::vector<Entry>& entries() {
    static const std::vector<Entry> all = [] {
        std::vector<Entry> list = rigid();
        for (const auto& more : {compliant(), touching()})
            list.insert(list.end(), more.begin(), more.end());
        return list;
    }();
    return all;
}

void load_independent(Problem& problem, const Independent& source, const std::filesystem::path& tables) {
    const SolutionTable table = read_table(tables / source.file);
    const std::vector<double>& t = table.column("t");
    const std::size_t count = std::upper_bound(t.begin(), t.end(), problem.end * (1 + 1e-12)) - t.begin();
    if (count == 0 || t[count - 1] < problem.end * (1 - 1e-12))
        throw std::runtime_error(fmt::format("{} ends before {} s", source.file, problem.end));
    problem.times.assign(t.begin(), t.begin() + count);
    Solution solution;
    for (const std::string& name : source.columns) {
        const bool turned = name[0] == '-';
        const std::vector<double>& column = table.column(turned ? name.substr(1) : name);
        solution.values.emplace_back(column.begin(), column.begin() + count);
        for (double& value : solution.values.back())
            value = turned ? -value : value;
    }
    problem.solutions = {solution};
    problem.believed = source.believed;
    problem.reference = fmt::format("{} ({})", source.file, source.what);
}

double largest_difference(const Solution& a, const Solution& b) {
    double largest = 0;
    for (std::size_t c = 0; c < a.values.size(); ++c)
        for (std::size_t k = 0; k < a.values[c].size(); ++k)
            largest = std::max(largest, std::abs(a.values[c][k] - b.values[c][k]));
    return largest;
}

void load_converged(Problem& problem, const std::filesystem::path& data) {
    std::vector<std::string> names;
    for (const Making& making : problem.makings) {
        const auto file = data_file(problem, making, data);
        const SolutionTable table = read_table(file);
        if (problem.solutions.empty())
            problem.times = table.column("t");
        if (table.column("t") != problem.times || problem.times.back() != problem.end)
            throw std::runtime_error(file.string() + " holds other times");
        Solution solution{making.integrator, {}};
        for (const std::string& channel : problem.channels)
            solution.values.push_back(table.column(channel));
        problem.solutions.push_back(solution);
        names.push_back(making.integrator);
    }
    problem.believed = largest_difference(problem.solutions[0], problem.solutions[1]);
    problem.reference =
        fmt::format("{} and {}, which differ by {:.1e}", names[0], names[1], problem.believed);
}

/// Methods that share their formulas.
std::string family(const std::string& integrator) {
    return integrator == "gear" || integrator == "ida" ? "bdf" : integrator;
}

} // namespace

std::string Problem::id() const {
    std::string word = mechanism;
    std::replace(word.begin(), word.end(), ' ', '-');
    return base == "chain" || base == "four-bar" || base == "suspension-chain"
               ? fmt::format("{}-{}", word, size)
               : word;
}

Model Problem::model() const { return build_mechanism(base, parameters); }

const Solution& Problem::solution_for(const std::string& integrator) const {
    for (const Solution& solution : solutions) {
        const bool shared = integrator == "auto" ? solution.made_by == "gear" || solution.made_by == "radau"
                                                 : family(solution.made_by) == family(integrator);
        if (solution.made_by.empty() || !shared)
            return solution;
    }
    throw std::logic_error(fmt::format("{}: no reference of another method than {}", id(), integrator));
}

std::vector<Problem> list_problems() {
    std::vector<Problem> list;
    for (const Entry& e : entries()) {
        list.push_back(e.problem);
        if (!e.problem.makings.empty())
            for (int k = 1; k <= compared_times; ++k)
                list.back().times.push_back(e.problem.end * k / compared_times);
    }
    return list;
}

void load_reference(Problem& problem, const std::filesystem::path& tables,
                    const std::filesystem::path& data) {
    for (const Entry& e : entries()) {
        if (e.problem.id() != problem.id())
            continue;
        if (e.table) {
            load_independent(problem, *e.table, tables);
        } else if (e.exact) {
            problem.solutions = {e.exact(problem.times)};
            problem.believed = e.exact_believed;
        } else {
            load_converged(problem, data);
        }
    }
}

std::filesystem::path data_file(const Problem& problem, const Making& making,
                                const std::filesystem::path& data) {
    return data / fmt::format("{}.{}.csv", problem.id(), making.integrator);
}

std::vector<Problem> chosen_problems(const std::vector<std::string>& globs, int largest) {
    const auto fits = [&](const Problem& problem) {
        return globs.empty() || std::any_of(globs.begin(), globs.end(), [&](const std::string& glob) {
                   return fnmatch(glob.c_str(), problem.id().c_str(), 0) == 0;
               });
    };
    std::vector<Problem> chosen;
    for (const Problem& problem : list_problems())
        if (problem.size <= largest && fits(problem))
            chosen.push_back(problem);
    return chosen;
}

namespace {

std::vector<double> angle_of(const std::function<long double(long double)>& acceleration, long double speed,
                             const std::vector<double>& times, double step) {
    using Pair = std::array<long double, 2>; // a, a'
    const auto slope = [&](const Pair& y) { return Pair{y[1], acceleration(y[0])}; };
    const auto moved = [](const Pair& y, long double h, const Pair& k) {
        return Pair{y[0] + h * k[0], y[1] + h * k[1]};
    };
    std::vector<double> angles;
    Pair y{0, speed};
    long double t = 0;
    for (const double end : times) {
        const long steps = std::max(1L, std::lround((end - static_cast<double>(t)) / step));
        const long double h = (end - t) / steps;
        for (long i = 0; i < steps; ++i) {
            const Pair k1 = slope(y), k2 = slope(moved(y, h / 2, k1)), k3 = slope(moved(y, h / 2, k2)),
                       k4 = slope(moved(y, h, k3));
            for (int j : {0, 1})
                y[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
        }
        t = end;
        angles.push_back(static_cast<double>(y[0]));
    }
    return angles;
}

} // namespace

std::vector<double> pendulum_angle(const std::vector<double>& times, double step) {
    return angle_of([](long double a) { return 9.81L * std::cos(a); }, 0, times, step);
}

std::vector<double> four_bar_angle(int loops, const std::vector<double>& times, double step) {
    const long double rate = 9.81L * (9 * loops + 3) / (8 * loops + 2);
    return angle_of([rate](long double a) { return rate * std::sin(a); }, 1, times, step);
}

} // namespace gudgeon::work_precision
