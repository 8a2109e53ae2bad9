// Equilibria against closed forms, and at rest for a second of motion afterwards.
#include "core/reader.hpp"
#include "core/writer.hpp"
#include "models/builders.hpp"
#include "solvers/consistent.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

struct Rest {
    System system;
    State state;
    StaticsReport report;
};

Rest rest_of(Model model, StaticsOptions options = {}) {
    Rest out{compiled(std::move(model)), {}, {}};
    out.state = initial_state(out.system);
    EXPECT_TRUE(assemble_start(out.system, out.state).ok);
    out.report = find_equilibrium(out.system, out.state, options);
    return out;
}

std::vector<std::string> motions(const StaticsReport& report) {
    std::vector<std::string> out;
    for (const NeutralDirection& n : report.neutral)
        out.push_back(n.words);
    return out;
}

/// Roads lie still.
Model on_flat_road(Model model) {
    for (Force& force : model.forces)
        if (auto* tyre = std::get_if<Tyre>(&force))
            tyre->road.reset();
    return model;
}

/// Largest kinetic energy and move of a coordinate in a second that begins at the equilibrium.
std::pair<double, double> second_of_rest(const Model& model, const std::string& integrator) {
    SimulationOptions options;
    options.integrator = integrator;
    options.start = Start::equilibrium;
    options.integration.rtol = options.integration.atol = 1e-8;
    Simulation sim(model, options);
    const VecX start = sim.sample().state.q;
    double kinetic = 0, moved = 0;
    for (int k = 1; k <= 20; ++k) {
        const StepOutcome outcome = sim.advance_to(0.05 * k);
        EXPECT_TRUE(outcome.ok) << outcome.message;
        const Sample& sample = sim.sample();
        kinetic = std::max(kinetic, sample.energies.kinetic);
        moved = std::max(moved, (sample.state.q - start).cwiseAbs().maxCoeff());
    }
    return {kinetic, moved};
}

TEST(Statics, MassOnABushingSagsByItsWeightOverTheStiffness) {
    const Rest at = rest_of(test::block_on_rubber(300, 0.3));
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_NEAR(at.state.q[2], -3 * 9.81 / 6e4, 1e-15);
    EXPECT_LT(at.report.relative_residual(), 1e-12);
    EXPECT_TRUE(at.report.neutral.empty());
    EXPECT_EQ(at.report.unstable, 0);
    EXPECT_NEAR(at.report.energy_after, -0.5 * 3 * 9.81 * 3 * 9.81 / 6e4, 1e-12);
    const RestForces forces = rest_forces(at.system, at.state, standard_force_builders());
    EXPECT_NEAR(forces.joint[0].force.z(), 3 * 9.81, 1e-10); // the ground carries the block
}

TEST(Statics, PendulumFallsToItsLowestPlace) {
    for (const bool relax : {false, true}) {
        StaticsOptions options;
        options.relax_only = relax;
        const Rest at = rest_of(build_mechanism("pendulum", {}), options);
        ASSERT_TRUE(at.report.ok) << at.report.message;
        EXPECT_NEAR(at.state.q[0], 0, 1e-9);
        EXPECT_NEAR(at.state.q[2], -1, 1e-12);
        EXPECT_EQ(at.report.relaxation_steps > 0, relax);
        EXPECT_EQ(at.report.unstable, 0);
    }
}

TEST(Statics, InvertedPendulumIsAnUnstableEquilibrium) {
    Model model;
    model.bodies = {make_body("rod", 2, {0.1, 0.1, 0.1}, {0, 0, 0.5})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "rod", {0, 0, 0}, Vec3::UnitY())};
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok);
    EXPECT_EQ(at.report.unstable, 1);
    EXPECT_EQ(at.report.steps, 0);
    const RestForces forces = rest_forces(at.system, at.state, standard_force_builders());
    EXPECT_NEAR(forces.joint[0].force.z(), 2 * 9.81, 1e-12);
}

TEST(Statics, HeavyBallSinksIntoItsSocketAsHertzSaysAndStaysThere) {
    ContactLaw law;
    law.stiffness = 5e7;
    for (const char* kind : {"hertz", "lankarani-nikravesh", "hunt-crossley", "flores"}) {
        law.kind = kind;
        if (law.kind != "hertz")
            law.restitution = 0.6;
        const Rest at = rest_of(test::ball_in_socket(law));
        ASSERT_TRUE(at.report.ok) << kind << ' ' << at.report.message;
        EXPECT_NEAR(at.state.q[2], -1e-3 - std::pow(2 * 9.81 / 5e7, 2.0 / 3), 1e-13) << kind;
        EXPECT_EQ(motions(at.report).size(), 3u) << "the ball turns freely";
        // 1/2 m v^2 = 2/5 m g d: the speed whose energy is the one stored
        const double depth = -at.state.q[2] - 1e-3;
        EXPECT_NEAR(at.state.contacts.start_speed[0], std::sqrt(0.8 * 9.81 * depth), 1e-9) << kind;
        const auto [kinetic, moved] = second_of_rest(test::ball_in_socket(law), "radau");
        EXPECT_LT(kinetic, 1e-18) << kind;
        EXPECT_LT(moved, 1e-10) << kind;
    }
}

