// Static equilibrium: the pose in which a mechanism rests.
//
//   f(q, 0, t) - G^T lambda = 0,   Phi(q, t) = 0     at the time t of the state, drives at their place
//
// Damped Newton by pseudo-transient continuation (Kelley & Keyes 1998): with r the forces left over and
// S = -df/dq + d(G^T lambda)/dq each step solves [a M + S, G^T; G, 0] (dx, dlambda) = (r, -Phi), a falls as
// the search closes in. a M is a metric as well: a motion on which no force acts is not made at all, so
// directions without stiffness are moved least in the mass norm. The merit is the work of the forces along
// the step: a step after which they push back is shortened to where they do not (Illinois rule). Where
// this does not arrive, dynamic relaxation takes over: steps of the motion with time frozen, implicit
// Euler, velocities set to zero at every peak of the kinetic energy (Day 1965; Cundall 1976).
//
// A residual above the tolerance is accepted where Newton moves nothing any more and round-off of the
// coordinates times the largest stiffness explains it: small loads on stiff links.
//
// At rest nothing damps and nothing rubs: contacts push with the elastic part of their law, friction does
// not hold (bristles are undeflected). The equilibrium is the one without friction.
#pragma once

#include "core/assembly.hpp"
#include "solvers/initial.hpp"

#include <string>
#include <vector>

namespace gudgeon {

struct StaticsOptions {
    double tolerance = 1e-10; // largest force left over, of the largest force that acts
    int most_steps = 500;     // of Newton; as many again times 20 of relaxation
    bool relax_only = false;  // begin with dynamic relaxation
};

/// A motion without stiffness. Positions move by direction, six per moving body: m (global) and rad (body
/// frame), of unit length in the mass norm.
struct NeutralDirection {
    VecX direction;
    std::string words; // "everything moves along x", "body 'crank' turns about (1, 0, 0)"
};

struct StaticsReport {
    bool ok = false;
    std::string message; // why not: what accelerates, where
    int steps = 0, relaxation_steps = 0, factorisations = 0;
    double residual = 0;                        // largest force left over (N or N m) ...
    double force_scale = 0;                     // ... and the largest one that acts
    double constraint = 0;                      // largest |Phi|, m or rad
    double energy_before = 0, energy_after = 0; // J, potential and elastic
    std::vector<AssemblyReport::Change> moved;  // bodies that moved, m and rad
    std::vector<NeutralDirection> neutral;
    int unstable = 0; // directions in which the energy falls

    double relative_residual() const { return force_scale > 0 ? residual / force_scale : 0; }
    /// What to know of the equilibrium, a sentence each: neutral directions, instability.
    std::vector<std::string> notices() const;
};

/// Moves an assembled state into equilibrium: velocities zero (those of the drives remain), multipliers,
/// contacts with a memory so that a run from here rests. A contact that rests remembers as its starting
/// speed that of two free bodies that would bring the energy stored in it, sqrt(2 E B M^-1 B^T): laws with
/// hysteresis then push with their elastic part and damp vibrations about the rest according to their
/// restitution. Angles keep count of their turns. When not ok the state is where the search ended.
StaticsReport find_equilibrium(const System& system, State& state, const StaticsOptions& options = {});

/// The model that begins at this pose, at rest; its geometry stays that of the pose as given.
Model model_at(const System& system, const State& state);

/// What pushes at a state at rest: joints (force on b, moment at b's joint point, global), and the forces of
/// the model (on the last of their bodies that moves; moment about its mass centre, global).
struct RestForces {
    std::vector<Wrench> joint;         // System::joints
    std::vector<JointContact> contact; // System::contact_joints
    struct Named {
        std::string name, body;
        Wrench wrench;
    };
    std::vector<Named> forces;
};
RestForces rest_forces(const System& system, const State& state,
                       const std::vector<ForceBatchBuilder>& builders);

/// Directions without stiffness at a state at rest, and the number of those in which the energy falls.
std::vector<NeutralDirection> neutral_directions(const System& system, const State& state,
                                                 int* unstable = nullptr);

} // namespace gudgeon
