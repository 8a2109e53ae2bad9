// Steps of Gear's method and of Radau IIA: their record, reasons for rejection, limits, and clean ends.
#include "core/user_force.hpp"
#include "models/builders.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace gudgeon {
namespace {

using namespace test;

class ImplicitSteps : public testing::TestWithParam<const char*> {
  protected:
    static SimulationOptions tolerance(double tol) {
        SimulationOptions options;
        options.integrator = GetParam();
        options.integration.rtol = options.integration.atol = tol;
        return options;
    }

    /// Chain of three whose second link meets a place where its force is no number.
    static SimulationOptions trap(double height) {
        SimulationOptions options = tolerance(1e-6);
        options.user_forces = {
            {"trap", {"ground", "link2"}, [height](const UserForceInput& in, UserForceOutput& out) {
                 if (in.b.r.z() < height)
                     out.wrench.force_b.x() = std::numeric_limits<double>::quiet_NaN();
             }}};
        return options;
    }
};

INSTANTIATE_TEST_SUITE_P(Both, ImplicitSteps, testing::Values("gear", "radau"));

TEST_P(ImplicitSteps, EveryAttemptIsOnRecordWithItsReason) {
    Simulation sim(build_mechanism("suspension-chain"), tolerance(1e-5));
    std::vector<StepRecord> records;
    sim.integrator().on_step = [&](const StepRecord& r) { records.push_back(r); };
    ASSERT_TRUE(sim.advance_to(1).ok);
    const Statistics& s = sim.statistics();
    long accepted = 0, by_error = 0, by_newton = 0;
    std::array<long, 9> orders{};
    double t = 0, shortest = 1, longest = 0;
    for (const StepRecord& r : records) {
        EXPECT_GT(r.h, 0);
        EXPECT_NEAR(r.t - r.h, t, 1e-15); // from the last accepted point
        EXPECT_GE(r.order, 1);
        EXPECT_LE(r.order, 5);
        if (r.reason == StepReason::none) {
            ++accepted;
            ++orders[r.order];
            EXPECT_LE(r.error, 1);
            shortest = std::min(shortest, r.h);
            longest = std::max(longest, r.h);
            t = r.t;
        } else if (r.reason == StepReason::error_test) {
            ++by_error;
            EXPECT_GT(r.error, 1);
        } else {
            ++by_newton;
        }
    }
    EXPECT_EQ(t, 1);
    EXPECT_EQ(accepted, s.steps);
    EXPECT_EQ(by_error, s.rejected_error);
    EXPECT_EQ(by_newton, s.rejected_newton);
    EXPECT_GT(by_error, 0); // the road begins with a jump of its speed
    EXPECT_EQ(orders, s.order_histogram);
    EXPECT_EQ(shortest, s.smallest_step);
    EXPECT_EQ(longest, s.largest_step);
    EXPECT_GE(s.newton_sweeps, s.steps);
    EXPECT_GT(s.factorisations + s.refactorisations, 0);
    EXPECT_EQ(s.nnz_matrix, SaddleMatrix(sim.system()).pattern().nonzeros());
    EXPECT_GE(s.nnz_factors, sim.system().velocities());
}

TEST_P(ImplicitSteps, ConstraintsHoldAtEveryAcceptedStep) {
    for (const char* name : {"pendulum", "slider-crank", "chain", "triple-pendulum"})
        for (const double tol : {1e-3, 1e-5, 1e-7}) {
            Simulation sim(build_mechanism(name), tolerance(tol));
            Workspace ws = make_workspace(sim.system());
            double phi = 0, rate = 0;
            Integrator& integrator = sim.integrator();
            while (integrator.state().t < 1) {
                ASSERT_TRUE(integrator.advance(1).ok);
                const State& s = integrator.state();
                ws.angles = s.angles;
                set_motion(sim.system(), s.q, s.u, ws);
                evaluate_constraints(sim.system(), s.t, nullptr, false, ws);
                phi = std::max(phi, ws.phi.cwiseAbs().maxCoeff());
                rate = std::max(rate, ws.rate.cwiseAbs().maxCoeff());
            }
            EXPECT_LT(phi, 1e-10) << name << ", " << tol;
            EXPECT_LT(rate, 1e-10) << name << ", " << tol;
            // the record is of the last look, before a last correction: never too good
            EXPECT_LE(phi, sim.statistics().constraint_position_max + 1e-14);
            EXPECT_LE(rate, sim.statistics().constraint_velocity_max + 1e-14);
        }
}

TEST_P(ImplicitSteps, LongestStepIsObeyed) {
    SimulationOptions options = tolerance(1e-3);
    options.integration.step = 2e-3;
    options.integration.max_order = 2; // gear
    Simulation sim(build_mechanism("chain"), options);
    ASSERT_TRUE(sim.advance_to(0.5).ok);
    const Statistics& s = sim.statistics();
    EXPECT_LE(s.largest_step, 2e-3 * (1 + 1e-12));
    EXPECT_GE(s.steps, 250);
    EXPECT_LT(s.steps, 300);
    const bool gear = GetParam() == std::string("gear");
    EXPECT_EQ(gear ? s.order_histogram[1] + s.order_histogram[2] : s.order_histogram[5], s.steps);
}

TEST_P(ImplicitSteps, NoMoreStepsThanAllowed) {
    SimulationOptions options = tolerance(1e-6);
    options.integration.max_steps = 20;
    Simulation sim(build_mechanism("pendulum"), options);
    const StepOutcome outcome = sim.advance_to(10);
    EXPECT_FALSE(outcome.ok);
    EXPECT_NE(outcome.message.find("20 steps"), std::string::npos) << outcome.message;
    EXPECT_EQ(sim.statistics().steps, 20);
}

TEST_P(ImplicitSteps, StopsExactlyWhereTold) {
    Simulation sim(build_mechanism("heavy-top"), tolerance(1e-6));
    for (const double t : {1e-6, 0.1, 0.1 + 1e-9, 0.35, 0.36}) {
        ASSERT_TRUE(sim.advance_to(t).ok);
        EXPECT_EQ(sim.time(), t);
        EXPECT_EQ(sim.state().t, t);
    }
}

TEST_P(ImplicitSteps, InterpolantMeetsTheStepsAndStaysWithinTheTolerance) {
    const double tol = 1e-7;
    Simulation sim(build_mechanism("heavy-top"), tolerance(tol));
    Simulation fine(build_mechanism("heavy-top"), tolerance(1e-12));
    ASSERT_TRUE(sim.advance_past(0.2, 1).ok);
    Integrator& integrator = sim.integrator();
    const double h = sim.statistics().largest_step;
    State at = integrator.state();
    integrator.interpolate(integrator.state().t, at);
    EXPECT_LT((at.q - integrator.state().q).norm() + (at.u - integrator.state().u).norm(), 1e-12);
    const double end = integrator.state().t;
    for (const double back : {0.5, 0.25, 0.125}) {
        const double t = end - back * std::min(h, end - 0.2);
        integrator.interpolate(t, at);
        ASSERT_TRUE(fine.advance_to(t).ok || fine.time() > t);
        EXPECT_EQ(at.t, t);
        EXPECT_LT((at.q - fine.state().q).cwiseAbs().maxCoeff(), 100 * tol);
        EXPECT_LT((at.u - fine.state().u).cwiseAbs().maxCoeff(), 3000 * tol); // at 40 rad/s
    }
}

TEST_P(ImplicitSteps, ForceThatIsNoNumberEndsTheRunByName) {
    const double height = -0.5;
    Simulation sim(build_mechanism("chain", {{"links", "3"}}), trap(height));
    const StepOutcome outcome = sim.advance_to(2);
    ASSERT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.reason, StepReason::non_finite);
    EXPECT_NE(outcome.message.find("link2"), std::string::npos) << outcome.message;
    EXPECT_NE(outcome.message.find("at t = 0."), std::string::npos) << outcome.message;
    // what was computed stays, up to the trap's edge
    const State s = sim.state();
    EXPECT_GT(s.t, 0.1);
    EXPECT_LT(s.t, 1);
    EXPECT_EQ(s.t, sim.time());
    EXPECT_TRUE(s.q.allFinite() && s.u.allFinite() && s.lambda.allFinite());
    const double z = s.q[7 + 2];
    EXPECT_GT(z, height);
    EXPECT_LT(z, height + 1e-3);
    EXPECT_NE(outcome.message.find(std::to_string(s.t).substr(0, 5)), std::string::npos) << outcome.message;
    EXPECT_TRUE(sim.sample().acceleration.allFinite());
    EXPECT_GT(sim.statistics().rejected_newton, 0);
}

