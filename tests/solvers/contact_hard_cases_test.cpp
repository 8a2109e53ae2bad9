// Hard cases of single contacts: hardly any gap, speed or motion, much stiffness or speed, two at once. The
// bounds and their reasons stand beside each test; more: bench/hard_cases/contacts.cpp.
#include "contact/normal_law.hpp"
#include "tests/solvers/hard_case_tools.hpp"

namespace gudgeon {
namespace {

using namespace hard_cases;

class HardCase : public testing::TestWithParam<const char*> {
  protected:
    bool radau() const { return std::string(GetParam()) == "radau"; }
    HowToRun how(double tolerance, double end, double every = 0) const {
        return {GetParam(), tolerance, end, every, Onset::threshold, 1, 100000};
    }
};

INSTANTIATE_TEST_SUITE_P(By, HardCase, testing::Values("radau", "gear"),
                         [](const auto& info) { return std::string(info.param); });

constexpr double weight = 9.81, stiffness = 5e6;

struct Rest {
    long steps;          // after the last contact has begun
    double depth, early; // m, at 10 s and at 1 s
};

Rest rest(Model model, const HowToRun& how) {
    Rest out{};
    const HardRun run = simulate(std::move(model), how, [&out](const Sample& sample) {
        if (std::abs(sample.state.t - 1) < 1e-9)
            out.early = sample.contacts[0].penetration;
    });
    out.steps = run.steps_since_start;
    out.depth = run.last.contacts[0].penetration;
    EXPECT_NEAR(run.last.contacts[0].normal_force, weight, 1e-5 * weight);
    return out;
}

// Rest is where the elastic part carries the weight: to 1e-6 of the depth, and no creep of that size between
// 1 s and 10 s (as for a ball: bench/hard_cases/contacts.cpp).
TEST_P(HardCase, RestingJournalOnSteel) {
    Model model = build_mechanism("bouncing-journal", {{"law", "cylinder"}});
    model.bodies[0].position = {0, 0, -1e-3 + 1e-5}; // bounces some twenty times on its 24 nm
    const double n = Cylinder::exponent_of(1e-3);
    const double K = Cylinder::stiffness_of(composite_modulus(207e9, 0.3, 207e9, 0.3), 0.02, 1e-3);
    const double depth = std::pow(weight / K, 1 / n);
    const Rest found = rest(model, how(1e-6, 10, 0.1));
    EXPECT_LT(found.steps, 500);
    EXPECT_NEAR(found.depth, depth, 1e-6 * depth);
    EXPECT_NEAR(found.early, depth, 1e-6 * depth);
}

// The exception: the law's only resting place is W / (K e), reached ever slower.
TEST_P(HardCase, KelvinVoigtCreepsIn) {
    ContactLaw law = law_of("kelvin-voigt", 1e5, 0.1);
    law.speed = 0.1;
    const Rest found = rest(ball_above(law, 1e-5), how(1e-6, 10, 0.1));
    const double last = weight / (1e5 * 0.1);
    EXPECT_LT(found.steps, 1000);
    EXPECT_NEAR(found.depth, last, 1e-5 * last);
    EXPECT_LT(found.early, 0.9995 * last);
}

// One impact against its closed form. Scaled by depth and time it is the same for every stiffness: so are the
// errors (measured 1e-5 and 8e-4) and the steps.
TEST_P(HardCase, StiffnessFrom1e3To1e12) {
    const double chi = factor(0.75);
    for (double K = 1e3; K < 2e12; K *= 10) {
        SCOPED_TRACE(K);
        Model model = ball(law_of("lankarani-nikravesh", K, 0.75), 1e-3);
        model.bodies[0].velocity = {0.1, 0, 0};
        const double depth = impact_depth(chi, 1, 0.1, K);
        const HardRun run = simulate(model, how(1e-6, 0.01 + 3.4 * depth / 0.1));
        EXPECT_EQ(run.ends.size(), 1u);
        EXPECT_NEAR(-run.last.state.u[0] / (0.1 * speed_ratio(chi)), 1, radau() ? 1e-4 : 3e-3);
        EXPECT_NEAR(run.history[0].deepest / depth, 1, radau() ? 1e-4 : 1e-3);
        EXPECT_LT(run.statistics.steps, 150);
    }
}

TEST_P(HardCase, GapOfAMicrometre) {
    const double chi = factor(0.75), K = 1e10;
    Model model = ball(law_of("lankarani-nikravesh", K, 0.75), 1e-6);
    model.bodies[0].velocity = {0.01, 0, 0};
    const double depth = impact_depth(chi, 1, 0.01, K); // more than the gap
    const HardRun run = simulate(model, how(1e-9, 1e-4 + 3.4 * depth / 0.01));
    ASSERT_EQ(run.starts.size(), 1u);
    EXPECT_NEAR(run.starts[0].t, 1e-4, 1e-10);
    EXPECT_NEAR(run.starts[0].speed, 0.01, 1e-8);
    EXPECT_NEAR(-run.last.state.u[0] / (0.01 * speed_ratio(chi)), 1, radau() ? 1e-5 : 1e-4);
    EXPECT_NEAR(run.history[0].deepest / depth, 1, radau() ? 1e-4 : 1e-3);
    EXPECT_LT(run.statistics.steps, 200);
}

// 200 turns a second against stops after 5 turns and back at -3: flight and impact in closed form. The angle
// is counted right if the impact comes after 10 pi + 1 and not earlier.
TEST_P(HardCase, StopHitAt1257RadPerSecond) {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("rotor", 1, {1e-3, 1e-3, 1e-3}, Vec3::Zero())};
    model.bodies[0].angular_velocity = {1257, 0, 0};
    Joint joint = make_joint("R", JointKind::revolute, "ground", "rotor", Vec3::Zero(), Vec3::UnitX());
    Stop stop;
    stop.upper = 10 * pi + 1;
    stop.lower = -6 * pi - 2;
    stop.law = lankarani_nikravesh(1e6, 0.75);
    joint.stops["angle"] = stop;
    model.joints = {joint};
    const double ratio = speed_ratio(factor(0.75)), error = radau() ? 1e-7 : 1e-5;
    const HardRun run = simulate(model, how(1e-8, 0.1));
    ASSERT_EQ(run.starts.size(), 2u);
    EXPECT_NEAR(run.starts[0].t, *stop.upper / 1257, radau() ? 1e-11 : 1e-8);
    EXPECT_NEAR(run.starts[0].speed / 1257, 1, error);
    EXPECT_NEAR(run.starts[1].speed / (1257 * ratio), 1, error);
    EXPECT_NEAR(run.starts[1].t - run.ends[0].t, (*stop.upper - *stop.lower) / (1257 * ratio),
                radau() ? 1e-9 : 2e-7);
    EXPECT_NEAR(run.last.state.u[3] / (1257 * ratio * ratio), 1, error);
    EXPECT_NEAR(run.history[0].deepest_angle / impact_depth(factor(0.75), 1e-3, 1257, 1e6), 1, 1e-3);
    EXPECT_LT(run.statistics.steps, 1500);
}

// Slide and angle reach their stops at the same instant; the two impacts do not know of each other.
TEST_P(HardCase, TwoStopsOfAJointAtOnce) {
    for (const double side : {1.0, -1.0}) {
        Model model;
        model.gravity = Vec3::Zero();
        model.bodies = {make_body("body", 2, {1e-2, 1e-2, 1e-2}, Vec3::Zero())};
        model.bodies[0].velocity = {side, 0, 0};
        model.bodies[0].angular_velocity = {5 * side, 0, 0};
        Joint joint = make_joint("J", JointKind::cylindrical, "ground", "body", Vec3::Zero(), Vec3::UnitX());
        joint.stops["slide"].lower = -0.1;
        joint.stops["slide"].upper = 0.1;
        joint.stops["slide"].law = lankarani_nikravesh(1e6, 0.75);
        joint.stops["angle"].lower = -0.5;
        joint.stops["angle"].upper = 0.5;
        joint.stops["angle"].law = lankarani_nikravesh(1e3, 0.5);
        model.joints = {joint};
        const double error = radau() ? 1e-7 : 2e-5;
        const double slide = speed_ratio(factor(0.75)), turn = speed_ratio(factor(0.5));
        const HardRun run = simulate(model, how(1e-8, 0.6)); // to one side, then the other
        ASSERT_EQ(run.starts.size(), 4u);
        for (int i = 0; i < 4; ++i) {
            const ContactEvent& start = run.starts[i];
            const bool slides = i < 2 ? start.speed < 2 : i == 2;
            const double speed = slides ? 1 : 5, ratio = i < 2 ? 1 : slides ? slide : turn;
            EXPECT_NEAR(start.speed / (speed * ratio), 1, error);
            if (i < 2) {
                EXPECT_NEAR(start.t, 0.1, radau() ? 1e-10 : 1e-8);
            }
        }
        EXPECT_NE(run.starts[0].channel, run.starts[1].channel);
        EXPECT_NEAR(run.last.state.u[0] / (side * slide * slide), 1, error);
        EXPECT_NEAR(run.last.state.u[3] / (5 * side * turn * turn), 1, error);
    }
}

// Physics switched off: the step that brings the contact lands well inside it, and the energy lost (closed
// form without the 0.5 % of gravity) shows it; with physics the contact starts in the first tenth.
TEST(ContactOnset, SwitchedOffStartsTooDeep) {
    const double lost = 0.5 * 2 * weight * 1e-3 * (1 - std::pow(speed_ratio(factor(0.75)), 2));
    for (const double tolerance : {1e-3, 1e-4}) {
        SCOPED_TRACE(tolerance);
        const auto first_impact = [&](Onset onset) {
            return simulate(build_mechanism("bouncing-journal", {{"law", "cylinder"}}),
                            {"radau", tolerance, 0.02, 0, onset, 1, 1000});
        };
        const HardRun off = first_impact(Onset::ignored), on = first_impact(Onset::threshold);
        ASSERT_FALSE(off.starts.empty() || on.starts.empty());
        EXPECT_GT(off.starts[0].depth, 0.2 * off.history[0].deepest);
        EXPECT_LT(on.starts[0].depth, 0.1 * on.history[0].deepest);
        EXPECT_NEAR(on.last.state.dissipated() / lost, 1, 0.015);
        if (tolerance == 1e-3) {
            EXPECT_GT(std::abs(off.last.state.dissipated() / lost - 1), 0.02);
        }
    }
}

} // namespace
} // namespace gudgeon
