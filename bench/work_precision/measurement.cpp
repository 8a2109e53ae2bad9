#include "bench/work_precision/measurement.hpp"

#include "bench/common/machine.hpp"
#include "bench/work_precision/solution_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace gudgeon::work_precision {

namespace {

bool has_fixed_step(const std::string& integrator) { return integrator == "rk4" || integrator == "bayo"; }
bool has_formulations(const std::string& integrator) { return integrator == "gear" || integrator == "radau"; }

/// Formulation of the others: explicit methods in joint coordinates, `auto` as it likes.
const char* own(const std::string& integrator) {
    return integrator == "auto" ? "auto" : is_explicit(integrator) ? "tree" : "saddle-point";
}

/// Curves: the runs of one integrator and formulation, the cheapest first.
std::vector<std::vector<Settings>> curves_of(const Problem& problem, const Options& options) {
    std::vector<std::vector<Settings>> curves;
    for (const std::string& integrator : options.integrators) {
        if (has_fixed_step(integrator)) {
            auto& curve = curves.emplace_back();
            for (int k = 0; k < options.fixed_steps; ++k)
                curve.push_back({integrator, 1e-6,
                                 (integrator == "rk4" ? problem.rk4_step : problem.bayo_step) / (1 << k),
                                 "saddle-point"});
            continue;
        }
        for (const std::string& formulation : options.formulations) {
            if (formulation != options.formulations[0] && !has_formulations(integrator))
                continue;
            auto& curve = curves.emplace_back();
            for (const double rtol : options.tolerances)
                curve.push_back(
                    {integrator, rtol, 0, has_formulations(integrator) ? formulation : own(integrator)});
        }
    }
    return curves;
}

std::vector<Row> run_curve(const Problem& problem, const std::vector<Settings>& curve, double longest) {
    std::vector<Row> rows;
    bool too_long = false;
    for (const Settings& settings : curve) {
        if (too_long) {
            Row& row = rows.emplace_back();
            row.settings = settings;
            row.status = "not-run";
            row.error = std::nan("");
            continue;
        }
        rows.push_back(measure_error(problem, settings));
        too_long = !rows.back().seconds.empty() && rows.back().seconds[0] > longest;
    }
    return rows;
}

/// All of one tolerance in turn, fixed steps alone. What takes long is timed once, by the run with samples.
void time_rows(const Problem& problem, const Options& options, std::vector<Row>& rows) {
    std::vector<const Row*> done;
    for (Row& first : rows) {
        if (std::find(done.begin(), done.end(), &first) != done.end())
            continue;
        std::vector<Row*> together;
        for (Row& other : rows)
            if (&other == &first ||
                (other.settings.rtol == first.settings.rtol && other.settings.step == first.settings.step)) {
                done.push_back(&other);
                if (other.measured() && other.seconds[0] < options.budget)
                    together.push_back(&other);
            }
        if (options.repeats > 0)
            measure_times(problem, together, options.repeats, options.budget);
    }
}

struct Cell {
    const char* name;
    nlohmann::json value; // null: missing
};

nlohmann::json number(double value) {
    return std::isfinite(value) ? nlohmann::json(std::stod(fmt::format("{:.4g}", value))) : nlohmann::json();
}

/// One row, by column. The first twelve are those of every program's table.
std::vector<Cell> cells(const Problem& problem, const Row& row) {
    const Settings& settings = row.settings;
    const Statistics& s = row.statistics;
    const bool run = row.status != "not-run" && row.status != "refused",
               fixed = has_fixed_step(settings.integrator);
    const auto count = [run](long value) { return run ? nlohmann::json(value) : nlohmann::json(); };
    const double nan = std::nan("");
    return {
        {"program", "gudgeon"},
        {"mechanism", problem.mechanism},
        {"size", problem.size},
        {"method", settings.integrator},
        {"formulation",
         has_formulations(settings.integrator) ? nlohmann::json(settings.formulation) : nlohmann::json()},
        {"tolerance", number(fixed ? settings.step : settings.rtol)},
        {"status", row.status},
        {"error", number(row.error)},
        {"cpu_s", number(row.measured() ? *std::min_element(row.seconds.begin(), row.seconds.end()) : nan)},
        {"steps", count(s.steps)},
        {"evaluations", count(s.evaluations)},
        {"factorisations", count(s.factorisations)},
        {"refactorisations", count(s.refactorisations)},
        {"sweeps", count(s.newton_sweeps)},
        {"rejected_error", count(s.rejected_error)},
        {"rejected_newton", count(s.rejected_newton)},
        {"rejected_contact", count(s.rejected_contact)},
        {"cpu_median_s", number(row.measured() ? bench::median(row.seconds) : nan)},
        {"repeats", row.measured() ? nlohmann::json(row.seconds.size()) : nlohmann::json()},
        {"setup_s", number(run ? row.setup : nan)},
        {"bodies", count(row.bodies)},
        {"unknowns", count(row.unknowns)},
        {"reference", problem.reference},
        {"reference_believed", number(problem.believed)}};
}

std::string csv_cell(const nlohmann::json& value) {
    if (value.is_null())
        return "";
    if (!value.is_string())
        return value.dump();
    const std::string word = value.get<std::string>();
    return word.find(',') == std::string::npos ? word : '"' + word + '"';
}

class Output {
  public:
    explicit Output(const std::filesystem::path& folder) : folder_(folder) {
        std::filesystem::create_directories(folder);
        json_["machine"] = bench::describe_machine();
        json_["problems"] = nlohmann::json::array();
        json_["runs"] = nlohmann::json::array();
    }
    void add(const Problem& problem, const std::vector<Row>& rows) {
        json_["problems"].push_back({{"id", problem.id()},
                                     {"mechanism", problem.mechanism},
                                     {"size", problem.size},
                                     {"base", problem.base},
                                     {"parameters", problem.parameters},
                                     {"end", problem.end},
                                     {"channels", problem.channels},
                                     {"times", problem.times.size()},
                                     {"reference", problem.reference},
                                     {"reference_believed", problem.believed}});
        for (const Row& row : rows) {
            nlohmann::json run;
            std::vector<std::string> names, line;
            for (const Cell& cell : cells(problem, row)) {
                names.push_back(cell.name);
                line.push_back(csv_cell(cell.value));
                run[cell.name] = cell.value;
            }
            if (csv_.empty())
                csv_ = fmt::format("{}\n", fmt::join(names, ","));
            csv_ += fmt::format("{}\n", fmt::join(line, ","));
            json_["runs"].push_back(run);
        }
        json_["machine"]["load_end"] = bench::load_now();
        write("work_precision.csv", csv_);
        write("work_precision.json", json_.dump(1) + "\n");
    }

