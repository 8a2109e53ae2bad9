// rk4 against closed forms, reference solutions and its own order.
#include "solvers/rk4.hpp"

#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_table.hpp"

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using namespace integrator_tools;
using testing_data::ReferenceTable;

TEST(Rk4, OscillatorFollowsItsClosedForm) {
    const System system = Oscillator::system();
    auto rk4 = started(make_rk4, system, 0.01);
    int samples = 0;
    const StepOutcome outcome = run(*rk4, 2, 0.0037, [&](const State& s) {
        EXPECT_NEAR(s.q[0], Oscillator::x(s.t), 2e-8);
        EXPECT_NEAR(s.u[0], Oscillator::v(s.t), 2e-7);
        EXPECT_NEAR(s.dissipated(), Oscillator::energy(0) - Oscillator::energy(s.t), 5e-8);
        EXPECT_EQ(s.input(), 0);
        ++samples;
    });
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_EQ(samples, 541);
}

TEST(Rk4, HasOrderFour) {
    const System system = ready("chain", {{"links", "4"}, {"thin", "1"}});
    const ReferenceTable reference("r5_chain_N4.csv");
    std::vector<double> errors;
    for (const double h : {4e-3, 2e-3, 1e-3}) {
        auto rk4 = started(make_rk4, system, h);
        ASSERT_TRUE(run(*rk4, 1).ok);
        const State& s = rk4->state();
        const Vec3 tip = s.q.segment<3>(21) + rotation(s.q.segment<4>(24)) * Vec3(0.5, 0, 0);
        errors.push_back(std::hypot(tip.x() - reference["tip_x"][100], tip.z() - reference["tip_z"][100]));
        EXPECT_EQ(rk4->statistics().steps, std::lround(1 / h));
    }
    EXPECT_LT(errors[0], 1e-6);
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), 4, 0.5);
    EXPECT_NEAR(std::log2(errors[1] / errors[2]), 4, 0.5);
}

TEST(Rk4, BaumgarteTermsKeepThePendulumOnItsCircle) {
    const System system = ready("pendulum");
    auto rk4 = started(make_rk4, system, 0.01);
    ASSERT_TRUE(run(*rk4, 10).ok);
    EXPECT_LT(rk4->statistics().constraint_position_max, 1e-9);
    EXPECT_LT(rk4->statistics().constraint_velocity_max, 1e-7);
    EXPECT_NEAR(rk4->state().q[0], PendulumAt10::x, 5e-7);
    EXPECT_NEAR(rk4->state().q[2], PendulumAt10::z, 5e-7);
}

TEST(Rk4, TakesOutAnInitialViolation) {
    const System system = ready("pendulum");
    State state = initial_state(system);
    state.q[0] -= 1e-6; // rod too long
    auto rk4 = make_rk4(system, {});
    rk4->start(state);
    ASSERT_TRUE(run(*rk4, 2e-3).ok);
    EXPECT_NEAR(rk4->state().q.head<3>().norm(), 1, 1e-10);
}

TEST(Rk4, HeavyTopAtSamples) {
    const System system = ready("heavy-top");
    const ReferenceTable reference("r7_slow_top_b.csv");
    auto rk4 = started(make_rk4, system, 3e-4); // the samples fall inside the steps
    std::size_t row = 0;
    ASSERT_TRUE(run(*rk4, 2, 0.01, [&](const State& s) {
                    const Vec4 p(reference["e0"][row], reference["e1"][row], reference["e2"][row],
                                 reference["e3"][row]);
                    EXPECT_LT((s.q.segment<4>(3) - p).norm(), 1e-6) << "t = " << s.t;
                    EXPECT_NEAR(s.q[0], reference["cx"][row], 1e-6);
                    EXPECT_NEAR(s.q.segment<4>(3).norm(), 1, 1e-14);
                    ++row;
                }).ok);
    EXPECT_GE(row, 200u);
}

