// A run with its files: begun, gone on with from a checkpoint, saved in one.
#pragma once

#include "app/load_model.hpp"
#include "app/output_grid.hpp"
#include "app/result_files.hpp"
#include "app/run_record.hpp"

#include <memory>
#include <optional>

namespace gudgeon {

class Session {
    std::vector<ContactEvent> at_start_; // before there are files

  public:
    /// Compiles and assembles. Throws what load_model() and Simulation throw, and UsageError.
    Session(const RunArguments& arguments, LoadedModel model);
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// The session of a checkpoint as it was when that was taken, its files cut to their length then. Throws
    /// FileError, also for a checkpoint that is truncated, damaged or of another version.
    static std::unique_ptr<Session> from_checkpoint(const std::filesystem::path& folder);

    /// The model's file is not what it was when the run began (or not there any more).
    bool model_file_differs() const;

    /// Begins new files, after a look at the space there is for them. Throws FileError.
    void begin_files();

    /// The files so far are brought to the disk, then the checkpoint. Throws FileError.
    void save_checkpoint();
    /// Where the arguments ask for checkpoints: saves one if it is time for it.
    void save_when_due();

    const RunArguments arguments;
    LoadedModel loaded; // its model became the simulation's: name and source stay
    const OutputGrid grid;
    std::optional<ResultFiles> files; // before sim, whose start already tells of contacts
    const SimulationOptions options;
    Simulation sim;
    const Channels channels;
    RunRecord record;
    std::size_t next = 0; // output time to be written
    /// Adds the time since the last call to the record.
    void count_time();
    void start_clock();

  private:
    SimulationOptions simulation_options();
    void connect_files();
    void visit(Archive& archive);

    FilePositions positions_;
    double checkpoint_at_ = 0; // s
    double cpu_ = 0, wall_ = 0;
};

} // namespace gudgeon