  private:
    void write(const std::string& name, const std::string& text) const {
        std::ofstream out(folder_ / name);
        out << text;
        out.close();
        if (!out)
            throw std::runtime_error((folder_ / name).string() + " cannot be written");
    }
    std::filesystem::path folder_;
    std::string csv_;
    nlohmann::json json_;
};

} // namespace

void measure_all(const Options& options) {
    Output output(options.out);
    for (Problem& problem : chosen_problems(options.problems, options.largest)) {
        const double begin = bench::wall_seconds();
        load_reference(problem, options.tables, options.data);
        std::vector<Row> rows;
        for (const auto& curve : curves_of(problem, options))
            for (Row& row : run_curve(problem, curve, options.longest))
                rows.push_back(std::move(row));
        time_rows(problem, options, rows);
        output.add(problem, rows);
        fmt::print(stderr, "{}: {} runs, {:.1f} s\n", problem.id(), rows.size(),
                   bench::wall_seconds() - begin);
    }
}

void write_problems(const Options& options) {
    std::filesystem::create_directories(options.out);
    std::ofstream list(options.out / "problems.csv");
    list << "id,mechanism,size,base,parameters,end,channels,reference_believed\n";
    for (Problem& problem : chosen_problems(options.problems, options.largest)) {
        load_reference(problem, options.tables, options.data);
        std::vector<std::string> parameters;
        for (const auto& [name, value] : problem.parameters)
            parameters.push_back(name + "=" + value);
        list << fmt::format("{},{},{},{},{},{},{},{:.1e}\n", problem.id(), problem.mechanism, problem.size,
                            problem.base, fmt::join(parameters, " "), problem.end,
                            fmt::join(problem.channels, " "), problem.believed);
        SolutionTable table;
        table.comments = {problem.reference};
        table.names = {"t"};
        table.values = {problem.times};
        table.names.insert(table.names.end(), problem.channels.begin(), problem.channels.end());
        const auto& values = problem.solutions[0].values;
        table.values.insert(table.values.end(), values.begin(), values.end());
        write_table(options.out / (problem.id() + ".csv"), table);
    }
    list.close();
    if (!list)
        throw std::runtime_error((options.out / "problems.csv").string() + " cannot be written");
}

} // namespace gudgeon::work_precision
