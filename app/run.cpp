#include "app/run.hpp"

#include "app/clocks.hpp"
#include "app/exit_codes.hpp"
#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/result_files.hpp"
#include "app/run_record.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gudgeon {

namespace {

constexpr std::size_t most_columns = 2000;

SimulationOptions simulation_options(const RunArguments& arguments) {
    SimulationOptions options;
    options.integrator = arguments.integrator;
    options.integration.rtol = arguments.rtol;
    options.integration.atol = arguments.atol.value_or(arguments.rtol);
    options.integration.step = arguments.step.value_or(
        options.integrator == "rk4" || options.integrator == "bayo" ? 1e-3 : options.integration.step);
    options.integration.max_order = arguments.max_order;
    options.integration.threads = arguments.threads;
    options.integration.onset = arguments.onset;
    options.integration.formulation = formulation_named(arguments.formulation);
    options.start = arguments.start == "equilibrium" ? Start::equilibrium : Start::as_given;
    return options;
}

OutputGrid output_grid(const RunArguments& arguments, const Model& model) {
    const double end = arguments.end.value_or(model.end.value_or(1.0));
    const bool usual = model.every && *model.every <= end; // a much shorter run gets its own interval
    const double every = arguments.every.value_or(usual ? *model.every : end / 100);
    try {
        return {end, every};
    } catch (const std::invalid_argument& error) {
        throw UsageError("--every", error.what(), "a longer interval");
    }
}

Channels choose_channels(const System& system, const std::vector<std::string>& globs) {
    if (const std::size_t all = Channels::count_all(system); globs.empty() && all > most_columns) {
        std::string examples = "'energy.*'";
        if (!system.markers.empty())
            examples = fmt::format("'{}.?', ", system.markers.front().name) + examples;
        if (!system.joints.empty())
            examples = fmt::format("'{}.f?', ", system.joints.front().name) + examples;
        examples = fmt::format("'*.z', '{}.*', ", system.body_names.front()) + examples;
        throw UsageError("--channels",
                         fmt::format("the model has {} columns, more than the {} that are written unasked",
                                     all, most_columns),
                         "a choice of names with * and ?, several divided by commas, such as " + examples);
    }
    try {
        return Channels(system, globs);
    } catch (const std::invalid_argument& error) {
        throw UsageError("--channels", error.what(), "names of columns with * and ?");
    }
}

void begin_hdf5(Hdf5File& file, const LoadedModel& loaded, const SimulationOptions& options,
                const Simulation& sim) {
    file.attribute("model", loaded.model.name);
    file.attribute("parameters", loaded.parameters.dump());
    file.attribute("integrator", sim.integrator_name());
    file.attribute("rtol", options.integration.rtol);
    file.attribute("atol", options.integration.atol);
    file.attribute("version", GUDGEON_VERSION);
}

/// Steps freely and samples inside the steps; stops at the first failure or signal.
class Loop {
  public:
    Loop(Simulation& sim, const OutputGrid& grid, const Channels& channels, ResultFiles& files,
         Progress& progress, const InterruptGuard& interrupt, RunRecord& record)
        : sim_(sim), grid_(grid), channels_(channels), files_(files), progress_(progress),
          interrupt_(interrupt), record_(record), row_(channels.names().size()) {}

    void run() {
        for (std::size_t k = 0; k < grid_.size(); ++k) {
            if (!step_past(grid_.time(k)))
                return;
            write(grid_.time(k));
        }
    }

  private:
    bool step_past(double t) {
        if (interrupt_.requested())
            return stop(RunRecord::Status::interrupted, "interrupted by the user");
        while (sim_.time() < t) {
            // One step: the next representable time lies inside it.
            const double inside = std::nextafter(sim_.time(), std::numeric_limits<double>::infinity());
            const StepOutcome outcome = sim_.advance_past(inside, grid_.end());
            if (!outcome.ok)
                return stop(RunRecord::Status::failed, outcome.message);
            progress_.update(sim_.time(), ++steps_);
            if (interrupt_.requested() && sim_.time() < t)
                return stop(RunRecord::Status::interrupted, "interrupted by the user");
        }
        return true;
    }

