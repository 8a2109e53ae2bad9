// The folder of results: trajectory.csv, trajectory.h5, summary.json; steps.csv and contacts.csv where asked
// for.
#pragma once

#include "app/csv_file.hpp"
#include "app/hdf5_file.hpp"
#include "core/channels.hpp"
#include "solvers/integrator.hpp"

#include <nlohmann/json.hpp>

#include <optional>

namespace gudgeon {

class ResultFiles {
  public:
    /// Makes the folder if needed, removes earlier results of these names and begins new ones. Throws
    /// FileError, as do the others.
    ResultFiles(const std::filesystem::path& folder, const Channels& channels, bool steps = false,
                bool contacts = false);

    const std::filesystem::path& folder() const { return folder_; }
    Hdf5File& hdf5() { return *hdf5_; }

    void append(double t, std::span<const double> values);
    /// One attempted step; nothing without steps.csv.
    void append(const StepRecord& step);
    /// One contact event; nothing without contacts.csv.
    void append(const ContactEvent& event, const System& system);
    /// Everything so far is on the disk and both trajectories can be read.
    void flush();
    void write_summary(const nlohmann::ordered_json& summary);

  private:
    std::filesystem::path folder_;
    std::optional<CsvFile> csv_, steps_, contacts_;
    std::optional<Hdf5File> hdf5_;
};

} // namespace gudgeon