TEST(Statics, TyreSinksUnderTheLoadAndLeavesTheOtherMotionsFree) {
    Model model;
    model.bodies = {make_body("wheel", 20, {0.5, 0.6, 0.7}, {1, 2, 0.3})};
    Tyre tyre;
    tyre.name = "tyre";
    tyre.body = "wheel";
    tyre.point = {1, 2, 0.3};
    tyre.stiffness = 2e5;
    tyre.damping = 300;
    tyre.road = HarmonicFunction{0.02, 2, 0, 0}; // moves at t = 0, but statics takes it at rest there
    model.forces = {tyre};
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_NEAR(at.state.q[2], 0.3 - 20 * 9.81 / 2e5, 1e-13);
    EXPECT_NEAR(at.state.q[0], 1, 1e-12);
    EXPECT_NEAR(at.state.q[1], 2, 1e-12);
    EXPECT_EQ(at.report.neutral.size(), 5u);
    const RestForces forces = rest_forces(at.system, at.state, standard_force_builders());
    ASSERT_EQ(forces.forces.size(), 1u);
    EXPECT_NEAR(forces.forces[0].wrench.force.z(), 20 * 9.81, 1e-9);
}

TEST(Statics, ChainHangsStraightFromAnyPose) {
    const Rest at = rest_of(build_mechanism("chain", {{"links", "10"}}));
    ASSERT_TRUE(at.report.ok) << at.report.message;
    for (int i = 0; i < 10; ++i) {
        EXPECT_NEAR(at.state.q[7 * i], 0, 1e-8);
        EXPECT_NEAR(at.state.q[7 * i + 2], -(i + 0.5), 1e-10);
    }
    // reactions: the weight below each joint
    const RestForces forces = rest_forces(at.system, at.state, standard_force_builders());
    for (int i = 0; i < 10; ++i)
        EXPECT_NEAR(forces.joint[i].force.z(), (10 - i) * 9.81, 1e-8);
}

TEST(Statics, VehicleCornerRests) {
    const Model model = on_flat_road(build_mechanism("hmmwv-corner", {}));
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_LT(at.report.relative_residual(), 1e-9);
    EXPECT_EQ(motions(at.report), std::vector<std::string>{"body 'spindle' turns about its own y"});
    for (const char* integrator : {"radau", "gear"}) {
        const auto [kinetic, moved] = second_of_rest(model, integrator);
        EXPECT_LT(kinetic, 1e-12) << integrator;
        EXPECT_LT(moved, 1e-8) << integrator;
    }
}

class StaticsOfSuspensions : public testing::TestWithParam<const char*> {};

TEST_P(StaticsOfSuspensions, RestWithThreeNeutralDirections) {
    const Model model = on_flat_road(
        build_mechanism("suspension-chain", {{"joints", GetParam()}, {"units", "10"}, {"strips", "8"}}));
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_LT(at.report.relative_residual(), 1e-9);
    EXPECT_EQ(motions(at.report),
              (std::vector<std::string>{"everything moves along x", "everything moves along y",
                                        "everything turns about z"}));
    EXPECT_EQ(at.report.unstable, 0);
    EXPECT_LT(at.report.energy_after, at.report.energy_before);
    // moved least: nothing along the neutral directions
    VecX moved(at.system.velocities());
    const State before = initial_state(at.system);
    double size = 0;
    for (int i = 0; i < at.system.moving; ++i) {
        moved.segment<3>(6 * i) = at.state.q.segment<3>(7 * i) - before.q.segment<3>(7 * i);
        const Vec4 p = before.q.segment<4>(7 * i + 3), to = at.state.q.segment<4>(7 * i + 3);
        moved.segment<3>(6 * i + 3) = 2 * l_times(p, to);
        size = std::max(size, moved.segment<3>(6 * i).norm());
    }
    VecX weighted = moved;
    mass_times(at.system, moved, weighted);
    for (const NeutralDirection& n : at.report.neutral)
        EXPECT_LT(std::abs(n.direction.dot(weighted)), 1e-2 * std::sqrt(moved.dot(weighted))) << n.words;
    EXPECT_LT(size, 0.05);
    // energy: least among poses nearby on the constraints
    Workspace ws = make_workspace(at.system);
    ws.angles = at.state.angles;
    ws.contacts = at.state.contacts;
    std::mt19937 rng(5);
    ConsistentSolver solver(at.system);
    for (int k = 0; k < 10; ++k) {
        VecX q = at.state.q;
        VecX step = VecX::NullaryExpr(
            at.system.velocities(), [&] { return std::uniform_real_distribution<double>(-1e-4, 1e-4)(rng); });
        move(at.system, step, q);
        const VecX none = VecX::Zero(at.system.velocities());
        ASSERT_TRUE(solver.project_positions(0, q, none, ws));
        set_motion(at.system, q, none, ws);
        EXPECT_GT(energies(at.system, 0, nullptr, ws).mechanical(), at.report.energy_after);
    }
}