    bool stop(RunRecord::Status status, const std::string& reason) {
        record_.status = status;
        record_.reason = reason;
        return false;
    }

    void write(double t) {
        const Sample& sample = sim_.sample_at(t);
        const double begin = wall_seconds();
        channels_.read(sample, row_);
        files_.append(t, row_);
        record_.write_seconds += wall_seconds() - begin;
        record_.balance_max = std::max(record_.balance_max, std::abs(sample.balance));
        ++record_.samples;
    }

    Simulation& sim_;
    const OutputGrid& grid_;
    const Channels& channels_;
    ResultFiles& files_;
    Progress& progress_;
    const InterruptGuard& interrupt_;
    RunRecord& record_;
    std::vector<double> row_;
    long steps_ = 0;
};

/// Runs the loop, whatever ends it, and completes the record and the trajectories.
void integrate(Loop& loop, Simulation& sim, ResultFiles& files, RunRecord& record) {
    const double cpu = cpu_seconds(), wall = wall_seconds();
    try {
        loop.run();
    } catch (const FileError&) {
        throw;
    } catch (const std::exception& error) {
        record.status = RunRecord::Status::failed;
        record.reason = fmt::format("at t = {:.9g} s: {}", sim.time(), error.what());
    }
    record.reached = sim.time();
    const double begin = wall_seconds();
    files.hdf5().attribute("status", status_name(record.status));
    files.flush();
    record.write_seconds += wall_seconds() - begin;
    record.cpu_seconds = cpu_seconds() - cpu;
    record.wall_seconds = wall_seconds() - wall;
}

} // namespace

int run(const RunArguments& arguments, const Console& console) {
    RunRecord record;
    const double begin = cpu_seconds();
    const InterruptGuard interrupt;
    const LoadedModel loaded = load_model(arguments.model);
    const OutputGrid grid = output_grid(arguments, loaded.model);
    SimulationOptions options = simulation_options(arguments);
    std::vector<ContactEvent> at_start; // before there are files
    ResultFiles* log = nullptr;
    const System* system = nullptr;
    if (arguments.contacts)
        options.on_contact = [&](const ContactEvent& event) {
            if (log)
                log->append(event, *system);
            else
                at_start.push_back(event);
        };
    Simulation sim(loaded.model, options);
    const Channels channels = choose_channels(sim.system(), arguments.channels);
    ResultFiles files(arguments.out.value_or(loaded.model.name), channels, arguments.steps,
                      arguments.contacts);
    system = &sim.system();
    log = &files;
    for (const ContactEvent& event : at_start)
        files.append(event, *system);
    if (arguments.steps)
        sim.integrator().on_step = [&files](const StepRecord& step) { files.append(step); };
    begin_hdf5(files.hdf5(), loaded, options, sim);
    record.columns = channels.names().size();
    record.setup_phases = sim.statistics().seconds;
    record.setup_seconds = cpu_seconds() - begin;
    if (!arguments.quiet)
        console.out << assembly_report(sim.system(), sim.assembly())
                    << (sim.statics() ? equilibrium_report(sim.system(), *sim.statics()) : "")
                    << notice_report(sim.notices()) << std::flush;

    try {
        Progress progress(console, !arguments.quiet, grid.end());
        Loop loop(sim, grid, channels, files, progress, interrupt, record);
        integrate(loop, sim, files, record);
    } catch (const FileError& error) {
        // The disk may be full: say so in the summary, if that can still be written.
        record.status = RunRecord::Status::failed;
        record.reason = error.what();
        record.reached = sim.time();
        try {
            files.write_summary(summary(arguments, options, loaded, sim, grid, record));
        } catch (const FileError&) {
            // the first error is the one to tell
        }
        throw;
    }
    files.write_summary(summary(arguments, options, loaded, sim, grid, record));
    if (!arguments.quiet)
        console.out << run_report(loaded, sim, record, files.folder());
    switch (record.status) {
    case RunRecord::Status::ok:
        return Exit::ok;
    case RunRecord::Status::interrupted:
        return Exit::interrupted;
    case RunRecord::Status::failed:
        break;
    }
    console.err << fmt::format("{}: the integration stopped: {}\n", loaded.model.source, record.reason);
    return Exit::stopped;
}

} // namespace gudgeon
