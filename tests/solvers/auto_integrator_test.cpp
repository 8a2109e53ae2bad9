// The automatic choice: what the start suggests, what the run shows, and one history of work.
#include "models/mechanisms.hpp"
#include "solvers/auto_integrator.hpp"
#include "solvers/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace gudgeon {
namespace {

Simulation automatic(const std::string& mechanism, double tol,
                     const std::map<std::string, std::string>& parameters = {}) {
    SimulationOptions options;
    options.integrator = "auto";
    options.integration.rtol = options.integration.atol = tol;
    return Simulation(build_mechanism(mechanism, parameters), options);
}

TEST(AutoIntegrator, NamesTheStiffestLightlyDampedBody) {
    Simulation sim = automatic("suspension-chain", 1e-4);
    const auto uses = sim.integrator_uses();
    ASSERT_EQ(uses.size(), 1u);
    EXPECT_EQ(uses[0].name, "radau");
    EXPECT_NE(uses[0].why.find("rad/s"), std::string::npos);
    EXPECT_NE(uses[0].why.find("0"), std::string::npos); // a body of unit 0
}

TEST(AutoIntegrator, FollowsThePendulum) {
    Simulation sim = automatic("pendulum", 1e-7);
    ASSERT_TRUE(sim.advance_to(10).ok);
    const Vec3 bob = sim.sample().motion[0].r;
    EXPECT_NEAR(bob.x(), -0.2750874626, 1e-5);
    EXPECT_NEAR(bob.z(), -0.9614192051, 1e-5);
    EXPECT_GT(sim.statistics().steps, 100);
    EXPECT_STREQ(sim.integrator_name(), "auto");
}

// Forces of stiff bushings, rounded, move a stage by more than sweeps at this tolerance ask for.
TEST(AutoIntegrator, ToleranceNearRoundOffDoesNotCrawl) {
    Simulation corner = automatic("hmmwv-corner", 1e-10);
    ASSERT_TRUE(corner.advance_to(1).ok);
    EXPECT_LT(corner.statistics().steps, 10000);
    Simulation chain = automatic("suspension-chain", 1e-9, {{"units", "4"}});
    ASSERT_TRUE(chain.advance_to(2.5).ok);
    EXPECT_LT(chain.statistics().steps, 10000);
}

TEST(AutoIntegrator, KeepsLoadsFromOutside) {
    Simulation sim = automatic("pendulum", 1e-8);
    sim.set_load("bob", {0, 0, 9.81}, Vec3::Zero()); // weightless: it stays where it is
    ASSERT_TRUE(sim.advance_to(1).ok);
    EXPECT_NEAR(sim.sample().motion[0].r.x(), -1, 1e-9);
}

Simulation left_to_the_program(const std::string& mechanism, std::vector<UserForce> forces = {}) {
    SimulationOptions options;
    options.integrator = "auto";
    options.integration.rtol = options.integration.atol = 1e-8;
    options.integration.formulation = Formulation::automatic;
    options.user_forces = std::move(forces);
    return Simulation(build_mechanism(mechanism), options);
}

TEST(AutoIntegrator, OpenTreesWithoutStiffForcesAreExplicitInJointCoordinates) {
    for (const char* name : {"chain", "heavy-top"}) {
        Simulation sim = left_to_the_program(name);
        EXPECT_EQ(sim.integrator_uses().at(0).name, "erk") << name;
        EXPECT_STREQ(sim.formulation(), "tree") << name;
        EXPECT_NE(sim.integrator_uses()[0].why.find("open tree"), std::string::npos);
        ASSERT_TRUE(sim.advance_to(0.5).ok);
    }
    EXPECT_EQ(automatic("chain", 1e-8).integrator_uses().at(0).name, "radau") << "a formulation was named";
    for (const char* name : {"four-bar", "suspension-chain", "stick-slip", "bouncing-journal", "pendulum"})
        EXPECT_EQ(left_to_the_program(name).integrator_uses().at(0).name, "radau") << name;
}

TEST(AutoIntegrator, StiffnessOnTheWayEndsTheExplicitMethod) {
    UserForce rubber;
    rubber.name = "rubber";
    rubber.bodies = {"ground", "link1"};
    rubber.law = [](const UserForceInput& in, UserForceOutput& out) {
        if (in.t > 0.1) {
            out.wrench.moment_b = -1e3 * in.b.w;
            out.wrench.force_b = -1e5 * in.b.v;
        }
    };
    Simulation sim = left_to_the_program("chain", {rubber});
    ASSERT_TRUE(sim.advance_to(1).ok);
    const auto uses = sim.integrator_uses();
    ASSERT_GE(uses.size(), 2u);
    EXPECT_EQ(uses[0].name, "erk");
    EXPECT_EQ(uses[1].name, "radau");
    EXPECT_GT(uses[1].from, 0.1);
    EXPECT_LT(sim.statistics().steps, 3000);
    std::stringstream stream; // both methods are saved
    sim.save(stream);
    Simulation again = left_to_the_program("chain", {rubber});
    again.load(stream);
    EXPECT_EQ(again.state().q, sim.state().q);
    EXPECT_EQ(again.statistics().steps, sim.statistics().steps);
}

TEST(Statistics, AddUp) {
    Statistics a, b;
    a.steps = 3;
    b.steps = 4;
    a.order_histogram[5] = 3;
    b.order_histogram[2] = 4;
    a.constraint_position_max = 1e-12;
    b.constraint_position_max = 3e-12;
    b.seconds.solve = 0.5;
    a += b;
    EXPECT_EQ(a.steps, 7);
    EXPECT_EQ(a.order_histogram[5], 3);
    EXPECT_EQ(a.order_histogram[2], 4);
    EXPECT_EQ(a.constraint_position_max, 3e-12);
    EXPECT_EQ(a.seconds.solve, 0.5);
}

} // namespace
} // namespace gudgeon