TEST_P(StaticsOfSuspensions, StayPutForASecond) {
    const Model model = on_flat_road(
        build_mechanism("suspension-chain", {{"joints", GetParam()}, {"units", "2"}, {"strips", "8"}}));
    for (const char* integrator : {"radau", "gear"}) {
        const auto [kinetic, moved] = second_of_rest(model, integrator);
        EXPECT_LT(kinetic, 1e-9) << integrator; // J, of 1.2 t
        EXPECT_LT(moved, 1e-6) << integrator;
    }
}

INSTANTIATE_TEST_SUITE_P(All, StaticsOfSuspensions, testing::Values("bushing", "clearance", "perfect"),
                         [](const auto& info) { return std::string(info.param); });

TEST(Statics, FreeFallIsRefusedByName) {
    Model model = test::block_on_rubber(300, 0.3);
    model.bodies.push_back(make_body("loose", 1, {1, 1, 1}, {5, 0, 0}));
    SimulationOptions options;
    options.start = Start::equilibrium;
    try {
        Simulation sim(model, options);
        FAIL() << "accepted";
    } catch (const EquilibriumError& error) {
        EXPECT_NE(std::string(error.what()).find("'loose' (9.81 m/s2"), std::string::npos) << error.what();
        EXPECT_EQ(std::string(error.what()).find("block"), std::string::npos) << error.what();
    }
}

TEST(Statics, ForceFreeCrankIsFreeToTurn) {
    Model model;
    model.gravity.setZero();
    model.bodies = {make_body("crank", 1, {0.1, 0.1, 0.1}, {0, 0, 0.3})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "crank", {0, 0, 0}, Vec3::UnitY())};
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok);
    ASSERT_EQ(at.report.neutral.size(), 1u);
    EXPECT_EQ(at.report.moved.size(), 0u);
}

// A torsion spring wound up by two turns: the angle keeps count, also through a file.
TEST(Statics, AnglesKeepTheirTurns) {
    Model model;
    model.gravity.setZero();
    model.bodies = {make_body("wheel", 1, {0.1, 0.1, 0.1}, {0, 0, 0})};
    model.joints = {make_joint("axle", JointKind::revolute, "ground", "wheel", {0, 0, 0}, Vec3::UnitY())};
    TorsionSpring spring;
    spring.name = "spring";
    spring.joint = "axle";
    spring.stiffness = 2;
    spring.free_angle = 4 * pi + 0.5;
    model.forces = {spring};
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_NEAR(at.state.angles.value[0], 4 * pi + 0.5, 1e-10);

    const Model again = parse_model(write_model(model_at(at.system, at.state)), "again.json");
    const Rest second = rest_of(again);
    EXPECT_EQ(second.report.steps, 0);
    EXPECT_NEAR(second.state.angles.value[0], 4 * pi + 0.5, 1e-10);
}

TEST(Statics, FileOfTheEquilibriumIsInEquilibrium) {
    const Rest at = rest_of(build_mechanism("suspension-chain", {{"units", "2"}}));
    ASSERT_TRUE(at.report.ok);
    const Rest again = rest_of(parse_model(write_model(model_at(at.system, at.state)), "again.json"));
    EXPECT_EQ(again.report.steps, 0);
    EXPECT_LT((again.state.q - at.state.q).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(Statics, DrivenMechanismIsTakenAtTheStartOfItsDrives) {
    Model model;
    model.bodies = {make_body("arm", 1, {0.1, 0.1, 0.1}, {0.5, 0, 0})};
    Joint hinge = make_joint("hinge", JointKind::revolute, "ground", "arm", {0, 0, 0}, Vec3::UnitY());
    hinge.drives["angle"] = RampFunction{0.3, 2, 0};
    model.joints = {hinge};
    const Rest at = rest_of(model);
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_NEAR(at.state.angles.value[0], 0.3, 1e-12);
    // the drive carries the arm against gravity: moment m g cos(0.3) / 2 about the hinge, turning down is +y
    const RestForces forces = rest_forces(at.system, at.state, standard_force_builders());
    EXPECT_NEAR(forces.joint[0].moment.y(), -0.5 * 9.81 * std::cos(0.3), 1e-9);
}

// A planar four-bar drawn in 3D has three rows too many in its loop.
TEST(Statics, RedundantConstraintsDoNotMatter) {
    const Rest at = rest_of([] {
        Model model = build_mechanism("four-bar", {});
        Body& body = model.bodies.front();
        body.position.x() += 0.05; // off the top; assembly closes the loop again
        return model;
    }());
    ASSERT_TRUE(at.report.ok) << at.report.message;
    EXPECT_EQ(at.report.unstable, 0);
    EXPECT_NEAR(at.report.energy_after, -at.report.energy_before, 0.1); // hangs as low as it stood high
}

} // namespace
} // namespace gudgeon
