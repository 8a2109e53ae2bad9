#include "app/result_files.hpp"

#include "app/file_tools.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <array>
#include <sstream>

namespace gudgeon {

namespace fs = std::filesystem;

namespace {

void remove_earlier(const fs::path& file) {
    std::error_code error;
    if (fs::is_directory(fs::symlink_status(file, error)))
        throw FileError(fmt::format("{}: is a folder, where a file of results belongs", file.string()));
    fs::remove(file, error);
    if (error)
        throw FileError(fmt::format("{}: cannot be replaced: {}", file.string(), error.message()));
}

} // namespace

ResultFiles::ResultFiles(const fs::path& folder, const Channels& channels, bool steps, bool contacts)
    : folder_(folder) {
    make_folder(folder);
    // the checkpoint first: it must never be found beside the files of another run
    for (const char* name :
         {checkpoint_name, "trajectory.csv", "trajectory.h5", "summary.json", "steps.csv", "contacts.csv"})
        remove_earlier(folder / name);
    csv_.emplace(folder / "trajectory.csv", channels.names());
    hdf5_.emplace(folder / "trajectory.h5", channels.names(), channels.units());
    if (steps)
        steps_.emplace(folder / "steps.csv", std::vector<std::string>{"h", "order", "error", "outcome"});
    if (contacts)
        contacts_.emplace(folder / "contacts.csv",
                          std::vector<std::string>{"depth", "speed", "event", "joint", "contact"});
}

ResultFiles::ResultFiles(const fs::path& folder, const Channels& channels, const FilePositions& positions)
    : folder_(folder) {
    csv_.emplace(folder / "trajectory.csv", positions.trajectory);
    if (positions.steps)
        steps_.emplace(folder / "steps.csv", *positions.steps);
    if (positions.contacts)
        contacts_.emplace(folder / "contacts.csv", *positions.contacts);
    remove_earlier(folder / "trajectory.h5");
    remove_earlier(folder / "summary.json");
    hdf5_.emplace(folder / "trajectory.h5", channels.names(), channels.units());
}

void ResultFiles::restore_hdf5(const Channels& channels) {
    read_csv_rows(folder_ / "trajectory.csv", channels.names().size(),
                  [this](double t, std::span<const double> values) { hdf5_->append(t, values); });
}

FilePositions ResultFiles::sync() {
    FilePositions at;
    csv_->sync();
    at.trajectory = csv_->length();
    if (steps_) {
        steps_->sync();
        at.steps = steps_->length();
    }
    if (contacts_) {
        contacts_->sync();
        at.contacts = contacts_->length();
    }
    return at;
}

void ResultFiles::write_checkpoint(const Archive& archive) {
    std::ostringstream stream;
    write_sealed(stream, archive);
    write_atomically(folder_ / checkpoint_name, stream.view());
}

void ResultFiles::remove_checkpoint() {
    std::error_code ignored; // of no use any more, but no harm either
    fs::remove(folder_ / checkpoint_name, ignored);
}

bool ResultFiles::has_checkpoint() const {
    std::error_code error;
    return fs::exists(folder_ / checkpoint_name, error);
}

void ResultFiles::append(double t, std::span<const double> values) {
    csv_->append(t, values);
    hdf5_->append(t, values);
}

void ResultFiles::append(const StepRecord& step) {
    if (steps_)
        steps_->append(step.t, std::array{step.h, double(step.order), step.error},
                       step_reason_name(step.reason));
}

void ResultFiles::append(const ContactEvent& event, const System& system) {
    if (!contacts_)
        return;
    const ContactChannel& channel = system.contacts[event.channel];
    const char* kind = event.kind == ContactEvent::Kind::start  ? "start"
                       : event.kind == ContactEvent::Kind::end  ? "end"
                       : event.kind == ContactEvent::Kind::deep ? "deep"
                                                                : "rejected";
    const std::string place =
        channel.number > 0 ? fmt::format("{} {}", channel.place, channel.number) : std::string(channel.place);
    contacts_->append(event.t, std::array{event.depth, event.speed},
                      fmt::format("{},{},{}", kind, system.joints[channel.joint].name, place));
}

void ResultFiles::flush() {
    if (contacts_)
        contacts_->flush();
    if (steps_)
        steps_->flush();
    csv_->flush();
    hdf5_->flush();
}

void ResultFiles::write_summary(const nlohmann::ordered_json& summary) {
    const fs::path file = folder_ / "summary.json";
    write_atomically(file,
                     summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

} // namespace gudgeon
