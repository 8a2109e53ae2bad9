// Consistent start: assembly of positions and velocities.
#pragma once

#include "core/state.hpp"

#include <string>
#include <vector>

namespace gudgeon {

class ConsistentSolver;

struct AssemblyReport {
    bool ok = true;
    double position_before = 0, velocity_before = 0; // largest |Phi| and |G u + dPhi/dt| as given
    double position_after = 0, velocity_after = 0;

    /// How far each moving body was moved: m, rad, m/s, rad/s (zero where nothing had to move).
    struct Change {
        int body;
        double shift, turn, velocity, angular_velocity;
    };
    std::vector<Change> changes; // bodies that moved more than round-off

    /// Rows that stay open, worst first; filled when not ok.
    struct Open {
        int row;
        double by;
        bool velocity; // open in velocity, not in position
    };
    std::vector<Open> open;

    /// In words: "joint 'A' (displacement along x) by 0.012".
    std::string message(const System& system) const;
};

/// Moves q and u the least in the mass norm, keeping held coordinates, until positions and velocities
/// satisfy the constraints at state.t.
AssemblyReport assemble_start(const System& system, State& state);
/// The same with a solver of the system, as it was made, which is left as it was.
AssemblyReport assemble_start(const System& system, State& state, ConsistentSolver& solver);

} // namespace gudgeon
