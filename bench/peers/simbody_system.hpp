// A model in Simbody: a tree of mobilizers, constraints for what closes loops, custom forces.
#pragma once

#include "core/model.hpp"

#include <Simbody.h>

#include <memory>
#include <string>
#include <vector>

namespace gudgeon::peers {

struct SimbodyOptions {
    bool euler_angles = false;   // of free bodies and balls, instead of quaternions
    bool library_forces = false; // bushings and springs of Simbody itself; its bushings have another law
    bool full_loops = false;     // five rows for the revolute joint of a planar loop too, instead of two
};

/// The system with its start. Built once, not copied: the subsystems refer to it.
struct SimbodySystem {
    SimTK::MultibodySystem system;
    SimTK::SimbodyMatterSubsystem matter{system};
    SimTK::GeneralForceSubsystem forces{system};
    std::vector<SimTK::MobilizedBody> bodies; // as in the model
    SimTK::State start;
};

/// Throws ModelError for what this program does not know, and for a start that violates the joints by more
/// than 1e-9 m, rad, m/s or rad/s.
std::unique_ptr<SimbodySystem> build_simbody(const Model& model, const SimbodyOptions& options);

/// A coordinate or velocity of a point, as a column of the results: "link4.x", "tip.vz".
struct Channel {
    std::string name;
    SimTK::MobilizedBody body;
    SimTK::Vec3 point{0};
    bool velocity = false;
    int axis = 0;

    double value(const SimTK::State& state) const; // m or m/s; the state realized as far as velocities
};

/// x y z vx vy vz of mass centres and markers that fit one of the patterns (`*`, `?`). Throws ModelError for
/// a pattern that fits none.
std::vector<Channel> choose_channels(const Model& model, const SimbodySystem& built,
                                     const std::vector<std::string>& patterns);

} // namespace gudgeon::peers
