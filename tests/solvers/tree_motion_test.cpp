// Joint coordinates against the coordinates of the bodies: the same accelerations, reactions and motions.
#include "solvers/motion_equations.hpp"

#include "solvers/initial.hpp"
#include "solvers/simulation.hpp"
#include "tests/core/tree_tools.hpp"
#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_table.hpp"

#include <sstream>

namespace gudgeon {
namespace {

using namespace test;

struct Case {
    std::string name;
    std::map<std::string, std::string> parameters;
    double step, end;
    double apart = 2e-11; // m, between the formulations at the end of a run
};

void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
    for (const auto& [key, value] : c.parameters)
        *out << ' ' << key << '=' << value;
}

std::vector<Case> cases() {
    return {
        {"pendulum", {}, 1e-3, 1},
        {"chain", {{"links", "4"}, {"thin", "1"}}, 1e-3, 1, 1e-9},
        {"chain", {{"links", "16"}}, 5e-4, 0.5},
        {"chain", {{"links", "6"}, {"joint", "spherical"}}, 5e-4, 0.5},
        {"chain", {{"links", "6"}, {"joint", "universal"}}, 5e-4, 0.5},
        {"heavy-top", {}, 5e-4, 1, 2e-8},
        {"four-bar", {}, 1e-3, 0.3},
        {"four-bar", {{"loops", "5"}}, 5e-4, 0.2},
        {"slider-crank", {}, 5e-4, 0.5, 2e-9},
        {"slider-crank", {{"joint", "spherical"}}, 1e-5, 0.01},
        {"slider-crank", {{"joint", "revolute"}}, 1e-5, 0.01},
        {"triple-pendulum", {}, 1e-5, 0.02},
        {"triple-pendulum", {{"stops", "0"}}, 5e-4, 0.5},
        {"stick-slip", {}, 1e-5, 0.02},
        {"hmmwv-corner", {}, 1e-5, 0.005},
        {"hmmwv-corner", {{"joints", "perfect"}}, 1e-4, 0.02},
        {"suspension-chain", {{"units", "2"}, {"joints", "perfect"}}, 1e-4, 0.02},
        {"suspension-chain", {{"units", "2"}, {"joints", "bushing"}}, 1e-5, 0.002},
        {"suspension-chain", {{"units", "1"}, {"joints", "clearance"}}, 5e-6, 0.001},
        {"suspension-chain", {{"units", "1"}, {"joints", "mixed"}}, 5e-6, 0.001},
        {"suspension-chain", {{"antiroll", "1"}, {"joints", "perfect"}}, 1e-5, 0.002},
        {"rsup", {}, 2e-6, 0.001},
        {"rsup", {{"coupler", "flexible"}, {"joint", "spatial"}, {"friction", "1"}}, 1e-6, 2e-4},
        {"bouncing-journal", {}, 1e-5, 0.02},
        {"tilted-journal", {}, 1e-5, 0.01},
    };
}

System system_of(const Case& c) { return compiled(c.name, c.parameters); }

State assembled(const System& system) {
    State state = initial_state(system);
    EXPECT_TRUE(assemble_start(system, state).ok);
    return state;
}

IntegratorOptions options(Formulation formulation, double step = 0) {
    IntegratorOptions out;
    out.formulation = formulation;
    out.step = step;
    return out;
}

TEST(TreeMotionCases, HaveEveryReadyMechanism) {
    const std::vector<Case> all = cases();
    for (const Mechanism& m : mechanisms())
        EXPECT_TRUE(std::ranges::any_of(all, [&](const Case& c) { return c.name == m.name; })) << m.name;
}

class TreeMotionOf : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(ReadyMechanisms, TreeMotionOf, testing::ValuesIn(cases()));

// At the assembled start, with random speeds of the joints that keep the loops closed.
TEST_P(TreeMotionOf, AccelerationsAndReactionsAgree) {
    const System system = system_of(GetParam());
    State state = assembled(system);
    const auto tree = make_motion_equations(system, options(Formulation::tree)),
               cartesian = make_motion_equations(system, options(Formulation::saddle_point));
    VecX x, w, q, u, found(system.velocities()), truth(system.velocities());
    Workspace ws = make_workspace(system), ws2 = ws;
    ws.remember(state);
    ws2.remember(state);
    tree->load(state, x, w);
    std::mt19937 rng(3);
    for (double& speed : w)
        speed += 2 * random_vector(rng)[0];
    ASSERT_TRUE(tree->close(0, x, w, ws));
    tree->store(x, w, state);
    cartesian->load(state, q, u);
    MotionRates a = tree->make_rates(), b = cartesian->make_rates();
    ASSERT_TRUE(tree->rates(0, x, w, state.z, nullptr, ws, a).ok());
    ASSERT_TRUE(cartesian->rates(0, q, u, state.z, nullptr, ws2, b).ok());
    tree->body_accelerations(ws, a.speeds, found);
    cartesian->body_accelerations(ws2, b.speeds, truth);
    EXPECT_LT((found - truth).norm(), 1e-9 * truth.norm());
    EXPECT_LT((a.powers - b.powers).norm(), 1e-9 * (1 + b.powers.norm()));
    EXPECT_LT((a.states - b.states).norm(), 1e-9 * (1 + b.states.norm()));
    if (tree->can_drift()) {
        EXPECT_LT((a.lambda - b.lambda).norm(), 1e-6 * (1 + b.lambda.norm()));
    }
}

// Off the closed position and back: tree joints hold all the way, the rest closes to round-off.
TEST_P(TreeMotionOf, ClosesItsLoops) {
    const System system = system_of(GetParam());
    State state = assembled(system);
    const auto tree = make_motion_equations(system, options(Formulation::tree));
    VecX x, w;
    tree->load(state, x, w);
    std::mt19937 rng(4);
    for (VecX* v : {&x, &w})
        for (double& value : *v)
            value += 1e-3 * random_vector(rng)[0];
    Workspace ws = make_workspace(system);
    ASSERT_TRUE(tree->close(0, x, w, ws));
    tree->store(x, w, state);
    set_motion(system, state.q, state.u, ws);
    evaluate_constraints(system, 0, nullptr, false, ws);
    EXPECT_LT(ws.phi.norm(), 1e-12);
    EXPECT_LT(ws.rate.norm(), 1e-12 * (1 + state.u.cwiseAbs().maxCoeff()));
}

TEST_P(TreeMotionOf, RunsAgree) {
    const Case& c = GetParam();
    std::vector<Sample> ends;
    for (const Formulation f : {Formulation::saddle_point, Formulation::tree}) {
        SimulationOptions o;
        o.integrator = "rk4";
        o.integration = options(f, c.step);
        Simulation sim(build_mechanism(c.name, c.parameters), o);
        EXPECT_STREQ(sim.formulation(), formulation_name(f));
        const StepOutcome outcome = sim.advance_to(c.end);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        ends.push_back(sim.sample());
    }
    EXPECT_LT((ends[0].state.q - ends[1].state.q).cwiseAbs().maxCoeff(), c.apart);
    EXPECT_LT((ends[0].state.work - ends[1].state.work).norm(), 1e-8 * (1 + ends[0].state.work.norm()));
    for (std::size_t j = 0; j < ends[0].joint.size(); ++j)
        EXPECT_LT((ends[0].joint[j].force - ends[1].joint[j].force).norm(),
                  1e-7 * (1 + ends[0].joint[j].force.norm()));
}

TEST(TreeMotion, Rk4HasOrderFour) {
    const System system = compiled("chain", {{"links", "4"}, {"thin", "1"}});
    const testing_data::ReferenceTable reference("r5_chain_N4.csv");
    std::vector<double> errors;
    for (const double h : {4e-3, 2e-3, 1e-3}) {
        auto rk4 = make_integrator("rk4", system, options(Formulation::tree, h));
        rk4->start(initial_state(system));
        ASSERT_TRUE(integrator_tools::run(*rk4, 1).ok);
        const State& s = rk4->state();
        const Vec3 tip = s.q.segment<3>(21) + rotation(s.q.segment<4>(24)) * Vec3(0.5, 0, 0);
        errors.push_back(std::hypot(tip.x() - reference["tip_x"][100], tip.z() - reference["tip_z"][100]));
    }
    EXPECT_LT(errors[0], 1e-6);
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), 4, 0.5);
    EXPECT_NEAR(std::log2(errors[1] / errors[2]), 4, 0.5);
}

