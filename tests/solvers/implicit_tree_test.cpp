// Gear's method and Radau IIA in joint coordinates: references, agreement with the coordinates of the bodies,
// contacts, friction, threads.
#include "solvers/redundancy.hpp"
#include "tests/core/tree_tools.hpp"
#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_runs.hpp"

namespace gudgeon {
namespace {

using namespace test;

class ImplicitTree : public testing::TestWithParam<const char*> {
  protected:
    static SimulationOptions options(double tol, Formulation formulation = Formulation::tree) {
        SimulationOptions o;
        o.integrator = GetParam();
        o.integration.rtol = o.integration.atol = tol;
        o.integration.formulation = formulation;
        return o;
    }
};
INSTANTIATE_TEST_SUITE_P(Methods, ImplicitTree, testing::Values("gear", "radau"));

class ImplicitTreeAgainst : public testing::TestWithParam<std::tuple<const char*, Reference>> {};

// The same bounds as in the coordinates of the bodies, but for three: there the spinning top is closed onto
// the velocity of its mass centre, which is smooth in global directions, where the speeds of the spherical
// joint turn with the top at 40 rad/s; and Radau's errors of the tip's height (16 links) are by chance a
// hundredth of those of its x, and those of the triple pendulum a little smaller.
TEST_P(ImplicitTreeAgainst, Reference) {
    const auto& [integrator, given] = GetParam();
    const bool gear = std::string(integrator) == "gear";
    Reference reference = given;
    if (reference.name == "ChainOfSixteen")
        reference.pairs[1].radau = reference.pairs[0].radau;
    const double share = gear && reference.name == "HeavyTop" ? 8 : gear ? 1 : 2;
    expect_agreement(reference, integrator, Formulation::tree, share);
}
INSTANTIATE_TEST_SUITE_P(Slow, ImplicitTreeAgainst,
                         testing::Combine(testing::Values("gear", "radau"), testing::ValuesIn(references())),
                         [](const auto& info) {
                             return std::string(std::get<0>(info.param)) + std::get<1>(info.param).name;
                         });

struct Case {
    std::string name;
    std::map<std::string, std::string> parameters;
    double end;
};

// Everything at the end of tight runs, reactions of tree joints among it.
TEST_P(ImplicitTree, AgreesWithTheBodiesCoordinates) {
    const std::vector<Case> cases{
        {"chain", {{"links", "6"}, {"joint", "spherical"}}, 0.5},
        {"chain", {{"links", "6"}, {"joint", "universal"}}, 0.5},
        {"slider-crank", {}, 0.3},
        {"slider-crank", {{"joint", "spherical"}}, 0.2},
        {"slider-crank", {{"joint", "revolute"}}, 0.1},
        {"triple-pendulum", {}, 0.6},
        {"hmmwv-corner", {}, 0.3},
        {"hmmwv-corner", {{"joints", "perfect"}}, 0.3},
        {"suspension-chain", {{"units", "2"}, {"joints", "perfect"}}, 0.3},
        {"suspension-chain", {{"units", "1"}, {"joints", "mixed"}}, 0.05},
        {"stick-slip", {}, 0.5},
        {"bouncing-journal", {}, 0.1},
        {"tilted-journal", {}, 0.02},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name + " to " + std::to_string(c.end));
        std::vector<Sample> ends;
        for (const Formulation f : {Formulation::saddle_point, Formulation::tree}) {
            Simulation sim(build_mechanism(c.name, c.parameters), options(1e-9, f));
            EXPECT_STREQ(sim.formulation(), formulation_name(f));
            const StepOutcome outcome = sim.advance_to(c.end);
            ASSERT_TRUE(outcome.ok) << outcome.message;
            EXPECT_LT(sim.statistics().constraint_position_max, 1e-10);
            ends.push_back(sim.sample());
        }
        const State &a = ends[0].state, &b = ends[1].state;
        EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), 2e-6);
        EXPECT_LT((a.u - b.u).norm(), 3e-5 * (1 + a.u.norm()));
        EXPECT_LT((a.work - b.work).norm(), 1e-6 * (1 + a.work.norm()));
        for (std::size_t j = 0; j < ends[0].joint.size(); ++j)
            EXPECT_LT((ends[0].joint[j].force - ends[1].joint[j].force).norm(),
                      1e-3 * (1 + ends[0].joint[j].force.norm()));
        for (std::size_t j = 0; j < a.history.size(); ++j)
            EXPECT_EQ(a.history[j].impacts, b.history[j].impacts);
    }
}

