// Steps take no memory: every malloc of the process is counted while a thread asks for it.
#include "core/user_force.hpp"
#include "solvers/simulation.hpp"
#include "tests/allocation_count.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

class NoAllocation : public testing::Test {
  protected:
    void SetUp() override {
        if (!GUDGEON_COUNTS_ALLOCATIONS)
            GTEST_SKIP() << "allocations are not counted in this build";
    }

    template <class F> static long count(F&& f) { return count_allocations(f); }
};

class NoAllocationSteps : public NoAllocation,
                          public testing::WithParamInterface<std::tuple<const char*, Formulation>> {
  protected:
    /// Steps until 1000 of them were counted; those with a full factorisation are left out.
    static void expect_none(const std::string& name, const std::map<std::string, std::string>& parameters,
                            double tol) {
        SCOPED_TRACE(name);
        SimulationOptions options;
        options.integrator = std::get<0>(GetParam());
        options.integration.formulation = std::get<1>(GetParam());
        options.integration.rtol = options.integration.atol = tol;
        Simulation sim(build_mechanism(name, parameters), options);
        Integrator& integrator = sim.integrator();
        for (int i = 0; i < 50; ++i)
            ASSERT_TRUE(integrator.advance(1e3).ok);
        long steps = 0, with_allocation = 0, allocations = 0;
        for (int i = 0; i < 5000 && steps < 1000; ++i) {
            const long before = integrator.statistics().factorisations;
            bool ok = true;
            const long n = count([&] { ok = integrator.advance(1e3).ok; });
            ASSERT_TRUE(ok);
            if (integrator.statistics().factorisations != before)
                continue;
            ++steps;
            allocations += n;
            with_allocation += n > 0;
        }
        EXPECT_EQ(steps, 1000);
        EXPECT_EQ(allocations, 0) << "in " << with_allocation << " steps";
    }
};

TEST_F(NoAllocation, Rk4InJointCoordinates) {
    for (const std::string name : {"chain", "slider-crank", "heavy-top"}) {
        SCOPED_TRACE(name);
        SimulationOptions options;
        options.integrator = "rk4";
        options.integration.step = 1e-4;
        options.integration.formulation = Formulation::tree;
        Simulation sim(build_mechanism(name, {}), options);
        Integrator& integrator = sim.integrator();
        for (int i = 0; i < 50; ++i)
            ASSERT_TRUE(integrator.advance(1e3).ok);
        const long full = integrator.statistics().factorisations;
        const long n = count([&] {
            for (int i = 0; i < 200; ++i)
                integrator.advance(1e3);
        });
        if (integrator.statistics().factorisations == full) {
            EXPECT_EQ(n, 0);
        }
    }
}

TEST_F(NoAllocation, HookCounts) {
    EXPECT_GT(count([] {
                  std::vector<double> x(100);
                  x[0] = 1;
                  EXPECT_EQ(x[0], 1);
              }),
              0);
    EXPECT_GT(count([] { VecX::Ones(100).eval(); }), 0);
    EXPECT_EQ(count([] { EXPECT_TRUE(true); }), 0);
}

TEST_P(NoAllocationSteps, OfAChain) { expect_none("chain", {{"links", "10"}}, 1e-6); }
TEST_P(NoAllocationSteps, OfASliderCrank) { expect_none("slider-crank", {}, 1e-6); }
TEST_P(NoAllocationSteps, OfASuspensionChain) { expect_none("suspension-chain", {{"units", "3"}}, 1e-5); }
TEST_P(NoAllocationSteps, OfAPerfectSuspensionChain) {
    expect_none("suspension-chain", {{"units", "3"}, {"joints", "perfect"}}, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Implicit, NoAllocationSteps,
                         testing::Combine(testing::Values("gear", "radau"),
                                          testing::Values(Formulation::saddle_point, Formulation::tree)));

TEST_F(NoAllocation, EvaluationOfEverything) {
    const System system = compiled("suspension-chain", {{"units", "2"}});
    Workspace ws = make_workspace(system);
    const State state = initial_state(system);
    const SaddleMatrix saddle(system);
    std::vector<double> values(saddle.pattern().nonzeros());
    const auto evaluate_all = [&] {
        set_motion(system, state.q, state.u, ws);
        evaluate_forces(system, 0.1, ws);
        evaluate_constraints(system, 0.1, state.lambda.data(), true, ws);
        linearise(system, 0.1, state.lambda.data(), ws);
        saddle.assemble(system, ws, 100, 0.01, values);
    };
    evaluate_all(); // OpenMP makes its own structures at first use
    EXPECT_EQ(count(evaluate_all), 0);
}

} // namespace
} // namespace gudgeon
