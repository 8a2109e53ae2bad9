// ida: its residual and Jacobian, and its solutions against closed forms and reference solutions.
#include "solvers/ida.hpp"

#include "solvers/ida_equations.hpp"
#include "solvers/index1_equations.hpp"
#include "solvers/power_integral.hpp"
#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_table.hpp"

#include <random>
#include <stdexcept>
#include <thread>

namespace gudgeon {
namespace {

using namespace integrator_tools;
using testing_data::ReferenceTable;

std::unique_ptr<Integrator> started(const System& system, double tolerance) {
    IntegratorOptions options;
    options.rtol = options.atol = tolerance;
    auto integrator = make_ida(system, options);
    integrator->start(initial_state(system));
    return integrator;
}

/// dF/dy + cj dF/dy' column by column against central differences, at a point off every constraint.
void expect_exact_jacobian(const System& system) {
    IdaEquations equations(system);
    const int n = equations.size();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> number(-1, 1);
    VecX y = VecX::Zero(n), ydot(n), plus(n), minus(n);
    equations.pack(initial_state(system), y.data());
    for (int i = 0; i < n; ++i) {
        ydot[i] = number(random);
        if (i < equations.u0())
            y[i] += 0.02 * number(random); // Euler parameters lose their unit length
        else if (i < equations.mu0())
            y[i] += 2 * number(random);
        else if (i >= equations.nu0())
            y[i] = 0.3 * number(random);
    }
    const double cj = 17, t = 0.3;
    std::vector<double> values(equations.pattern().nonzeros());
    equations.jacobian(t, cj, y.data(), values);
    const CscPattern& pattern = equations.pattern();
    for (int j = 0; j < n; ++j) {
        const int first = system.reaction_friction ? equations.mu0() : equations.lambda0();
        const bool linear = j >= first && j < equations.nu0();
        const double h = linear ? 1.0 : 1e-6;
        const auto shifted = [&](double step, VecX& out) {
            VecX x = y, rate = ydot;
            x[j] += step;
            rate[j] += cj * step;
            ASSERT_TRUE(equations.residual(t, x.data(), rate.data(), out.data()));
        };
        shifted(h, plus);
        shifted(-h, minus);
        const VecX expected = (plus - minus) / (2 * h);
        VecX column = VecX::Zero(n);
        for (int i = pattern.col_start[j]; i < pattern.col_start[j + 1]; ++i)
            column[pattern.row[i]] = values[i];
        const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
        const double rounding = 1e-15 * plus.cwiseAbs().maxCoeff() / h;
        EXPECT_LT((column - expected).cwiseAbs().maxCoeff(), 2e-7 * scale + rounding)
            << "column " << j << ", " << equations.name_of(j);
    }
}

TEST(IdaEquations, JacobianOfPerfectJoints) { expect_exact_jacobian(ready("slider-crank")); }
TEST(IdaEquations, JacobianOfADrivenJoint) { expect_exact_jacobian(driven_slider_crank()); }
TEST(IdaEquations, JacobianOfDistanceAndPlanarJoints) { expect_exact_jacobian(ready("pendulum")); }
TEST(IdaEquations, JacobianOfBushingsAndSprings) {
    expect_exact_jacobian(ready("suspension-chain", {{"units", "2"}}));
}

TEST(IdaEquations, JacobianOfFrictionByReactions) {
    Model model = build_mechanism("slider-crank");
    Friction rubbing;
    rubbing.kinetic = 0.4;
    rubbing.speed = 5;
    for (Joint& joint : model.joints)
        if (joint.name == "D")
            joint.friction = {rubbing};
    expect_exact_jacobian(compile(std::move(model), standard_force_builders()));
}

TEST(IdaEquations, ResidualVanishesAtAConsistentStart) {
    const System system = driven_slider_crank();
    IdaEquations equations(system);
    Index1Equations accelerations(system);
    Workspace ws = make_workspace(system);
    State state = initial_state(system);
    set_motion(system, state.q, state.u, ws);
    VecX du(system.velocities());
    ASSERT_TRUE(accelerations.solve(0, ws, nullptr, du, state.lambda).ok());
    EXPECT_GT(du.norm(), 1);
    VecX y(equations.size()), ydot(equations.size()), f(equations.size());
    equations.pack(state, y.data());
    equations.pack_rates(0, y.data(), du, ydot.data());
    ASSERT_TRUE(equations.residual(0, y.data(), ydot.data(), f.data()));
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-13);
}

TEST(IdaEquations, DriftTermMovesAlongTheConstraintGradient) {
    // one rod, vertical: mu on "displacement along x" of the joint O moves position and orientation
    const System system = ready("heavy-top", {{"tilt", "0"}, {"spin", "0"}});
    IdaEquations equations(system);
    VecX y(equations.size()), ydot = VecX::Zero(equations.size()), f(equations.size());
    equations.pack(initial_state(system), y.data());
    y[equations.mu0()] = 1;
    ASSERT_TRUE(equations.residual(0, y.data(), ydot.data(), f.data()));
    // Phi = position of the foot: G = (1, d x/d theta_y = -l) for the foot at -l z, m = 1, I = 0.02
    EXPECT_NEAR(f[0], 1, 1e-15);
    EXPECT_NEAR(f[5], 0.5 * -0.3 / 0.02, 1e-13); // e2 = sin(theta_y / 2)
    EXPECT_NEAR(f[3], 0, 1e-15);
}

TEST(PowerIntegral, ExactForPolynomials) {
    PowerIntegral integral;
    integral.restart(VecX::Constant(1, 2.0));
    const double h = 0.3;
    std::array<VecX, PowerIntegral::points> p;
    const auto fill = [&](int degree) {
        for (int i = 0; i < PowerIntegral::points; ++i)
            p[i] = VecX::Constant(1, std::pow(PowerIntegral::node[i], degree));
    };
    fill(4);
    integral.step(h, p);
    EXPECT_NEAR(integral.at(0)[0], 2, 1e-15);
    EXPECT_NEAR(integral.at(0.37)[0], 2 + h * std::pow(0.37, 5) / 5, 1e-15);
    EXPECT_NEAR(integral.end()[0], 2 + h / 5, 1e-15);
    fill(7); // the order of the quadrature is 8
    integral.step(h, p);
    EXPECT_NEAR(integral.end()[0], 2 + h / 5 + h / 8, 1e-15);
}

TEST(Ida, OscillatorFollowsItsClosedForm) {
    const System system = Oscillator::system();
    auto ida = started(system, 1e-9);
    int samples = 0;
    const StepOutcome outcome = run(*ida, 2, 0.0037, [&](const State& s) {
        EXPECT_NEAR(s.q[0], Oscillator::x(s.t), 1e-6);
        EXPECT_NEAR(s.u[0], Oscillator::v(s.t), 1e-6);
        EXPECT_NEAR(s.dissipated(), Oscillator::energy(0) - Oscillator::energy(s.t), 1e-6);
        EXPECT_EQ(s.input(), 0);
        ++samples;
    });
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_EQ(samples, 541);
}

TEST(Ida, ErrorFallsWithTheTolerance) {
    const System system = ready("chain", {{"links", "4"}, {"thin", "1"}});
    const ReferenceTable reference("r5_chain_N4.csv");
    double last = 1;
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
        auto ida = started(system, tolerance);
        const StepOutcome outcome = run(*ida, 1);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const State& s = ida->state();
        const Vec3 tip = s.q.segment<3>(21) + rotation(s.q.segment<4>(24)) * Vec3(0.5, 0, 0);
        const double error = std::hypot(tip.x() - reference["tip_x"][100], tip.z() - reference["tip_z"][100]);
        EXPECT_LT(error, 200 * tolerance + 1e-11);
        EXPECT_LT(error, 0.2 * last);
        EXPECT_LT(ida->statistics().constraint_position_max, 10 * tolerance);
        last = error;
    }
}

