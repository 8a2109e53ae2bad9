// A simulation that is saved and loaded goes on to the last bit as the one that was never interrupted.
#include "core/archive.hpp"
#include "models/mechanisms.hpp"
#include "solvers/simulation.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

namespace gudgeon {
namespace {

struct Case {
    std::string mechanism;
    std::map<std::string, std::string> parameters;
    std::string integrator;
    double end;
    Formulation formulation = Formulation::saddle_point;
};

void PrintTo(const Case& c, std::ostream* out) {
    *out << c.mechanism << " by " << c.integrator << ", " << formulation_name(c.formulation);
}

SimulationOptions options_of(const Case& c) {
    SimulationOptions options;
    options.integrator = c.integrator;
    options.integration.rtol = options.integration.atol = 1e-6;
    options.integration.step = c.integrator == "rk4" ? 1e-5 : 0;
    options.integration.formulation = c.formulation;
    return options;
}

Simulation make(const Case& c) {
    return Simulation(build_mechanism(c.mechanism, c.parameters), options_of(c));
}

void add(std::string& bits, const void* data, std::size_t size) {
    bits.append(static_cast<const char*>(data), size);
}
void add(std::string& bits, double x) { add(bits, &x, sizeof x); }
void add(std::string& bits, const VecX& x) { add(bits, x.data(), sizeof(double) * x.size()); }

/// Everything that reaches the files: state, accelerations, energies, reactions, contacts, counts.
std::string bits_of(Simulation& sim, double t) {
    const Sample& s = sim.sample_at(t);
    std::string bits;
    for (const VecX* x : {&s.state.q, &s.state.u, &s.state.lambda, &s.state.z, &s.state.work, &s.acceleration,
                          &s.state.angles.value, &s.state.contacts.start_speed})
        add(bits, *x);
    add(bits, s.balance);
    for (const ContactHistory& h : s.state.history)
        for (const double x : {double(h.impacts), h.deepest, h.peak_force, h.touching})
            add(bits, x);
    for (const Wrench& w : s.joint) {
        add(bits, w.force.data(), sizeof(Vec3));
        add(bits, w.moment.data(), sizeof(Vec3));
    }
    const Statistics& n = sim.statistics();
    for (const long x : {n.steps, n.rejected_error, n.rejected_newton, n.rejected_contact, n.newton_sweeps,
                         n.evaluations, n.factorisations, n.refactorisations})
        add(bits, double(x));
    return bits;
}

/// Steps freely to the end, one sample inside every step.
std::vector<std::string> run(Simulation& sim, double end) {
    std::vector<std::string> samples;
    while (sim.time() < end) {
        const double from = sim.time();
        const StepOutcome outcome = sim.advance_past(std::nextafter(from, 2 * end), end);
        EXPECT_TRUE(outcome.ok) << outcome.message;
        if (!outcome.ok)
            break;
        samples.push_back(bits_of(sim, 0.5 * (from + sim.time())));
        samples.push_back(bits_of(sim, sim.time()));
    }
    return samples;
}

class Checkpoint : public testing::TestWithParam<Case> {};

TEST_P(Checkpoint, GoesOnToTheLastBit) {
    const Case& c = GetParam();
    Simulation straight = make(c);
    const std::vector<std::string> expected = run(straight, c.end);
    ASSERT_GT(expected.size(), 20u);
    const std::size_t steps = expected.size() / 2;

    // saved at many steps, without a trace in the run that is saved
    Simulation saved = make(c);
    std::vector<std::string> checkpoints;
    const std::size_t stride = std::max<std::size_t>(1, steps / 12);
    for (std::size_t k = 0; k < steps; ++k) {
        if (k % stride == stride / 2 || k == 0) {
            std::stringstream stream;
            saved.save(stream);
            checkpoints.push_back(stream.str());
        }
        ASSERT_TRUE(saved.advance_past(std::nextafter(saved.time(), 2 * c.end), c.end).ok);
        ASSERT_EQ(bits_of(saved, saved.time()), expected[2 * k + 1]) << "saving changed step " << k;
    }
    for (std::size_t i = 0; i < checkpoints.size(); ++i) {
        std::stringstream stream(checkpoints[i]);
        Simulation resumed = make(c);
        resumed.load(stream);
        const std::vector<std::string> rest = run(resumed, c.end);
        ASSERT_LE(rest.size(), expected.size());
        for (std::size_t k = 0; k < rest.size(); ++k)
            ASSERT_EQ(rest[k], expected[expected.size() - rest.size() + k])
                << "checkpoint " << i << ", sample " << k << " of " << rest.size();
    }
}

TEST(CheckpointIdentity, OfAnotherModelOrOtherOptionsIsRefused) {
    const Case given{"chain", {{"links", "3"}}, "gear", 1};
    Simulation saved = make(given);
    ASSERT_TRUE(saved.advance_to(0.1).ok);
    std::stringstream stream;
    saved.save(stream);
    const auto refused = [&](const Case& c, const SimulationOptions& options, const std::string& words) {
        Simulation other(build_mechanism(c.mechanism, c.parameters), options);
        std::stringstream copy(stream.str());
        try {
            other.load(copy);
            ADD_FAILURE() << "loaded, although: " << words;
        } catch (const ArchiveError& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
        }
    };
    refused({"pendulum", {}, "gear", 1}, options_of(given), "another model");
    refused({"chain", {{"links", "4"}}, "gear", 1}, options_of(given), "model was changed");
    SimulationOptions options = options_of(given);
    options.integration.rtol = 1e-5;
    refused(given, options, "other tolerances");
    options = options_of(given);
    options.integrator = "radau";
    refused(given, options, "another integrator");
    options = options_of(given);
    options.user_forces.push_back(
        {"none", {"ground", "link1"}, [](const UserForceInput&, UserForceOutput&) {}});
    refused(given, options, "other user forces");
}

const std::map<std::string, std::string> ball{{"joint", "spherical"}}, bearing{{"joint", "revolute"}},
    mixed{{"joints", "mixed"}}, two_loops{{"loops", "2"}};

INSTANTIATE_TEST_SUITE_P(
    Mechanisms, Checkpoint,
    testing::Values(Case{"slider-crank", {}, "gear", 0.5}, Case{"slider-crank", {}, "radau", 0.5},
                    Case{"slider-crank", {}, "auto", 0.5}, Case{"slider-crank", {}, "rk4", 0.01},
                    Case{"suspension-chain", {}, "gear", 0.2}, Case{"suspension-chain", {}, "radau", 0.2},
                    Case{"stick-slip", {}, "gear", 2}, Case{"stick-slip", {}, "radau", 2},
                    Case{"chain", {{"links", "6"}}, "auto", 1}, Case{"slider-crank", ball, "gear", 0.4},
                    Case{"slider-crank", bearing, "radau", 0.2}, Case{"slider-crank", ball, "rk4", 0.05},
                    Case{"suspension-chain", mixed, "auto", 0.2},
                    Case{"suspension-chain", mixed, "gear", 0.1}, Case{"four-bar", two_loops, "gear", 2.5},
                    Case{"four-bar", {}, "radau", 2.5}, Case{"four-bar", two_loops, "auto", 2.5},
                    Case{"four-bar", {}, "rk4", 0.01}, Case{"chain", {{"links", "4"}}, "erk", 1},
                    Case{"slider-crank", ball, "erk5", 0.05}, Case{"slider-crank", {}, "erk8", 0.5},
                    Case{"chain", {{"links", "4"}}, "gear", 1, Formulation::tree},
                    Case{"chain", {{"links", "4"}, {"joint", "spherical"}}, "radau", 1, Formulation::tree},
                    Case{"slider-crank", {}, "gear", 0.5, Formulation::tree},
                    Case{"slider-crank", {}, "radau", 0.5, Formulation::tree},
                    Case{"slider-crank", {}, "auto", 0.5, Formulation::tree},
                    Case{"slider-crank", ball, "gear", 0.4, Formulation::tree},
                    Case{"slider-crank", bearing, "radau", 0.2, Formulation::tree},
                    Case{"stick-slip", {}, "gear", 2, Formulation::tree},
                    Case{"stick-slip", {}, "radau", 2, Formulation::tree},
                    Case{"suspension-chain", mixed, "auto", 0.2, Formulation::tree}));

} // namespace
} // namespace gudgeon