TEST(Rk4, SliderCrankAndItsReactions) {
    const System system = ready("slider-crank");
    const ReferenceTable reference("r1_slider_crank_ideal.csv");
    auto rk4 = started(make_rk4, system, 1e-3);
    const double energy = mechanical_energy(system, rk4->state());
    const int first = system.joints[system.joint_index("B")].first_row;
    for (std::size_t row = 0; row < reference.rows() && reference["t"][row] <= 2; row += 10) {
        ASSERT_TRUE(run(*rk4, reference["t"][row]).ok);
        const State& s = rk4->state();
        EXPECT_EQ(s.t, reference["t"][row]);
        EXPECT_NEAR(s.q[14], reference["x"][row], 1e-6);
        // the constraints push with -G^T lambda: on the rod, b of joint B, with -lambda
        EXPECT_NEAR(-s.lambda[first], reference["FBx"][row], 1e-4);
        EXPECT_NEAR(-s.lambda[first + 1], reference["FBy"][row], 1e-4);
        EXPECT_NEAR(-s.lambda[first + 2], reference["FBz"][row], 1e-4);
    }
    EXPECT_NEAR(mechanical_energy(system, rk4->state()), energy, 1e-6);
}

TEST(Rk4, DriveAndTheEnergyItPutsIn) {
    const System system = driven_slider_crank();
    auto rk4 = started(make_rk4, system, 1e-3);
    const double energy = mechanical_energy(system, rk4->state());
    double largest = 0;
    const StepOutcome outcome = run(*rk4, 1, 0.0123, [&](const State& s) {
        EXPECT_NEAR(s.q[14], 0.2 + driven_slide(s.t), 1e-7);
        EXPECT_NEAR(mechanical_energy(system, s) - energy, s.input(), 2e-6);
        largest = std::max(largest, std::abs(s.input()));
    });
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_GT(largest, 0.01); // it does put something in
}

TEST(Rk4, StopsExactlyAndIsNotShakenByAShortStep) {
    const System system = ready("pendulum");
    auto rk4 = started(make_rk4, system, 0.01);
    for (const double stop : {0.123, 0.123 + 1e-9, 0.5}) {
        ASSERT_TRUE(run(*rk4, stop).ok);
        EXPECT_EQ(rk4->state().t, stop);
        EXPECT_LT(rk4->statistics().constraint_velocity_max, 1e-6);
    }
    EXPECT_NEAR(rk4->statistics().smallest_step, 1e-9, 1e-12);
    EXPECT_EQ(rk4->statistics().largest_step, 0.01);
    EXPECT_EQ(rk4->statistics().order_histogram[4], rk4->statistics().steps);
}

TEST(Rk4, LoadsFromOutsideActFromTheNextStep) {
    const System system = pushed_body([](const UserForceInput&, UserForceOutput&) {});
    State state = initial_state(system);
    auto rk4 = started(make_rk4, system, 0.1);
    ASSERT_TRUE(run(*rk4, 0.5).ok);
    rk4->workspace().external[0] = 3;
    ASSERT_TRUE(run(*rk4, 1.5).ok);
    EXPECT_NEAR(rk4->state().u[0], 3, 1e-12);
    EXPECT_NEAR(rk4->state().q[0], 1.5, 1e-12);
    EXPECT_NEAR(rk4->state().input(), 4.5, 1e-12);
}

TEST(Rk4, RepeatedConstraintsAreNoHindrance) {
    const System system = ready("four-bar");
    auto rk4 = started(make_rk4, system, 1e-3);
    const StepOutcome outcome = run(*rk4, 1);
    ASSERT_TRUE(outcome.ok) << outcome.message;
    // a'' = 12/10 g sin a from a = 0 and a' = 1: the crank's end is at (sin a, cos a)
    const double energy = 0.5 + 1.2 * 9.81, c = 2 * rk4->state().q[2], speed = 2 * rk4->state().u[2];
    EXPECT_NEAR(speed * speed / (1 - c * c), 2 * (energy - 1.2 * 9.81 * c), 1e-6);
}

TEST(Rk4, UnstableStepEndsWithTheBody) {
    const System system = pushed_body([](const UserForceInput& in, UserForceOutput& out) {
        out.wrench.force_b = -1e9 * in.b.r; // the weight sets it going
    });
    auto rk4 = started(make_rk4, system, 0.01);
    const StepOutcome outcome = run(*rk4, 100);
    EXPECT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.reason, StepReason::non_finite);
    EXPECT_NE(outcome.message.find("probe"), std::string::npos) << outcome.message;
    EXPECT_TRUE(rk4->state().q.allFinite());
}

TEST(Rk4, RefusesAStepThatIsNone) {
    const System system = ready("pendulum");
    for (const double step : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
        IntegratorOptions options;
        options.step = step;
        EXPECT_THROW(make_rk4(system, options), std::invalid_argument);
    }
}

} // namespace
} // namespace gudgeon
