// State of a mechanism and the scratch arrays of an evaluation.
#pragma once

#include "core/contact.hpp"
#include "core/system.hpp"

namespace gudgeon {

/// Unwrapped angles at the last accepted step; they choose the branch of every angle measure.
struct AngleMemory {
    VecX value, rate; // one per System::angles
    double t = 0;
};

/// Everything that has to be saved to go on later.
struct State {
    double t = 0;
    VecX q;      // 7 per moving body: position, Euler parameters
    VecX u;      // 6 per moving body: velocity (global), angular velocity (body frame)
    VecX lambda; // one per constraint row
    AngleMemory angles;
    VecX z; // friction states (m), System::friction_states
    ContactMemory contacts;
    std::vector<ContactHistory> history; // one per System::contact_joints
    /// J since the start: dissipated in all, input, dissipated in each of System::contact_joints.
    VecX work;

    double dissipated() const { return work[0]; }
    double input() const { return work[1]; }
};

/// Scratch of one evaluation; one per thread of use. All sizes are fixed by make_workspace(), but those of
/// the derivatives, which the first linearise() and evaluate_rate_rows() make: few need them.
struct Workspace {
    std::vector<BodyMotion> motion; // all bodies
    VecX f;                         // generalised forces, 6 per moving body
    VecX external;                  // loads set from outside, 6 per moving body: force and moment, global
    VecX phi, rate;                 // constraint residuals and G u + dPhi/dt
    std::vector<double> rows;       // G, 12 per row
    std::vector<double> rate_rows;  // d(G u)/dq, 12 per row, along velocities
    Linearisation lin;
    AngleMemory angles;
    VecX z;      // friction states of the evaluation
    VecX lambda; // multipliers of the evaluation, read by friction in perfect joints
    ContactMemory contacts;
    std::vector<double> scratch;        // of the batches, System::scratch
    std::vector<ContactSample> samples; // one per channel, filled by sample_contacts()
    /// Of the first channel of an element: its samples are blank, no channel of it being near; else 0.
    std::vector<unsigned char> apart;
    int threads = 1;
    bool frozen = false; // time stands still: what moves by itself (roads) is at its place, at rest

    /// f(element, its first channel, the one after its last) of System::contact_elements that are not apart.
    template <class F> void for_near(const System& system, F&& f) const {
        for (std::size_t k = 0; k + 1 < system.contact_elements.size(); ++k)
            if (const int first = system.contact_elements[k]; !apart[first])
                f(k, first, system.contact_elements[k + 1]);
    }

    /// What a state holds beside time and motion.
    void remember(const State& state) {
        angles = state.angles;
        contacts = state.contacts;
        z = state.z;
        lambda = state.lambda;
    }
};

/// A power per entry of State::work.
Eigen::Index work_count(const System& system);

State initial_state(const System& system);
Workspace make_workspace(const System& system, int threads = 1);

} // namespace gudgeon
