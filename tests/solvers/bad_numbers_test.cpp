// Numbers that are none end a run with the element, the time and the state; steps that collapse name body,
// coordinate and contact.
#include "core/bad_numbers.hpp"
#include "models/mechanisms.hpp"
#include "solvers/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gudgeon {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void expect_words(const std::string& message, const std::vector<std::string>& words) {
    for (const std::string& word : words)
        EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' in: " << message;
}

SimulationOptions with_force(const std::string& integrator, const std::string& body, UserForceLaw law) {
    SimulationOptions options;
    options.integrator = integrator;
    options.user_forces.push_back({"wind", {"ground", body}, std::move(law)});
    return options;
}

class BadNumbers : public testing::TestWithParam<const char*> {};

TEST_P(BadNumbers, OfAForceAreNamedWithTimeAndState) {
    for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
        Simulation sim(build_mechanism("chain", {{"links", "3"}}),
                       with_force(GetParam(), "link2", [bad](const UserForceInput& in, UserForceOutput& out) {
                           out.wrench.force_b.x() = in.t > 0.3 ? bad : 0;
                       }));
        const StepOutcome outcome = sim.advance_to(1);
        ASSERT_FALSE(outcome.ok);
        expect_words(outcome.message, {"user force 'wind'", "'ground'", "body 'link2' at (", "t = 0.3"});
        EXPECT_LE(sim.time(), 0.3);
        EXPECT_GT(sim.time(), 0.25);
        EXPECT_TRUE(sim.state().q.allFinite() && sim.state().u.allFinite());
    }
}

TEST_P(BadNumbers, AtTheStartThereIsNoSimulation) {
    try {
        Simulation sim(build_mechanism("chain", {{"links", "3"}}),
                       with_force(GetParam(), "link1", [](const UserForceInput&, UserForceOutput& out) {
                           out.wrench.moment_b.y() = nan;
                       }));
        FAIL() << "started";
    } catch (const BadNumberError& error) {
        expect_words(error.what(), {"user force 'wind'", "'link1'", "t = 0 s", "velocity"});
    }
}

TEST_P(BadNumbers, OfEnergiesDoNotReachTheSamples) {
    Simulation sim(build_mechanism("chain", {{"links", "3"}}),
                   with_force(GetParam(), "link1", [](const UserForceInput& in, UserForceOutput& out) {
                       out.energies = EnergyRates{in.t > 0.2 ? nan : 0.0, 0, 0};
                   }));
    EXPECT_TRUE(sim.advance_to(0.1).ok);
    EXPECT_NO_THROW(sim.sample());
    ASSERT_TRUE(sim.advance_to(0.4).ok);
    try {
        sim.sample();
        FAIL() << "sampled";
    } catch (const BadNumberError& error) {
        expect_words(error.what(), {"user force 'wind'", "t = 0.4 s"});
    }
}

INSTANTIATE_TEST_SUITE_P(Integrators, BadNumbers, testing::Values("gear", "radau", "auto", "ida", "rk4"));

TEST(BadNumbers, ColumnsWithoutPivotAreNamed) {
    const System system = compile(build_mechanism("chain", {{"links", "2"}}), core_force_builders());
    expect_words(unknown_name(system, 7), {"body", "vy"});
    expect_words(unknown_name(system, system.velocities()), {"joint", "between 'ground'"});
}

// A force that jumps to 1e16 N once the journal is in contact: no step that time can resolve is short enough.
TEST(CollapsingSteps, NameBodyCoordinateAndContact) {
    for (const char* integrator : {"gear", "radau"}) {
        Simulation sim(build_mechanism("bouncing-journal"),
                       with_force(integrator, "journal", [](const UserForceInput& in, UserForceOutput& out) {
                           if (in.b.r.norm() > 1.00001e-3)
                               out.wrench.force_b.z() = 1e16;
                       }));
        const StepOutcome outcome = sim.advance_to(1);
        ASSERT_FALSE(outcome.ok) << integrator;
        EXPECT_LT(sim.time(), 0.1);
        expect_words(outcome.message, {"body 'journal' (", "z)", "contact of joint '", "strip"});
    }
}

} // namespace
} // namespace gudgeon