TEST(Ida, HeavyTopAtSamples) {
    const System system = ready("heavy-top");
    const ReferenceTable reference("r7_slow_top_b.csv");
    auto ida = started(system, 1e-10);
    std::size_t row = 0;
    ASSERT_TRUE(run(*ida, 2, 0.01, [&](const State& s) {
                    const Vec4 p(reference["e0"][row], reference["e1"][row], reference["e2"][row],
                                 reference["e3"][row]);
                    EXPECT_LT((s.q.segment<4>(3) - p).norm(), 1e-6) << "t = " << s.t;
                    EXPECT_NEAR(s.q[0], reference["cx"][row], 1e-6);
                    EXPECT_NEAR(s.q.segment<4>(3).norm(), 1, 1e-14);
                    ++row;
                }).ok);
    EXPECT_GE(row, 200u);
    EXPECT_EQ(ida->statistics().order_histogram[0], 0);
    EXPECT_GT(ida->statistics().order_histogram[5], ida->statistics().steps / 2);
}

TEST(Ida, SliderCrankAndItsReactions) {
    const System system = ready("slider-crank");
    const ReferenceTable reference("r1_slider_crank_ideal.csv");
    auto ida = started(system, 1e-9);
    const int first = system.joints[system.joint_index("B")].first_row;
    for (std::size_t row = 10; row < reference.rows() && reference["t"][row] <= 2; row += 10) {
        ASSERT_TRUE(run(*ida, reference["t"][row]).ok);
        const State& s = ida->state();
        EXPECT_EQ(s.t, reference["t"][row]);
        EXPECT_NEAR(s.q[14], reference["x"][row], 1e-5);
        EXPECT_NEAR(-s.lambda[first], reference["FBx"][row], 1e-2);
        EXPECT_NEAR(-s.lambda[first + 2], reference["FBz"][row], 1e-2);
    }
}