// A random tree of all kinds, free bodies among them, swings without loss.
TEST(TreeMotion, EnergyIsConserved) {
    std::mt19937 rng(7);
    const System system = compiled(random_tree(rng, 12));
    TreeKinematics tree(system);
    const TreeState x(tree, rng);
    const TreePose pose(system, tree, x.s, 0.3 * x.w);
    State state = initial_state(system);
    state.q = pose.q;
    state.u = pose.u;
    const double before = integrator_tools::mechanical_energy(system, state);
    auto rk4 = make_integrator("rk4", system, options(Formulation::tree, 1e-3));
    rk4->start(state);
    ASSERT_TRUE(integrator_tools::run(*rk4, 1).ok);
    const double after = integrator_tools::mechanical_energy(system, rk4->state());
    EXPECT_NEAR(after, before, 1e-7 * std::abs(before) + 1e-7);
    Workspace ws = make_workspace(system);
    set_motion(system, rk4->state().q, rk4->state().u, ws);
    evaluate_constraints(system, 0, nullptr, false, ws);
    EXPECT_LT(ws.phi.norm(), 1e-12); // nothing drifts
}

TEST(TreeMotion, GoesOnExactlyFromACheckpoint) {
    for (const std::string name : {"chain", "four-bar", "heavy-top"}) {
        SimulationOptions o;
        o.integrator = "rk4";
        o.integration = options(Formulation::tree, 1e-3);
        Simulation whole(build_mechanism(name, {}), o), first(build_mechanism(name, {}), o),
            second(build_mechanism(name, {}), o);
        const StepOutcome outcome = whole.advance_to(0.02);
        ASSERT_TRUE(outcome.ok) << name << outcome.message;
        ASSERT_TRUE(first.advance_to(0.02).ok);
        std::stringstream file;
        first.save(file);
        second.load(file);
        ASSERT_TRUE(whole.advance_to(0.04).ok);
        ASSERT_TRUE(second.advance_to(0.04).ok);
        EXPECT_EQ(whole.state().q, second.state().q) << name;
        EXPECT_EQ(whole.state().u, second.state().u) << name;
    }
}