// Tree joints are closed by construction at every step, however wide the tolerance.
TEST_P(ImplicitTree, OpenTreesNeverDrift) {
    for (const std::string joint : {"revolute", "spherical", "universal"}) {
        Simulation sim(build_mechanism("chain", {{"links", "8"}, {"joint", joint}}), options(1e-3));
        ASSERT_TRUE(sim.advance_to(2).ok);
        EXPECT_LT(sim.statistics().constraint_position_max, 1e-13);
        EXPECT_LT(sim.statistics().constraint_velocity_max, 1e-12);
        EXPECT_EQ(sim.statistics().constraint_polish, 0);
    }
}

// A random tree of all kinds, free bodies among them, swings without loss.
TEST_P(ImplicitTree, EnergyIsConserved) {
    std::mt19937 rng(7);
    const System system = compiled(random_tree(rng, 12));
    TreeKinematics tree(system);
    const TreeState x(tree, rng);
    const TreePose pose(system, tree, x.s, 0.3 * x.w);
    State state = initial_state(system);
    state.q = pose.q;
    state.u = pose.u;
    const double before = integrator_tools::mechanical_energy(system, state);
    IntegratorOptions o;
    o.rtol = o.atol = 1e-9;
    o.formulation = Formulation::tree;
    auto integrator = make_integrator(GetParam(), system, o);
    integrator->start(state);
    ASSERT_TRUE(integrator_tools::run(*integrator, 1).ok);
    const double after = integrator_tools::mechanical_energy(system, integrator->state());
    EXPECT_NEAR(after, before, 2e-6 * std::abs(before) + 1e-6);
    Workspace ws = make_workspace(system);
    set_motion(system, integrator->state().q, integrator->state().u, ws);
    evaluate_constraints(system, 0, nullptr, false, ws);
    EXPECT_LT(ws.phi.norm(), 1e-12);
}

// Sweeps and error estimates know the motion of the joints: a wrong sign in them costs many steps.
TEST_P(ImplicitTree, SweepsContract) {
    for (const std::string name : {"chain", "slider-crank", "heavy-top"}) {
        std::vector<double> sweeps, steps;
        for (const Formulation f : {Formulation::saddle_point, Formulation::tree}) {
            Simulation sim(build_mechanism(name), options(1e-6, f));
            ASSERT_TRUE(sim.advance_to(0.5).ok);
            const Statistics& s = sim.statistics();
            EXPECT_EQ(s.rejected_newton, 0) << name;
            sweeps.push_back(double(s.newton_sweeps));
            steps.push_back(double(s.steps));
        }
        EXPECT_LT(sweeps[1], 1.4 * sweeps[0]) << name;
        EXPECT_LT(steps[1], 1.7 * steps[0]) << name;
    }
}

TEST_P(ImplicitTree, SameBitsForAnyThreads) {
    std::vector<VecX> ends;
    for (const int threads : {1, 2, 3}) {
        SimulationOptions o = options(1e-4);
        o.integration.threads = threads;
        Simulation sim(build_mechanism("chain", {{"links", "1200"}}), o);
        ASSERT_TRUE(sim.advance_to(0.01).ok);
        ends.push_back(sim.state().q);
    }
    EXPECT_EQ(ends[0], ends[1]);
    EXPECT_EQ(ends[0], ends[2]);
}

// A drive is a row beside its joint: the bar turns as told, and the drive's work is counted.
TEST_P(ImplicitTree, DrivenJoint) {
    Model model;
    model.bodies = {make_bar("bar", 0.1, {0.5, 0, 0})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, -1, 0})};
    HarmonicFunction drive;
    drive.frequency = 0.5;
    drive.amplitude = 1.2;
    model.joints[0].drives["angle"] = drive;
    Simulation sim(model, options(1e-9));
    ASSERT_TRUE(sim.advance_to(0.8).ok);
    const Sample& sample = sim.sample();
    const double angle = 1.2 * std::sin(0.8 * pi), rate = 1.2 * pi * std::cos(0.8 * pi), start = 1.2 * pi;
    EXPECT_NEAR(sample.state.q[2], 0.5 * std::sin(angle), 1e-9);
    const double inertia = sim.system().inertia[0](1, 1) + 0.25;
    EXPECT_NEAR(sample.state.input(),
                9.81 * 0.5 * std::sin(angle) + 0.5 * inertia * (rate * rate - start * start), 1e-5);
    EXPECT_LT(std::abs(sample.balance), 1e-5);
}

TEST_P(ImplicitTree, RepeatedConstraintsAreRefusedByName) {
    try {
        Simulation sim(build_mechanism("four-bar"), options(1e-6));
        FAIL() << "accepted";
    } catch (const ModelError& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("repeat"), std::string::npos) << text;
        EXPECT_NE(text.find(GetParam()), std::string::npos) << text;
        Simulation named(build_mechanism("four-bar"), {});
        for (const int row : dependent_rows(named.system(), initial_state(named.system())))
            EXPECT_NE(text.find(named.system().joints[named.system().rows[row].joint].name),
                      std::string::npos)
                << text;
    }
}

} // namespace
} // namespace gudgeon
