// The index-3 augmented Lagrangian with projections: order, exact motions, energy, contacts, what it refuses.
#include "solvers/bayo.hpp"

#include "tests/solvers/exact_motions.hpp"
#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_table.hpp"

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using namespace integrator_tools;
using testing_data::ReferenceTable;

/// Errors at halved steps fall by four.
void expect_order_two(const std::vector<double>& errors) {
    for (std::size_t i = 1; i < errors.size(); ++i)
        EXPECT_NEAR(std::log2(errors[i - 1] / errors[i]), 2, 0.15) << errors[i - 1] << " " << errors[i];
}

TEST(Bayo, PendulumHasOrderTwoInPositionsAndVelocities) {
    const System system = ready("pendulum");
    std::vector<double> positions, velocities;
    const test::PendulumTruth truth(2.5);
    for (const double h : {0.01, 0.005, 0.0025}) {
        auto bayo = started(make_bayo, system, h);
        ASSERT_TRUE(run(*bayo, 2.5).ok);
        const State& s = bayo->state();
        positions.push_back((s.q.head<3>() - truth.r).norm());
        velocities.push_back((s.u.head<3>() - truth.v).norm());
        EXPECT_LT(bayo->statistics().constraint_position_max, 1e-12);
        EXPECT_LT(bayo->statistics().constraint_velocity_max, 1e-12);
        EXPECT_EQ(bayo->statistics().klu_fallbacks, 0);
    }
    expect_order_two(positions);
    expect_order_two(velocities);
    EXPECT_LT(positions.back(), 1e-4);
}

TEST(Bayo, SliderCrankHasOrderTwo) {
    const System system = ready("slider-crank");
    const ReferenceTable reference("r1_slider_crank_ideal.csv");
    std::vector<double> errors;
    for (const double h : {2e-3, 1e-3, 5e-4}) {
        auto bayo = started(make_bayo, system, h);
        double largest = 0;
        for (std::size_t row = 1; row < reference.rows() && reference["t"][row] <= 0.5; ++row) {
            ASSERT_TRUE(run(*bayo, reference["t"][row]).ok);
            largest = std::max(largest, std::abs(bayo->state().q[14] - reference["x"][row]));
        }
        errors.push_back(largest);
        EXPECT_EQ(bayo->statistics().klu_fallbacks, 0);
    }
    expect_order_two(errors);
}

TEST(Bayo, ReactionsOfTheSliderCrank) {
    const System system = ready("slider-crank");
    const ReferenceTable reference("r1_slider_crank_ideal.csv");
    auto bayo = started(make_bayo, system, 2.5e-4);
    const int first = system.joints[system.joint_index("B")].first_row;
    for (std::size_t row = 10; row < reference.rows() && reference["t"][row] <= 0.4; row += 10) {
        ASSERT_TRUE(run(*bayo, reference["t"][row]).ok);
        const State& s = bayo->state();
        // the constraints push with -G^T lambda: on the rod, b of joint B, with -lambda
        EXPECT_NEAR(-s.lambda[first], reference["FBx"][row], 0.02) << s.t;
        EXPECT_NEAR(-s.lambda[first + 1], reference["FBy"][row], 0.02) << s.t;
        EXPECT_NEAR(-s.lambda[first + 2], reference["FBz"][row], 0.02) << s.t;
    }
}

TEST(Bayo, TurningBodiesHaveOrderTwo) {
    const System system = ready("heavy-top");
    const ReferenceTable reference("r7_slow_top_b.csv");
    const std::size_t row = reference.rows() / 2;
    std::vector<double> errors;
    for (const double h : {1e-3, 5e-4, 2.5e-4}) {
        auto bayo = started(make_bayo, system, h);
        ASSERT_TRUE(run(*bayo, reference["t"][row]).ok);
        const State& s = bayo->state();
        const Vec4 p(reference["e0"][row], reference["e1"][row], reference["e2"][row], reference["e3"][row]);
        errors.push_back((s.q.segment<4>(3) - p).norm());
        EXPECT_NEAR(s.q.segment<4>(3).norm(), 1, 1e-14);
    }
    expect_order_two(errors);
}

