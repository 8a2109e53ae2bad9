#include "app/session.hpp"

#include "app/clocks.hpp"
#include "app/exit_codes.hpp"
#include "app/file_tools.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

namespace gudgeon {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_columns = 2000;
// Bytes of a number in both trajectories: "0," and 8, and as most are.
constexpr double least_bytes = 2 + 8, usual_bytes = 20 + 8;
constexpr double full = 1e6; // bytes: less is no space

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

Archive read_checkpoint(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw FileError(
            fmt::format("{}: there is no checkpoint to go on from: {}; allowed: the folder of a run "
                        "that was interrupted, or ended before its time with --checkpoint",
                        file.string(), std::strerror(errno)));
    return read_sealed(stream);
}

} // namespace

Session::Session(const RunArguments& given, LoadedModel model)
    : arguments(given), loaded(std::move(model)), grid(output_grid(given, loaded.model)),
      options(simulation_options()), sim(take_model(loaded), options),
      channels(choose_channels(sim.system(), given.channels)) {
    record.columns = channels.names().size();
    record.setup_phases = sim.statistics().seconds;
}

SimulationOptions Session::simulation_options() {
    SimulationOptions out;
    out.integrator = arguments.integrator;
    out.integration.rtol = arguments.rtol;
    out.integration.atol = arguments.atol.value_or(arguments.rtol);
    const bool fixed_step = out.integrator == "rk4" || out.integrator == "bayo";
    out.integration.step = arguments.step.value_or(fixed_step ? 1e-3 : out.integration.step);
    out.integration.max_order = arguments.max_order;
    out.integration.threads = arguments.threads;
    out.integration.onset = arguments.onset;
    out.integration.formulation = formulation_named(arguments.formulation);
    out.start = arguments.start == "equilibrium" ? Start::equilibrium : Start::as_given;
    if (arguments.contacts)
        out.on_contact = [this](const ContactEvent& event) {
            if (files)
                files->append(event, sim.system());
            else
                at_start_.push_back(event);
        };
    return out;
}

bool Session::model_file_differs() const {
    try {
        return read_model_text(arguments.model.model) != loaded.text;
    } catch (const FileError&) {
        return true;
    }
}

void Session::begin_files() {
    const fs::path folder = arguments.out.value_or(loaded.model.name);
    files.emplace(folder, channels, arguments.steps, arguments.contacts);
    for (const ContactEvent& event : at_start_)
        files->append(event, sim.system());
    const double numbers =
        static_cast<double>(grid.size()) * static_cast<double>(channels.names().size() + 1);
    const auto space = static_cast<double>(free_space(folder));
    const std::string found = fmt::format(
        "{} times x {} columns take about {}, {} are free in {}", grid.size(), channels.names().size(),
        size_in_words(usual_bytes * numbers), size_in_words(space), folder.string());
    if (space < std::min(least_bytes * numbers, full))
        throw FileError(
            fmt::format("{}: the disk is full: {}; allowed: --out elsewhere", folder.string(), found));
    if (usual_bytes * numbers > space)
        record.space =
            "the disk will be full before the end: " + found +
            "; a longer --every or fewer --channels take less, --checkpoint lets the run go on later";
    connect_files();
}

void Session::connect_files() {
    if (arguments.steps)
        sim.integrator().on_step = [this](const StepRecord& step) { files->append(step); };
    Hdf5File& file = files->hdf5();
    file.attribute("model", loaded.model.name);
    file.attribute("parameters", loaded.parameters.dump());
    file.attribute("integrator", sim.integrator_name());
    file.attribute("rtol", options.integration.rtol);
    file.attribute("atol", options.integration.atol);
    file.attribute("version", GUDGEON_VERSION);
}

void Session::visit(Archive& archive) { archive(record, next, checkpoint_at_, positions_, sim); }

void Session::save_checkpoint() {
    const double begin = wall_seconds();
    positions_ = files->sync();
    count_time();
    Archive archive;
    archive.section("run");
    archive.same(std::string(GUDGEON_VERSION), "another version of the program");
    RunArguments given = arguments;
    std::string text = loaded.text;
    archive(given, text);
    visit(archive);
    files->write_checkpoint(archive);
    record.write_seconds += wall_seconds() - begin;
}

void Session::save_when_due() {
    if (!arguments.checkpoint || sim.time() < checkpoint_at_)
        return;
    checkpoint_at_ = (std::floor(sim.time() / *arguments.checkpoint) + 1) * *arguments.checkpoint;
    save_checkpoint();
}

std::unique_ptr<Session> Session::from_checkpoint(const fs::path& folder) {
    const fs::path file = folder / ResultFiles::checkpoint_name;
    const double begin = cpu_seconds();
    try {
        Archive archive = read_checkpoint(file);
        archive.section("run");
        archive.same(std::string(GUDGEON_VERSION), "another version of the program");
        RunArguments given;
        std::string text;
        archive(given, text);
        auto session = std::make_unique<Session>(given, load_again(given.model, text));
        session->visit(archive);
        archive.finish();
        session->files.emplace(folder, session->channels, session->positions_);
        session->connect_files();
        session->files->restore_hdf5(session->channels);
        if (!session->sim.integrator().goes_on_exactly())
            session->record.restarts.push_back(session->sim.time());
        session->record.setup_seconds += cpu_seconds() - begin;
        return session;
    } catch (const ArchiveError& error) {
        throw FileError(fmt::format("{}: the checkpoint {}", file.string(), error.what()));
    }
}

void Session::start_clock() {
    cpu_ = cpu_seconds();
    wall_ = wall_seconds();
}

void Session::count_time() {
    const double cpu = cpu_, wall = wall_;
    start_clock();
    record.cpu_seconds += cpu_ - cpu;
    record.wall_seconds += wall_ - wall;
}

} // namespace gudgeon