TEST_P(ImplicitSteps, NanInOneOfTwoUncoupledBodiesIsNotPassedOver) {
    Model model;
    model.bodies = {make_body("first", 1, {1, 1, 1}, {0, 0, 0}),
                    make_body("second", 1, {1, 1, 1}, {3, 0, 0})};
    SimulationOptions options = tolerance(1e-6);
    options.user_forces = {{"trap", {"ground", "first"}, [](const UserForceInput& in, UserForceOutput& out) {
                                if (in.t > 0.4)
                                    out.wrench.moment_b.y() = std::numeric_limits<double>::quiet_NaN();
                            }}};
    Simulation sim(model, options);
    const StepOutcome outcome = sim.advance_to(1);
    ASSERT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.reason, StepReason::non_finite);
    EXPECT_NE(outcome.message.find("'first'"), std::string::npos) << outcome.message;
    EXPECT_TRUE(sim.state().q.allFinite() && sim.state().u.allFinite());
    EXPECT_LE(sim.time(), 0.4);
    EXPECT_GT(sim.time(), 0.39);
}

TEST_P(ImplicitSteps, MechanismPulledBeyondItsReachEndsThere) {
    // crank of 0.08 m about (0.1, 0.12): the rod's end comes as near to the slider's line as this
    const double nearest = std::hypot(0.1, 0.12) - 0.08, reach = std::sqrt(0.09 - nearest * nearest);
    Model model = build_mechanism("slider-crank");
    joint_named(model, "D").drives["slide"] = RampFunction{0, 0.24, 0};
    Simulation sim(model, tolerance(1e-5));
    const double locked = (reach - 0.2) / 0.24;
    const StepOutcome outcome = sim.advance_to(2 * locked);
    ASSERT_FALSE(outcome.ok);
    EXPECT_NE(outcome.reason, StepReason::none);
    EXPECT_TRUE(outcome.message.find("joint '") != std::string::npos ||
                outcome.message.find("body '") != std::string::npos)
        << outcome.message;
    EXPECT_NE(outcome.message.find(std::to_string(sim.time()).substr(0, 4)), std::string::npos)
        << outcome.message;
    EXPECT_GT(sim.time(), 0.98 * locked);
    EXPECT_LE(sim.time(), locked * (1 + 1e-9));
    const State s = sim.state();
    EXPECT_TRUE(s.q.allFinite() && s.u.allFinite());
    EXPECT_NEAR(s.q[7 * sim.system().body_index("slider")], 0.2 + 0.24 * s.t, 1e-9);
}

} // namespace
} // namespace gudgeon
