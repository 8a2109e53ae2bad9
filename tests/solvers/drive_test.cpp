// Driven coordinates: they follow their function, and the drive's torque and work are those of the closed
// form.
#include "core/channels.hpp"
#include "models/builders.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

constexpr double m = 1.5, l = 0.4, jc = 0.06, g = 9.81; // about its mass centre
constexpr double jo = jc + m * l * l;

SimulationOptions tolerance(double tol) {
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = tol;
    return options;
}

/// Arm on a revolute about Y, along +X at angle 0, whose angle follows f. +Y turns it downwards.
Model driven_arm(const TimeFunction& f) {
    const double angle = evaluate(f, 0).value, rate = evaluate(f, 0).rate;
    Model model;
    Body arm = make_body("arm", m, {0.01, jc, jc}, {0, 0, 0});
    arm.orientation = {std::cos(angle / 2), 0, std::sin(angle / 2), 0};
    arm.position = l * Vec3(std::cos(angle), 0, -std::sin(angle));
    arm.angular_velocity = {0, rate, 0};
    arm.velocity = l * rate * Vec3(-std::sin(angle), 0, -std::cos(angle));
    model.bodies = {arm};
    Joint hinge = make_joint("hinge", JointKind::revolute, "ground", "arm", Vec3::Zero());
    hinge.body_frame = true;
    hinge.points = {Vec3::Zero(), Vec3(-l, 0, 0)};
    hinge.axes = {Vec3::UnitY(), Vec3::UnitY()};
    hinge.references = {Vec3::UnitX(), Vec3::UnitX()};
    hinge.drives["angle"] = f;
    model.joints = {hinge};
    return model;
}

/// A mechanism without freedom: nothing but the constraints holds the multipliers.
TEST(Drive, TurnsASliderCrankAtConstantSpeed) {
    for (const std::string integrator : {"gear", "radau"})
        for (const double tol : {1e-4, 1e-6, 1e-7, 1e-8, 1e-9}) {
            SCOPED_TRACE(testing::Message() << integrator << ", tolerance " << tol);
            Model model = build_mechanism("slider-crank");
            RampFunction turn;
            turn.rate = 6;
            for (Joint& joint : model.joints)
                if (joint.name == "A")
                    joint.drives["angle"] = turn;
            SimulationOptions options = tolerance(tol);
            options.integrator = integrator;
            Simulation sim(std::move(model), options);
            const StepOutcome outcome = sim.advance_to(5);
            ASSERT_TRUE(outcome.ok) << outcome.message;
            if (integrator == "gear") {
                EXPECT_EQ(sim.statistics().rejected_newton, 0);
            }
            const double y = 0.1 - 0.08 * std::sin(30), z = 0.12 + 0.08 * std::cos(30);
            const double x = std::sqrt(0.3 * 0.3 - y * y - z * z);
            EXPECT_NEAR(sim.sample().motion[sim.system().body_index("slider")].r.x(), x, 1e-10);
        }
}

double energy(double angle, double rate) { return 0.5 * jo * rate * rate - m * g * l * std::sin(angle); }

void follow(const TimeFunction& f, double end, double tol) {
    Simulation sim(driven_arm(f), tolerance(tol));
    EXPECT_LT(sim.assembly().position_before, 1e-14); // the start is exact
    EXPECT_LT(sim.assembly().velocity_before, 1e-14);
    const Channels angle(sim.system(), {"hinge.angle"});
    const double e0 = energy(evaluate(f, 0).value, evaluate(f, 0).rate);
    for (int k = 1; k <= 20; ++k) {
        const double t = end * k / 20;
        const StepOutcome outcome = sim.advance_past(t, end);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Sample& sample = sim.sample_at(t);
        const TimeValue truth = evaluate(f, t);
        double value = 0;
        angle.read(sample, {&value, 1});
        EXPECT_NEAR(value, truth.value, 1e-10) << t;
        EXPECT_NEAR(sample.state.u[4], truth.rate, 1e-10) << t;
        EXPECT_NEAR(sample.acceleration[4], truth.acceleration, 1e-8) << t;
        // jo alpha = torque of the drive + moment of the weight
        const double torque = jo * truth.acceleration - m * g * l * std::cos(truth.value);
        EXPECT_NEAR(sample.joint[0].moment.y(), torque, 1e-8) << t;
        // multipliers of a BDF step are off by about tol / h, of either sign here and there: the work
        // is known to that share of what the drive moved to and fro
        const double moved = m * g * l * std::max(std::abs(truth.rate), 1.0) * (1 + t);
        EXPECT_NEAR(sample.state.input(), energy(truth.value, truth.rate) - e0, 100 * tol * moved) << t;
        EXPECT_NEAR(sample.balance, 0, 100 * tol * moved) << t;
        EXPECT_EQ(sample.state.dissipated(), 0);
    }
    // at the steps themselves
    EXPECT_LT(sim.statistics().constraint_position_max, 1e-10);
    EXPECT_LT(sim.statistics().constraint_velocity_max, 1e-10);
}

