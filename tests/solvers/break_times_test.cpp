// Steps meet what stirs after a rest.
#include "solvers/break_times.hpp"

#include "models/builders.hpp"
#include "solvers/simulation.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

TimeFunction table(std::vector<double> x, std::vector<double> y) {
    return TableFunction(Table{std::move(x), std::move(y)});
}

AppliedForce push(const TimeFunction& time) {
    AppliedForce force;
    force.name = "push";
    force.body = "block";
    force.vector = Vec3::UnitX();
    force.time = time;
    return force;
}

Model free_block() {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("block", 1, Vec3::Constant(0.1), Vec3::Zero())};
    return model;
}

std::vector<double> breaks_of(const TimeFunction& time) {
    Model model = free_block();
    model.forces = {push(time)};
    return break_times(model);
}

using Times = std::vector<double>;

TEST(BreakTimes, AreWhereConstantStretchesEnd) {
    EXPECT_EQ(breaks_of(ConstantFunction{2}), Times{});
    EXPECT_EQ(breaks_of(HarmonicFunction{}), Times{});
    EXPECT_EQ(breaks_of(SmoothStepFunction{1, 2, 0, 3}), (Times{1, 2}));
    EXPECT_EQ(breaks_of(RampFunction{0, 1, 4}), Times{4});
    EXPECT_EQ(breaks_of(table({0, 5, 6, 7, 9}, {0, 0, 2, 0, 0})), (Times{5, 6}));
    EXPECT_EQ(breaks_of(table({1, 2, 3, 4}, {0, 1, 3, 2})), (Times{1, 2})); // constant before its first point
    EXPECT_EQ(breaks_of(table({0, 1, 2, 3, 4}, {1, 1, 2, 2, 1})), (Times{1, 2, 3, 4}));
}

TEST(BreakTimes, OfAllThatIsGivenInTime) {
    Model model = free_block();
    model.joints = {
        make_joint("guide", JointKind::translation, "ground", "block", Vec3::Zero(), Vec3::UnitX())};
    model.joints[0].drives["slide"] = RampFunction{0, 1, 8};
    SpringDamper spring;
    spring.name = "actuator";
    spring.bodies = {"ground", "block"};
    spring.points = {Vec3(-1, 0, 0), Vec3::Zero()};
    spring.actuator = SmoothStepFunction{3, 4, 0, 1};
    Tyre tyre;
    tyre.name = "tyre";
    tyre.body = "block";
    tyre.road = SmoothStepFunction{4, 5, 0, 1};
    model.forces = {push(ConstantFunction{}), spring, tyre};
    EXPECT_EQ(break_times(model), (Times{3, 4, 5, 8}));
}

// 1 N s within a millisecond after 100 s without any force.
TEST(BreakTimes, PulseAfterALongRestIsMet) {
    Model model = free_block();
    model.forces = {push(table({0, 100, 100.0005, 100.001, 200}, {0, 0, 2000, 0, 0}))};
    const double impulse =
        Spline(std::get<TableFunction>(*std::get<AppliedForce>(model.forces[0]).time).table(),
               Spline::Ends::constant)(200)
            .integral;
    ASSERT_GT(impulse, 0.5);
    for (const char* integrator : {"gear", "radau", "auto", "ida"})
        for (const bool past : {true, false}) {
            SCOPED_TRACE(integrator);
            SimulationOptions options;
            options.integrator = integrator;
            Simulation sim(model, options);
            const StepOutcome outcome = past ? sim.advance_past(150, 200) : sim.advance_to(150);
            ASSERT_TRUE(outcome.ok) << outcome.message;
            EXPECT_NEAR(sim.sample_at(150).motion[0].v.x(), impulse, 1e-3);
            EXPECT_LT(sim.statistics().steps, 500);
        }
}

} // namespace
} // namespace gudgeon