TEST(TreeMotion, SameBitsForAnyThreads) {
    std::vector<VecX> ends;
    for (const int threads : {1, 2, 3}) {
        SimulationOptions o;
        o.integrator = "rk4";
        o.integration = options(Formulation::tree, 1e-3);
        o.integration.threads = threads;
        Simulation sim(build_mechanism("chain", {{"links", "600"}}), o);
        ASSERT_TRUE(sim.advance_to(0.01).ok);
        ends.push_back(sim.state().q);
    }
    EXPECT_EQ(ends[0], ends[1]);
    EXPECT_EQ(ends[0], ends[2]);
}

// A drive is a row beside its joint: the crank turns as told, and the drive's work is counted.
TEST(TreeMotion, DrivenJoint) {
    Model model;
    model.bodies = {make_bar("bar", 0.1, {0.5, 0, 0})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, -1, 0})};
    model.joints[0].drives["angle"] = SmoothStepFunction{0, 1, 0, 1.2};
    SimulationOptions o;
    o.integrator = "rk4";
    o.integration = options(Formulation::tree, 1e-3);
    Simulation sim(model, o);
    ASSERT_TRUE(sim.advance_to(1).ok);
    const Sample& sample = sim.sample();
    EXPECT_NEAR(sample.state.q[2], 0.5 * std::sin(1.2), 1e-9);
    EXPECT_NEAR(sample.state.input(), 9.81 * 0.5 * std::sin(1.2), 1e-7); // lifted
    EXPECT_LT(std::abs(sample.balance), 1e-7);
}

TEST(TreeMotion, OthersRefuse) {
    const System system = compiled("pendulum");
    for (const std::string name : {"ida", "bayo"})
        EXPECT_THROW(make_integrator(name, system, options(Formulation::tree)), std::invalid_argument)
            << name;
}

TEST(TreeMotion, MatricesKnowTheReactions) {
    std::vector<Simulation::Matrices> found;
    for (const Formulation f : {Formulation::saddle_point, Formulation::tree}) {
        SimulationOptions o;
        o.integrator = "rk4";
        o.integration = options(f, 1e-3);
        Simulation sim(build_mechanism("chain", {{"links", "4"}}), o);
        ASSERT_TRUE(sim.advance_to(0.1).ok);
        found.push_back(sim.matrices());
    }
    EXPECT_LT((dense(found[0].K) - dense(found[1].K)).norm(), 1e-6 * dense(found[0].K).norm());
}

} // namespace
} // namespace gudgeon