TEST(Ida, SuspensionChain) {
    const System system = ready("suspension-chain");
    const ReferenceTable reference("suspension_chain_N1.csv");
    auto ida = started(system, 1e-7);
    const int chassis = 7 * system.body_index("chassis0") + 2;
    std::size_t row = 0;
    const StepOutcome outcome = run(*ida, 5, 0.05, [&](const State& s) {
        EXPECT_NEAR(s.q[chassis], reference["chassis0.z"][row], 1e-6) << "t = " << s.t;
        ++row;
    });
    ASSERT_TRUE(outcome.ok) << outcome.message;
    EXPECT_GE(row, 99u);
}

TEST(Ida, DriveAndTheEnergyItPutsIn) {
    const System system = driven_slider_crank();
    auto ida = started(system, 1e-8);
    const double energy = mechanical_energy(system, ida->state());
    double largest = 0;
    const StepOutcome outcome = run(*ida, 1, 0.0123, [&](const State& s) {
        EXPECT_NEAR(s.q[14], 0.2 + driven_slide(s.t), 1e-6);
        EXPECT_NEAR(mechanical_energy(system, s) - energy, s.input(), 1e-5);
        largest = std::max(largest, std::abs(s.input()));
    });
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_GT(largest, 0.01);
}

TEST(Ida, EveryAttemptIsTold) {
    const System system = ready("slider-crank");
    auto ida = make_ida(system, {});
    long accepted = 0, by_error = 0, by_newton = 0;
    double last = 0;
    ida->on_step = [&](const StepRecord& record) {
        if (record.reason == StepReason::none) {
            ++accepted;
            EXPECT_NEAR(record.t - record.h, last, 1e-12);
            EXPECT_GT(record.error, 0);
            last = record.t;
        } else {
            ++(record.reason == StepReason::error_test ? by_error : by_newton);
            EXPECT_GT(record.t, last);
        }
    };
    ida->start(initial_state(system));
    ASSERT_TRUE(run(*ida, 2).ok);
    const Statistics& s = ida->statistics();
    EXPECT_EQ(accepted, s.steps);
    EXPECT_EQ(by_error, s.rejected_error);
    EXPECT_EQ(by_newton, s.rejected_newton);
    EXPECT_GT(by_error, 0);
    EXPECT_GT(s.newton_sweeps, s.steps);
    EXPECT_GT(s.factorisations, 0);
    EXPECT_GT(s.refactorisations, 0);
    EXPECT_GT(s.nnz_factors, s.nnz_matrix / 2);
}

