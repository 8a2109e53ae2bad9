// The folder of results: trajectory.csv, trajectory.h5, summary.json; steps.csv and contacts.csv where asked
// for.
#pragma once

#include "app/csv_file.hpp"
#include "app/hdf5_file.hpp"
#include "core/channels.hpp"
#include "solvers/integrator.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>

namespace gudgeon {

/// How far the files had come at a checkpoint, in bytes.
struct FilePositions {
    std::uint64_t trajectory = 0;
    std::optional<std::uint64_t> steps, contacts;
    void visit(Archive& archive) { archive(trajectory, steps, contacts); }
};

class ResultFiles {
  public:
    static constexpr const char* checkpoint_name = "checkpoint.gudgeon";

    /// Makes the folder if needed, removes earlier results of these names and begins new ones. Throws
    /// FileError, as do the others.
    ResultFiles(const std::filesystem::path& folder, const Channels& channels, bool steps = false,
                bool contacts = false);

    /// Goes on with the files of a folder from their positions at a checkpoint; what was written after it is
    /// dropped. trajectory.h5 begins anew, since a killed program may leave it unreadable.
    ResultFiles(const std::filesystem::path& folder, const Channels& channels,
                const FilePositions& positions);
    /// The rows of trajectory.csv once more into trajectory.h5: the same numbers.
    void restore_hdf5(const Channels& channels);

    const std::filesystem::path& folder() const { return folder_; }
    Hdf5File& hdf5() { return *hdf5_; }

    void append(double t, std::span<const double> values);
    /// One attempted step; nothing without steps.csv.
    void append(const StepRecord& step);
    /// One contact event; nothing without contacts.csv.
    void append(const ContactEvent& event, const System& system);
    /// Everything so far is on the disk and both trajectories can be read.
    void flush();
    /// Everything so far outlives a loss of power (but trajectory.h5); where that is.
    FilePositions sync();
    /// The checkpoint, in the place of the one before.
    void write_checkpoint(const Archive& archive);
    void remove_checkpoint();
    bool has_checkpoint() const;
    void write_summary(const nlohmann::ordered_json& summary);

  private:
    std::filesystem::path folder_;
    std::optional<CsvFile> csv_, steps_, contacts_;
    std::optional<Hdf5File> hdf5_;
};

} // namespace gudgeon