TEST(Bayo, EnergyOfAPendulumReturnsToOrderTwo) {
    const System system = ready("pendulum");
    std::vector<double> errors;
    for (const double h : {0.01, 0.005, 0.0025}) {
        auto bayo = started(make_bayo, system, h);
        const double energy = mechanical_energy(system, bayo->state());
        double largest = 0;
        ASSERT_TRUE(run(*bayo, 10, 0.05, [&](const State& s) {
                        largest = std::max(largest, std::abs(mechanical_energy(system, s) - energy));
                    }).ok);
        errors.push_back(largest);
    }
    expect_order_two(errors);
    EXPECT_LT(errors.back(), 1e-3);
}

TEST(Bayo, OscillatorFollowsItsClosedForm) {
    const System system = Oscillator::system();
    auto bayo = started(make_bayo, system, 1e-3);
    ASSERT_TRUE(run(*bayo, 2, 0.0137, [&](const State& s) {
                    EXPECT_NEAR(s.q[0], Oscillator::x(s.t), 2e-6);
                    EXPECT_NEAR(s.u[0], Oscillator::v(s.t), 1e-5);
                    EXPECT_NEAR(s.dissipated(), Oscillator::energy(0) - Oscillator::energy(s.t), 2e-5);
                }).ok);
}

TEST(Bayo, DriveAndTheEnergyItPutsIn) {
    const System system = driven_slider_crank();
    auto bayo = started(make_bayo, system, 5e-4);
    const double energy = mechanical_energy(system, bayo->state());
    double largest = 0;
    const StepOutcome outcome = run(*bayo, 0.5, 0.0123, [&](const State& s) {
        EXPECT_NEAR(s.q[14], 0.2 + driven_slide(s.t), 1e-7);
        EXPECT_NEAR(mechanical_energy(system, s) - energy, s.input(), 2e-3);
        largest = std::max(largest, std::abs(s.input()));
    });
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_GT(largest, 0.01);
}

// Two equal rods side by side hold the same point: their rows repeat each other, which KLU refuses.
TEST(Bayo, RepeatedRowsShareTheirReaction) {
    Model model = build_mechanism("pendulum");
    for (const Joint& joint : std::vector<Joint>(model.joints))
        if (joint.name == "rod") {
            Joint twin = joint;
            twin.name = "twin";
            model.joints.push_back(twin);
        }
    const System system = compile(std::move(model), standard_force_builders());
    auto bayo = started(make_bayo, system, 0.0025);
    const StepOutcome outcome = run(*bayo, 2.5);
    ASSERT_TRUE(outcome.ok) << outcome.message;
    const State& s = bayo->state();
    EXPECT_LT((s.q.head<3>() - test::PendulumTruth(2.5).r).norm(), 1e-4);
    EXPECT_EQ(bayo->statistics().klu_fallbacks, 0);
    const double rod = s.lambda[system.joints[system.joint_index("rod")].first_row];
    const double twin = s.lambda[system.joints[system.joint_index("twin")].first_row];
    EXPECT_GT(std::abs(rod), 1);
    EXPECT_NEAR(rod, twin, 1e-10 * std::abs(rod));
}