TEST(Ida, StartsAgainAtAJump) {
    const System system = pushed_body([](const UserForceInput&, UserForceOutput&) {});
    auto ida = started(system, 1e-9);
    ASSERT_TRUE(run(*ida, 0.5).ok);
    EXPECT_EQ(ida->state().t, 0.5);
    const long steps = ida->statistics().steps;
    ida->workspace().external[0] = 3;
    ida->start(State(ida->state()));
    ASSERT_TRUE(run(*ida, 1.5).ok);
    EXPECT_GT(ida->statistics().steps, steps);
    EXPECT_NEAR(ida->state().u[0], 3, 1e-7);
    EXPECT_NEAR(ida->state().q[0], 1.5, 1e-7);
    EXPECT_NEAR(ida->state().input(), 4.5, 1e-6);
}

TEST(Ida, LargestStepAndLargestOrderAreKept) {
    const System system = ready("pendulum");
    IntegratorOptions options;
    options.step = 2e-3;
    options.max_order = 2;
    auto ida = make_ida(system, options);
    ida->start(initial_state(system));
    ASSERT_TRUE(run(*ida, 1).ok);
    EXPECT_LE(ida->statistics().largest_step, 2e-3 * (1 + 1e-12));
    EXPECT_GE(ida->statistics().steps, 500);
    for (int order = 3; order < 9; ++order)
        EXPECT_EQ(ida->statistics().order_histogram[order], 0);
}

TEST(Ida, RepeatedConstraintsAreNamed) {
    const System system = ready("four-bar");
    auto ida = started(system, 1e-6);
    const StepOutcome outcome = ida->advance(1);
    EXPECT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.reason, StepReason::singular);
    EXPECT_NE(outcome.message.find("joint "), std::string::npos) << outcome.message;
}

TEST(Ida, ForcesThatAreNoNumbersEndTheRunAndPrintNothing) {
    const System system = pushed_body([](const UserForceInput& in, UserForceOutput& out) {
        out.wrench.force_b = {0, 0, 1 / std::sqrt(0.1 + in.b.r.z())}; // the body falls
    });
    auto ida = started(system, 1e-6);
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const StepOutcome outcome = run(*ida, 1);
    EXPECT_EQ(testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout(), "");
    EXPECT_FALSE(outcome.ok);
    EXPECT_NE(outcome.message.find("probe"), std::string::npos) << outcome.message;
    EXPECT_TRUE(ida->state().q.allFinite());
    EXPECT_GT(ida->state().t, 0.1);
}

TEST(Ida, AForceLawThatThrowsEndsTheRun) {
    const System system = pushed_body([](const UserForceInput& in, UserForceOutput&) {
        if (in.t > 0.1)
            throw std::runtime_error("no such law beyond 0.1 s");
    });
    auto ida = started(system, 1e-6);
    const StepOutcome outcome = run(*ida, 1);
    EXPECT_FALSE(outcome.ok);
    EXPECT_NE(outcome.message.find("no such law beyond 0.1 s"), std::string::npos) << outcome.message;
}

TEST(Ida, RefusesOptionsThatMakeNoSense) {
    const System system = ready("pendulum");
    IntegratorOptions options;
    options.atol = 0;
    EXPECT_THROW(make_ida(system, options), std::invalid_argument);
    options = {};
    options.step = -1;
    EXPECT_THROW(make_ida(system, options), std::invalid_argument);
}

TEST(Ida, TwoSystemsInTwoThreads) {
    const System systems[2] = {ready("slider-crank"), ready("chain", {{"links", "4"}})};
    VecX alone[2], together[2];
    const auto solve = [&](int i, VecX& out) {
        auto ida = started(systems[i], 1e-6);
        EXPECT_TRUE(run(*ida, 0.5).ok);
        out = ida->state().q;
    };
    for (int i = 0; i < 2; ++i)
        solve(i, alone[i]);
    std::thread other([&] { solve(1, together[1]); });
    solve(0, together[0]);
    other.join();
    for (int i = 0; i < 2; ++i)
        EXPECT_TRUE(alone[i] == together[i]);
}

} // namespace
} // namespace gudgeon
