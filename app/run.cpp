#include "app/run.hpp"

#include "app/clocks.hpp"
#include "app/exit_codes.hpp"
#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/session.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gudgeon {

namespace {

namespace fs = std::filesystem;

/// Steps freely and samples inside the steps; stops at the first failure or signal.
class Loop {
  public:
    Loop(Session& session, Progress& progress, const InterruptGuard& interrupt)
        : s_(session), progress_(progress), interrupt_(interrupt), row_(session.channels.names().size()) {}

    void run() {
        for (; s_.next < s_.grid.size(); ++s_.next) {
            if (!step_past(s_.grid.time(s_.next)))
                return;
            write(s_.grid.time(s_.next));
        }
    }

  private:
    // Ends and checkpoints only where the next output time lies ahead: no sample inside the last step is
    // missing.
    bool step_past(double t) {
        while (s_.sim.time() < t) {
            if (interrupt_.requested())
                return stop(RunRecord::Status::interrupted, "interrupted by the user");
            s_.save_when_due();
            // One step: the next representable time lies inside it.
            const double inside = std::nextafter(s_.sim.time(), std::numeric_limits<double>::infinity());
            const StepOutcome outcome = s_.sim.advance_past(inside, s_.grid.end());
            if (!outcome.ok)
                return stop(RunRecord::Status::failed, outcome.message);
            progress_.update(s_.sim.time(), s_.sim.statistics().steps);
        }
        return true;
    }

    bool stop(RunRecord::Status status, const std::string& reason) {
        s_.record.status = status;
        s_.record.reason = reason;
        return false;
    }

    void write(double t) {
        const Sample& sample = s_.sim.sample_at(t);
        const double begin = wall_seconds();
        s_.channels.read(sample, row_);
        s_.files->append(t, row_);
        RunRecord& record = s_.record;
        record.write_seconds += wall_seconds() - begin;
        record.balance_max = std::max(record.balance_max, std::abs(sample.balance));
        ++record.samples;
    }

    Session& s_;
    Progress& progress_;
    const InterruptGuard& interrupt_;
    std::vector<double> row_;
};

/// Runs the loop, whatever ends it, and completes the record and the trajectories.
void integrate(Session& s, Loop& loop) {
    RunRecord& record = s.record;
    s.start_clock();
    try {
        loop.run();
    } catch (const FileError&) {
        throw;
    } catch (const std::exception& error) {
        record.status = RunRecord::Status::failed;
        record.reason = fmt::format("at t = {:.9g} s: {}", s.sim.time(), error.what());
    }
    if (record.status == RunRecord::Status::interrupted)
        s.save_checkpoint();
    record.reached = s.sim.time();
    const double begin = wall_seconds();
    s.files->hdf5().attribute("status", status_name(record.status));
    s.files->flush();
    record.write_seconds += wall_seconds() - begin;
    s.count_time();
}

void write_summary(Session& s) {
    s.files->write_summary(summary(s.arguments, s.options, s.loaded, s.sim, s.grid, s.record));
}

/// The disk may be full: say so in the summary, if that can still be written, and how to go on later.
[[noreturn]] void end_without_disk(Session& s, const FileError& error) {
    s.record.status = RunRecord::Status::failed;
    s.record.reason = error.what();
    s.record.reached = s.sim.time();
    try {
        write_summary(s);
    } catch (const FileError&) {
        // the first error is the one to tell
    }
    if (!s.files->has_checkpoint())
        throw FileError(error);
    throw FileError(
        fmt::format("{}; once that is mended: gudgeon resume {}", error.what(), s.files->folder().string()));
}

int finish(Session& s, const Console& console, const InterruptGuard& interrupt, bool quiet) {
    try {
        Progress progress(console, !quiet, s.grid.end());
        Loop loop(s, progress, interrupt);
        integrate(s, loop);
        write_summary(s);
    } catch (const FileError& error) {
        end_without_disk(s, error);
    }
    if (!quiet)
        console.out << run_report(s.loaded, s.sim, s.record, s.files->folder());
    switch (s.record.status) {
    case RunRecord::Status::ok:
        s.files->remove_checkpoint();
        return Exit::ok;
    case RunRecord::Status::interrupted:
        console.err << fmt::format(
            "{}: interrupted at t = {:.9g} s of {:.9g} s; to go on: gudgeon resume {}\n",
            s.loaded.model.source, s.sim.time(), s.grid.end(), s.files->folder().string());
        return Exit::interrupted;
    case RunRecord::Status::failed:
        break;
    }
    console.err << fmt::format("{}: the integration stopped: {}\n", s.loaded.model.source, s.record.reason);
    return Exit::stopped;
}

bool complete(const fs::path& folder) {
    std::error_code error;
    return fs::exists(folder / "summary.json", error) &&
           !fs::exists(folder / ResultFiles::checkpoint_name, error);
}

} // namespace

int run(const RunArguments& arguments, const Console& console) {
    const double begin = cpu_seconds();
    const InterruptGuard interrupt;
    Session s(arguments, load_model(arguments.model));
    s.begin_files();
    s.record.setup_seconds = cpu_seconds() - begin;
    if (!arguments.quiet)
        console.out << assembly_report(s.sim.system(), s.sim.assembly())
                    << (s.sim.statics() ? equilibrium_report(s.sim.system(), *s.sim.statics()) : "")
                    << notice_report(s.sim.notices()) << std::flush;
    if (!s.record.space.empty())
        console.err << fmt::format("{}: {}\n", s.loaded.model.source, s.record.space);
    return finish(s, console, interrupt, arguments.quiet);
}

int resume(const ResumeArguments& arguments, const Console& console) {
    const InterruptGuard interrupt;
    const fs::path folder = arguments.folder;
    if (complete(folder))
        throw UsageError("DIR",
                         fmt::format("the run in {} has ended, it left no checkpoint", folder.string()),
                         "the folder of a run that was interrupted or killed");
    const std::unique_ptr<Session> s = Session::from_checkpoint(folder);
    const std::string& source = s->loaded.model.source;
    if (!arguments.quiet)
        console.out << fmt::format("{}: going on from t = {:.9g} s of {:.9g} s\n", source, s->sim.time(),
                                   s->grid.end());
    if (!s->loaded.ready && s->model_file_differs())
        console.err << fmt::format("{}: has changed since; the run goes on with the model as it was\n",
                                   source);
    if (!s->record.restarts.empty())
        console.err << fmt::format(
            "{}: {} starts anew at t = {:.9g} s: the same within the tolerances, not to "
            "the last bit\n",
            source, s->sim.integrator_name(), s->sim.time());
    return finish(*s, console, interrupt, arguments.quiet);
}

} // namespace gudgeon
