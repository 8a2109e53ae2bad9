// Runs of models with contacts.
#pragma once

#include "solvers/simulation.hpp"
#include "tests/solvers/impacts.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace gudgeon::hard_cases {

struct HardRun {
    Statistics statistics;
    std::vector<ContactEvent> starts, ends;
    double balance = 0; // J, the largest at a sample
    Sample last;
    std::vector<ContactHistory> history;
    long steps_since_start = 0; // of the last contact
};

struct HowToRun {
    std::string integrator = "radau";
    double tolerance = 1e-6;
    double end = 1, every = 0; // s; every 0: only the end
    Onset onset = Onset::threshold;
    int threads = 1;
    long max_steps = 100000;
    double largest_step = 0; // s; 0: none
};

inline HardRun simulate(Model model, const HowToRun& how,
                        const std::function<void(const Sample&)>& watch = {}) {
    HardRun out;
    SimulationOptions options;
    options.integrator = how.integrator;
    options.integration.rtol = options.integration.atol = how.tolerance;
    options.integration.onset = how.onset;
    options.integration.threads = how.threads;
    options.integration.max_steps = how.max_steps;
    options.integration.step = how.largest_step;
    options.on_contact = [&out](const ContactEvent& event) {
        if (event.kind == ContactEvent::Kind::start) {
            out.starts.push_back(event);
            out.steps_since_start = 0;
        } else if (event.kind == ContactEvent::Kind::end) {
            out.ends.push_back(event);
        }
    };
    Simulation sim(std::move(model), options);
    sim.integrator().on_step = [&out](const StepRecord& record) {
        out.steps_since_start += record.reason == StepReason::none;
    };
    const long samples = how.every > 0 ? std::lround(how.end / how.every) : 1;
    for (long k = 1; k <= samples; ++k) {
        const double t = k == samples ? how.end : static_cast<double>(k) * how.every;
        const StepOutcome outcome = sim.advance_past(t, how.end);
        EXPECT_TRUE(outcome.ok) << outcome.message;
        if (!outcome.ok)
            break;
        out.last = sim.sample_at(t);
        out.balance = std::max(out.balance, std::abs(out.last.balance));
        if (watch)
            watch(out.last);
    }
    out.statistics = sim.statistics();
    out.history = sim.state().history;
    return out;
}

/// A journal of 1 kg, radius 10 mm less the clearance, in a fixed bearing of 40 mm along X, 16 strips; no
/// weight. `turn` about Y.
inline Model journal(double radial, double turn, const Vec3& position, double stiffness = 1e8) {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("journal", 1, {1e-4, 1e-3, 1e-3}, position)};
    model.bodies[0].orientation = {std::cos(turn / 2), 0, std::sin(turn / 2), 0};
    Joint joint = make_joint("B", JointKind::cylindrical, "ground", "journal", Vec3::Zero());
    joint.body_frame = true;
    joint.points = {Vec3::Zero(), Vec3::Zero()};
    joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
    joint.fidelity = Fidelity::clearance;
    joint.clearance = strip_bearing(0.01, 0.04, radial, 16, lankarani_nikravesh(stiffness, 0.75));
    model.joints = {joint};
    return model;
}

} // namespace gudgeon::hard_cases
