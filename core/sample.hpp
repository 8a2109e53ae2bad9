// Everything known at one output instant; the channels read it.
#pragma once

#include "core/assembly.hpp"

namespace gudgeon {

/// A consistent state with its accelerations, reactions and energies.
struct Sample {
    State state;       // constraints closed
    VecX acceleration; // u', 6 per moving body
    /// Per joint: force of a on b and moment at b's joint point, both in global axes.
    std::vector<Wrench> joint;
    std::vector<JointContact> contacts; // of System::contact_joints
    std::vector<BodyMotion> motion;     // all bodies, the last is ground
    Energies energies;
    double balance = 0; // J, mechanical + dissipated - input - its value at the start
};

} // namespace gudgeon
