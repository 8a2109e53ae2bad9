// The same motion by both formulations, counts of the work, and what `auto` chooses.
#include "core/channels.hpp"
#include "solvers/simulation.hpp"
#include "tests/allocation_count.hpp"
#include "tests/solvers/reference_table.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace gudgeon {
namespace {

using namespace test;
using Parameters = std::map<std::string, std::string>;

SimulationOptions options(const std::string& integrator, Formulation formulation, double tol) {
    SimulationOptions out;
    out.integrator = integrator;
    out.integration.rtol = out.integration.atol = tol;
    out.integration.formulation = formulation;
    return out;
}

/// Positions of the runs at `end`, compared; no formulation may have been left.
void expect_same_motion(Model model, const std::string& integrator, double tol, double end, double bound) {
    Simulation blocks(model, options(integrator, Formulation::saddle_point, tol));
    Simulation klu(model, options(integrator, Formulation::saddle_point_klu, tol));
    Simulation cholmod(std::move(model), options(integrator, Formulation::augmented_lagrangian, tol));
    for (Simulation* one : {&blocks, &klu, &cholmod}) {
        const StepOutcome outcome = one->advance_to(end);
        ASSERT_TRUE(outcome.ok) << outcome.message;
    }
    for (const Simulation* one : {&blocks, &cholmod})
        EXPECT_LT((klu.state().q - one->state().q).cwiseAbs().maxCoeff(), bound);
    EXPECT_STREQ(blocks.formulation(), "saddle-point");
    EXPECT_STREQ(blocks.linear_solver(), "block");
    EXPECT_EQ(blocks.statistics().klu_fallbacks, 0);
    EXPECT_STREQ(klu.formulation(), "saddle-point-klu");
    EXPECT_STREQ(klu.linear_solver(), "klu");
    EXPECT_EQ(klu.statistics().klu_fallbacks, 0);
    EXPECT_STREQ(cholmod.formulation(), "augmented-lagrangian");
    EXPECT_STREQ(cholmod.linear_solver(), "cholmod");
    EXPECT_EQ(klu.statistics().cholmod_solves, 0);
    const Statistics& s = cholmod.statistics();
    EXPECT_EQ(s.klu_fallbacks, 0);
    EXPECT_EQ(s.cholmod_factorisations, s.factorisations + s.refactorisations);
    EXPECT_GE(s.cholmod_solves, s.newton_sweeps);
    EXPECT_GT(s.cholmod_iterations, 0);
    EXPECT_LT(s.constraint_position_max, 1e-10);
    EXPECT_LT(s.constraint_velocity_max, 1e-10);
}

struct Case {
    std::string name, mechanism;
    Parameters parameters;
    double end, bound; // of the difference at 1e-6: what the error control leaves, seen against references
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class BothFormulations : public testing::TestWithParam<Case> {};

TEST_P(BothFormulations, MoveAlike) {
    const Case& c = GetParam();
    for (const char* integrator : {"gear", "radau"}) {
        SCOPED_TRACE(integrator);
        expect_same_motion(build_mechanism(c.mechanism, c.parameters), integrator, 1e-6, c.end, c.bound);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Of, BothFormulations,
    testing::Values(
        Case{"Chain", "chain", {{"links", "30"}}, 0.5, 1e-6},
        Case{"UniversalChain", "chain", {{"links", "10"}, {"joint", "universal"}}, 0.5, 1e-6},
        Case{"SliderCrank", "slider-crank", {}, 1, 1e-5}, Case{"Top", "heavy-top", {}, 1, 1e-5},
        Case{"Corner", "hmmwv-corner", {}, 1, 1e-5},
        Case{"Suspension", "suspension-chain", {{"units", "3"}}, 1, 1e-5},
        Case{"PerfectSuspension", "suspension-chain", {{"units", "3"}, {"joints", "perfect"}}, 1, 1e-5},
        Case{"WornJoint", "slider-crank", {{"joint", "spherical"}}, 0.1, 1e-5},
        Case{"Stops", "triple-pendulum", {{"stops", "1"}}, 1, 1e-4}),
    [](const auto& info) { return info.param.name; });

TEST(Formulations, AgainstTheReference) {
    const testing_data::ReferenceTable table("r5_chain_N16.csv");
    for (const char* integrator : {"gear", "radau"}) {
        SCOPED_TRACE(integrator);
        Simulation sim(build_mechanism("chain", {{"links", "16"}, {"thin", "1"}}),
                       options(integrator, Formulation::augmented_lagrangian, 1e-8));
        const StepOutcome outcome = sim.advance_to(table["t"].back());
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Channels tip(sim.system(), {"tip.x"});
        double x = 0;
        tip.read(sim.sample(), {&x, 1});
        EXPECT_NEAR(x, table["tip_x"].back(), 2e-6);
        EXPECT_EQ(sim.statistics().klu_fallbacks, 0);
    }
}

// Links of 1e-3 and 1e3 kg in turn: a mass ratio of 1e6 at every joint.
TEST(Formulations, MassRatiosOfAMillion) {
    Model model = build_mechanism("chain", {{"links", "8"}});
    double factor = 1e-3;
    for (Body& body : model.bodies) {
        body.mass *= factor;
        body.inertia *= factor;
        factor = 1 / factor;
    }
    for (const char* integrator : {"gear", "radau"}) {
        SCOPED_TRACE(integrator);
        expect_same_motion(model, integrator, 1e-6, 0.3, 1e-5);
    }
}

TEST(Formulations, StiffBushings) {
    for (const double stiffness : {1e6, 1e9, 1e12}) {
        SCOPED_TRACE(stiffness);
        Model model = build_mechanism("hmmwv-corner");
        for (Joint& joint : model.joints)
            if (joint.bushing)
                std::fill_n(joint.bushing->stiffness.begin(), 3, stiffness);
        expect_same_motion(model, "radau", 1e-5, 0.05, 1e-5);
    }
}

/// A net of point-like bodies joined by rods, hung on one side: many loops.
Model net(int n) {
    Model model;
    model.name = "net";
    const auto place = [](int i, int k) { return Vec3(i, k, 0.02 * ((7 * i + 3 * k) % 5)); };
    const auto name = [](int i, int k) { return "node" + std::to_string(i) + "-" + std::to_string(k); };
    const auto join = [&](JointKind kind, const std::string& a, const std::string& b, const Vec3& pa,
                          const Vec3& pb) {
        Joint joint;
        joint.name = a + "_" + b;
        joint.kind = kind;
        joint.bodies = {a, b};
        joint.points = {pa, pb};
        model.joints.push_back(joint);
    };
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
            Body body;
            body.name = name(i, k);
            body.mass = 0.1;
            body.inertia = 1e-3 * Mat3::Identity();
            body.position = place(i, k);
            model.bodies.push_back(body);
            if (k == 0)
                join(JointKind::spherical, "ground", name(i, 0), place(i, 0), place(i, 0));
            else
                join(JointKind::distance, name(i, k - 1), name(i, k), place(i, k - 1), place(i, k));
            if (i > 0 && k > 0)
                join(JointKind::distance, name(i - 1, k), name(i, k), place(i - 1, k), place(i, k));
        }
    return model;
}

TEST(Formulations, NetsOfManyLoops) {
    for (const char* integrator : {"gear", "radau"}) {
        SCOPED_TRACE(integrator);
        expect_same_motion(net(6), integrator, 1e-6, 0.2, 1e-5);
    }
}

TEST(Formulations, AutoTakesCholmodWhereLoopsFillTheFactors) {
    const auto chosen = [](Model model) {
        return std::string(
            Simulation(std::move(model), options("gear", Formulation::automatic, 1e-6)).formulation());
    };
    EXPECT_EQ(chosen(build_mechanism("chain", {{"links", "300"}})), "saddle-point");
    EXPECT_EQ(chosen(build_mechanism("suspension-chain", {{"units", "10"}})), "saddle-point");
    EXPECT_EQ(chosen(net(8)), "saddle-point");
    EXPECT_EQ(chosen(net(25)), "augmented-lagrangian");
}

TEST(Formulations, AreKnownByName) {
    for (const Formulation f :
         {Formulation::saddle_point, Formulation::augmented_lagrangian, Formulation::automatic})
        EXPECT_EQ(formulation_named(formulation_name(f)), f);
    EXPECT_THROW(formulation_named("penalty"), std::invalid_argument);
}

class FormulationAllocations : public testing::TestWithParam<const char*> {};

TEST_P(FormulationAllocations, NoneInSteps) {
    if (!GUDGEON_COUNTS_ALLOCATIONS)
        GTEST_SKIP() << "allocations are not counted in this build";
    Simulation sim(build_mechanism("chain", {{"links", "10"}}),
                   options(GetParam(), Formulation::augmented_lagrangian, 1e-6));
    Integrator& integrator = sim.integrator();
    for (int i = 0; i < 200; ++i)
        ASSERT_TRUE(integrator.advance(1e3).ok);
    long allocations = 0;
    for (int i = 0; i < 200; ++i)
        allocations += count_allocations([&] { integrator.advance(1e3); });
    EXPECT_EQ(allocations, 0);
}

INSTANTIATE_TEST_SUITE_P(Of, FormulationAllocations, testing::Values("gear", "radau"),
                         [](const auto& info) { return std::string(info.param); });

} // namespace
} // namespace gudgeon
