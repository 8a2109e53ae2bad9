// gudgeon_simbody: runs a model file of Gudgeon in Simbody (README.md).
//
//     gudgeon_simbody MODEL --integrator runge-kutta-merson --accuracy 1e-5 --end 1 --every 0.1 --channels
//     'tip.x,tip.z'
//         --out DIR
//
// DIR gets trajectory.csv and summary.json. Exit: 0 done, 2 usage or model refused, 4 the integration
// stopped, 5 files.
#include "app/clocks.hpp"
#include "bench/peers/simbody_system.hpp"
#include "core/reader.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ostream.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>

namespace {

using namespace gudgeon::peers;
using gudgeon::FileError;
using gudgeon::Model;
using gudgeon::ModelError;

struct Options {
    std::string model, out = "simbody", integrator = "runge-kutta-merson", channels = "*";
    double accuracy = 1e-5, end = 1, every = 0.1;
    double constraint_tolerance = 0; // 0: Simbody's own, a tenth of the accuracy
    bool interpolate = false, project_samples = false, infinity_norm = false;
    SimbodyOptions system;
};

using Maker = std::function<std::unique_ptr<SimTK::Integrator>(const SimTK::System&)>;

template <class Method> Maker plain() {
    return [](const SimTK::System& system) { return std::make_unique<Method>(system); };
}

Maker cpodes(SimTK::CPodes::LinearMultistepMethod method,
             SimTK::CPodes::NonlinearSystemIterationType iteration) {
    return [=](const SimTK::System& system) {
        return std::make_unique<SimTK::CPodesIntegrator>(system, method, iteration);
    };
}

const std::map<std::string, Maker>& makers() {
    using SimTK::CPodes;
    static const std::map<std::string, Maker> all{
        {"runge-kutta-merson", plain<SimTK::RungeKuttaMersonIntegrator>()},
        {"runge-kutta-feldberg", plain<SimTK::RungeKuttaFeldbergIntegrator>()},
        {"runge-kutta-3", plain<SimTK::RungeKutta3Integrator>()},
        {"runge-kutta-2", plain<SimTK::RungeKutta2Integrator>()},
        {"verlet", plain<SimTK::VerletIntegrator>()},
        {"semi-explicit-euler-2", plain<SimTK::SemiExplicitEuler2Integrator>()},
        {"cpodes-bdf", cpodes(CPodes::BDF, CPodes::Newton)},
        {"cpodes-adams", cpodes(CPodes::Adams, CPodes::Functional)},
    };
    return all;
}

std::vector<std::string> names_of(const std::map<std::string, Maker>& all) {
    std::vector<std::string> names;
    for (const auto& [name, make] : all)
        names.push_back(name);
    return names;
}

struct Results {
    std::vector<double> times;
    std::vector<std::vector<double>> rows;
    std::string reason; // why it stopped; empty: it did not
    double setup_seconds = 0, cpu_seconds = 0;
};

void sample(const SimTK::System& system, const SimTK::State& state, const std::vector<Channel>& channels,
            Results& results) {
    system.realize(state, SimTK::Stage::Velocity);
    results.times.push_back(state.getTime());
    std::vector<double>& row = results.rows.emplace_back();
    row.reserve(channels.size());
    for (const Channel& channel : channels)
        row.push_back(channel.value(state));
}

void integrate(SimTK::Integrator& integrator, const SimbodySystem& built,
               const std::vector<Channel>& channels, const Options& options, Results& results) {
    const auto count = static_cast<long>(std::ceil(options.end / options.every - 1e-9));
    const double begin = gudgeon::cpu_seconds();
    try {
        integrator.initialize(built.start);
        sample(built.system, integrator.getState(), channels, results);
        for (long k = 1; k <= count; ++k) {
            const double time = k == count ? options.end : static_cast<double>(k) * options.every;
            while (integrator.getTime() < time)
                integrator.stepTo(time);
            sample(built.system, integrator.getState(), channels, results);
        }
    } catch (const std::exception& error) { // Simbody's own type for a step that fails
        results.reason = error.what();
    }
    results.cpu_seconds = gudgeon::cpu_seconds() - begin;
}

void write_rows(const std::filesystem::path& file, const std::vector<Channel>& channels,
                const Results& results) {
    std::ofstream out(file);
    out << 't';
    for (const Channel& channel : channels)
        out << ',' << channel.name;
    for (std::size_t i = 0; i < results.times.size(); ++i)
        fmt::print(out, "\n{:.17g},{:.17g}", results.times[i], fmt::join(results.rows[i], ","));
    if (!(out << '\n'))
        throw FileError(file.string() + ": cannot be written");
}

void write_summary(const std::filesystem::path& file, const Options& options,
                   const SimTK::Integrator& integrator, const SimbodySystem& built, const Results& results) {
    const nlohmann::ordered_json out{{"program", "simbody"},
                                     {"integrator", options.integrator},
                                     {"accuracy", options.accuracy},
                                     {"constraint_tolerance", integrator.getConstraintToleranceInUse()},
                                     {"status", results.reason.empty() ? "ok" : "failed"},
                                     {"reason", results.reason},
                                     {"reached", results.times.empty() ? 0 : results.times.back()},
                                     {"bodies", built.bodies.size()},
                                     {"coordinates", built.start.getNQ()},
                                     {"speeds", built.start.getNU()},
                                     {"constraints", built.start.getNUErr()},
                                     {"steps", integrator.getNumStepsTaken()},
                                     {"steps_attempted", integrator.getNumStepsAttempted()},
                                     {"evaluations", integrator.getNumRealizations()},
                                     {"projections", integrator.getNumProjections()},
                                     {"setup_seconds", results.setup_seconds},
                                     {"cpu_seconds", results.cpu_seconds}};
    if (!(std::ofstream(file) << out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n'))
        throw FileError(file.string() + ": cannot be written");
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, ',');)
        parts.push_back(part);
    return parts;
}

int run(const Options& options) {
    const double begin = gudgeon::cpu_seconds();
    const Model model = gudgeon::read_model(options.model);
    const std::unique_ptr<SimbodySystem> built = build_simbody(model, options.system);
    const std::vector<Channel> channels = choose_channels(model, *built, split(options.channels));
    const std::unique_ptr<SimTK::Integrator> integrator = makers().at(options.integrator)(built->system);
    integrator->setAccuracy(options.accuracy);
    if (options.constraint_tolerance > 0)
        integrator->setConstraintTolerance(options.constraint_tolerance);
    integrator->setAllowInterpolation(options.interpolate);
    integrator->setProjectInterpolatedStates(options.project_samples);
    integrator->setUseInfinityNorm(options.infinity_norm);

    Results results;
    results.setup_seconds = gudgeon::cpu_seconds() - begin;
    integrate(*integrator, *built, channels, options, results);

    std::filesystem::create_directories(options.out);
    write_rows(std::filesystem::path(options.out) / "trajectory.csv", channels, results);
    write_summary(std::filesystem::path(options.out) / "summary.json", options, *integrator, *built, results);
    if (!results.reason.empty())
        std::cerr << options.model << ": the integration stopped: " << results.reason << '\n';
    return results.reason.empty() ? 0 : 4;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    CLI::App app("Runs a model file of Gudgeon in Simbody, in relative coordinates.", "gudgeon_simbody");
    app.add_option("MODEL", options.model, "model file (gudgeon export)")->required();
    app.add_option("--integrator", options.integrator)->check(CLI::IsMember(names_of(makers())));
    app.add_option("--accuracy", options.accuracy)->check(CLI::PositiveNumber);
    app.add_option("--end", options.end, "s")->check(CLI::PositiveNumber);
    app.add_option("--every", options.every, "output interval, s")->check(CLI::PositiveNumber);
    app.add_option("--channels", options.channels, "columns by name, * and ?, separated by commas");
    app.add_option("--out", options.out, "folder of the results");
    app.add_option("--constraint-tolerance", options.constraint_tolerance, "0: a tenth of the accuracy");
    app.add_flag("--interpolate", options.interpolate, "samples inside steps; else steps end at samples");
    app.add_flag("--project-samples", options.project_samples,
                 "put interpolated samples onto the constraints");
    app.add_flag("--infinity-norm", options.infinity_norm,
                 "of the errors, instead of their root mean square");
    app.add_flag("--euler-angles", options.system.euler_angles, "instead of quaternions");
    app.add_flag("--library-forces", options.system.library_forces,
                 "Simbody's own bushings (of another law) and springs");
    app.add_flag("--full-loops", options.system.full_loops, "five rows for every revolute joint of a loop");
    CLI11_PARSE(app, argc, argv);
    try {
        return run(options);
    } catch (const ModelError& error) {
        std::cerr << error.what() << '\n';
        return 2;
    } catch (const FileError& error) {
        std::cerr << error.what() << '\n';
        return 5;
    } catch (const std::exception& error) {
        std::cerr << options.model << ": " << error.what() << '\n';
        return 2;
    }
}
