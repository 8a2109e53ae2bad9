// What a run was and how it went: read by summary.json and by the report on the terminal.
#pragma once

#include "app/load_model.hpp"
#include "app/output_grid.hpp"
#include "solvers/simulation.hpp"

#include <filesystem>

namespace gudgeon {

struct RunRecord {
    enum class Status { ok, failed, interrupted } status = Status::ok;
    std::string reason; // empty when ok
    double reached = 0; // s, end of the last accepted step
    std::size_t samples = 0, columns = 0;
    double balance_max = 0; // J, over the samples
    double setup_seconds = 0, cpu_seconds = 0, wall_seconds = 0;
    double write_seconds = 0;     // wall clock, of the files
    PhaseTimes setup_phases;      // wall clock spent before the first step, part of the statistics
    std::vector<double> restarts; // s, where the integrator started anew from a checkpoint
    std::string space;            // notice that the disk may be too small; empty: none
    void visit(Archive& archive);
};

const char* status_name(RunRecord::Status status);

nlohmann::ordered_json summary(const RunArguments& arguments, const SimulationOptions& used,
                               const LoadedModel& loaded, const Simulation& sim, const OutputGrid& grid,
                               const RunRecord& record);

/// The report of a search for equilibrium, as summary.json and statics.json have it.
nlohmann::ordered_json statics_json(const System& system, const StaticsReport& report);

/// Lines for the terminal.
std::string assembly_report(const System& system, const AssemblyReport& report);
std::string equilibrium_report(const System& system, const StaticsReport& report);
std::string notice_report(const std::vector<std::string>& notices);
std::string run_report(const LoadedModel& loaded, const Simulation& sim, const RunRecord& record,
                       const std::filesystem::path& folder);

} // namespace gudgeon
