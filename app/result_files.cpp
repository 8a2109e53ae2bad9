#include "app/result_files.hpp"

#include "app/text_files.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <array>

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
    for (const char* name : {"trajectory.csv", "trajectory.h5", "summary.json", "steps.csv", "contacts.csv"})
        remove_earlier(folder / name);
    csv_.emplace(folder / "trajectory.csv", channels.names());
    hdf5_.emplace(folder / "trajectory.h5", channels.names(), channels.units());
    if (steps)
        steps_.emplace(folder / "steps.csv", std::vector<std::string>{"h", "order", "error", "outcome"});
    if (contacts)
        contacts_.emplace(folder / "contacts.csv",
                          std::vector<std::string>{"depth", "speed", "event", "joint", "contact"});
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
    write_text(folder_ / "summary.json",
               summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
}

} // namespace gudgeon