void follow(const TimeFunction& f, double end) {
    for (const double tol : {1e-5, 1e-7, 1e-9})
        follow(f, end, tol);
}

TEST(Drive, HarmonicAngle) { follow(HarmonicFunction{1.2, 0.8, 0.5, 0.3}, 3); }
TEST(Drive, ConstantSpeedForTenTurns) { follow(RampFunction{0.2, 2 * pi, 0}, 10); }
TEST(Drive, ConstantSpeedBackwards) { follow(RampFunction{0, -2 * pi, 0}, 10); }
TEST(Drive, SmoothStepAndRest) { follow(SmoothStepFunction{0.2, 1.4, -0.5, 2.0}, 2); }

TEST(Drive, SlideOfATranslation) {
    // 2 kg pushed up an incline: force along the axis = m a + m g sin(slope)
    const double slope = 0.5;
    const Vec3 axis(std::cos(slope), 0, std::sin(slope));
    const HarmonicFunction f{0.2, 1.5, 0, 0};
    Model model;
    model.bodies = {make_body("slider", 2, {0.1, 0.1, 0.1}, {1, 0, 0})};
    model.bodies[0].velocity = 0.2 * 2 * pi * 1.5 * axis;
    Joint guide = make_joint("guide", JointKind::translation, "ground", "slider", {1, 0, 0}, axis);
    guide.drives["slide"] = f;
    model.joints = {guide};
    Simulation sim(model, tolerance(1e-7));
    for (const double t : {0.13, 0.4, 1.1}) {
        ASSERT_TRUE(sim.advance_to(t).ok);
        const Sample& sample = sim.sample();
        const TimeValue truth = evaluate(TimeFunction(f), t);
        EXPECT_LT((sample.state.q.head<3>() - (Vec3(1, 0, 0) + truth.value * axis)).norm(), 1e-10);
        EXPECT_NEAR(sample.joint[0].force.dot(axis), 2 * (truth.acceleration + g * std::sin(slope)), 1e-8);
        const double work = truth.rate * truth.rate - 0.2 * 0.2 * std::pow(2 * pi * 1.5, 2) +
                            2 * g * truth.value * std::sin(slope);
        EXPECT_NEAR(sample.state.input(), work, 1e-4);
    }
}

TEST(Drive, DrivenCrankMovesTheSliderAsGeometrySays) {
    const double speed = 6;
    Model model = build_mechanism("slider-crank");
    joint_named(model, "A").drives["angle"] = RampFunction{0, speed, 0};
    Simulation sim(model, tolerance(1e-6));
    EXPECT_EQ(sim.redundancy().dof, 0);
    const int slider = sim.system().body_index("slider");
    for (double t = 0.1; t < 2.2; t += 0.25) { // two turns
        ASSERT_TRUE(sim.advance_to(t).ok);
        const double angle = speed * t;
        const double y = 0.1 - 0.08 * std::sin(angle), z = 0.12 + 0.08 * std::cos(angle);
        const double vy = -0.08 * speed * std::cos(angle), vz = -0.08 * speed * std::sin(angle);
        const double x = std::sqrt(0.09 - y * y - z * z);
        const Sample& sample = sim.sample();
        EXPECT_NEAR(sample.state.q[7 * slider], x, 1e-11);
        EXPECT_NEAR(sample.state.u[6 * slider], -(y * vy + z * vz) / x, 1e-10);
        EXPECT_NEAR(sample.balance, 0, 1e-4);
    }
}

TEST(Drive, FreeAngleCountsTurnsToo) {
    // torque-free spin about the hinge: ten turns without a drive
    Model model = driven_arm(RampFunction{0.3, -9, 0});
    model.gravity.setZero();
    model.joints[0].drives.clear();
    Simulation sim(model, tolerance(1e-9));
    const Channels angle(sim.system(), {"hinge.angle"});
    for (const double t : {0.5, 3.0, 7.0}) {
        ASSERT_TRUE(sim.advance_to(t).ok);
        double value = 0;
        angle.read(sim.sample(), {&value, 1});
        EXPECT_NEAR(value, 0.3 - 9 * t, 1e-4);
    }
}

} // namespace
} // namespace gudgeon