// One parallelogram in space repeats three rows: a'' = g (9 N + 3) / (8 N + 2) sin a for N loops, a from the
// vertical; 1 rad/s at a = 0.
TEST(Bayo, FourBarKeepsToItsExactMotion) {
    const System system = ready("four-bar");
    const double end = 1, factor = 9.81 * 12 / 10;
    const auto exact = [&] {
        double a = 0, w = 1;
        const int steps = 20000;
        const double h = end / steps;
        for (int i = 0; i < steps; ++i) { // classic Runge-Kutta, far below the error looked for
            const double k1 = factor * std::sin(a), k2 = factor * std::sin(a + 0.5 * h * w);
            const double k3 = factor * std::sin(a + 0.5 * h * (w + 0.5 * h * k1));
            const double k4 = factor * std::sin(a + h * (w + 0.5 * h * k2));
            a += h * w + h * h / 6 * (k1 + k2 + k3);
            w += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        }
        return a;
    }();
    std::vector<double> errors;
    for (const double h : {4e-3, 2e-3, 1e-3}) {
        auto bayo = started(make_bayo, system, h);
        const StepOutcome outcome = run(*bayo, end);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const int crank = system.body_index("crank0");
        const Vec3 centre = bayo->state().q.segment<3>(7 * crank);
        errors.push_back((centre - 0.5 * Vec3(std::sin(exact), 0, std::cos(exact))).norm());
        EXPECT_EQ(bayo->statistics().klu_fallbacks, 0);
    }
    expect_order_two(errors);
}

TEST(Bayo, ContactsBeginDeepAndAreCounted) {
    const System system = ready("bouncing-journal");
    auto coarse = started(make_bayo, system, 1e-3);
    ASSERT_TRUE(run(*coarse, 0.05).ok);
    EXPECT_GT(coarse->statistics().deep_starts, 0);
    auto bayo = started(make_bayo, system, 1e-4);
    const StepOutcome outcome = run(*bayo, 0.2);
    ASSERT_TRUE(outcome.ok) << outcome.message;
    // falls 1 mm in 14 ms and loses energy at each impact
    const State& s = bayo->state();
    EXPECT_GT(s.history[0].impacts, 2);
    EXPECT_GT(s.dissipated(), 0);
    EXPECT_NEAR(mechanical_energy(system, s) + s.dissipated(), 0, 1e-3);
}

TEST(Bayo, StopsExactlyAndRefusesBadSteps) {
    const System system = ready("pendulum");
    auto bayo = started(make_bayo, system, 0.01);
    for (const double stop : {0.123, 0.123 + 1e-6, 0.5}) {
        ASSERT_TRUE(run(*bayo, stop).ok);
        EXPECT_EQ(bayo->state().t, stop);
    }
    EXPECT_EQ(bayo->statistics().order_histogram[2], bayo->statistics().steps);
    EXPECT_EQ(bayo->statistics().largest_step, 0.01);
    for (const double step : {-1.0, std::numeric_limits<double>::infinity()}) {
        IntegratorOptions options;
        options.step = step;
        EXPECT_THROW(make_bayo(system, options), std::invalid_argument);
    }
}

TEST(Bayo, LoadsFromOutsideActFromTheNextStep) {
    const System system = pushed_body([](const UserForceInput&, UserForceOutput&) {});
    auto bayo = started(make_bayo, system, 0.1);
    ASSERT_TRUE(run(*bayo, 0.5).ok);
    bayo->workspace().external[0] = 3;
    ASSERT_TRUE(run(*bayo, 1.5).ok);
    EXPECT_NEAR(bayo->state().u[0], 3, 1e-12);
    EXPECT_NEAR(bayo->state().q[0], 1.5, 1e-12);
    EXPECT_NEAR(bayo->state().input(), 4.5, 1e-12);
}

TEST(Bayo, ForcesThatAreNoNumbersEndTheRun) {
    const System system = pushed_body([](const UserForceInput& in, UserForceOutput& out) {
        if (in.t > 0.25)
            out.wrench.force_b.x() = std::nan("");
    });
    auto bayo = started(make_bayo, system, 0.1);
    const StepOutcome outcome = run(*bayo, 1);
    EXPECT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.reason, StepReason::non_finite);
    EXPECT_NEAR(bayo->state().t, 0.2, 1e-12);
}

} // namespace
} // namespace gudgeon
