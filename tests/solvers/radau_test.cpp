// Radau IIA: orders of positions, velocities and multipliers, dense output, control of the step.
#include "contact/standard_forces.hpp"
#include "solvers/consistent.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/exact_motions.hpp"
#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_table.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace gudgeon {
namespace {

using namespace test;
using integrator_tools::Oscillator;
using testing_data::ReferenceTable;

SimulationOptions tolerance(double tol) {
    SimulationOptions options;
    options.integrator = "radau";
    options.integration.rtol = options.integration.atol = tol;
    return options;
}

struct Measured {
    double position = 0, velocity = 0, multiplier = 0;
};

/// Steps of h, cut only at the stops. The tolerance goes with h^4, as the error estimate does, so that the
/// largest step is always taken and the sweeps are as exact as the step.
template <class Truth>
Measured fixed_steps(const System& system, double h, const std::vector<double>& stops, double estimate,
                     const Truth& truth, Formulation formulation = Formulation::saddle_point) {
    IntegratorOptions options;
    options.formulation = formulation;
    options.step = h;
    options.rtol = options.atol = estimate * std::pow(h, 4);
    const auto radau = make_integrator("radau", system, options);
    radau->start(initial_state(system));
    ConsistentSolver consistent(system);
    Workspace ws = make_workspace(system);
    VecX acceleration, lambda;
    Measured worst;
    long shorter = 0;
    radau->on_step = [&](const StepRecord& r) {
        shorter += r.reason != StepReason::none || r.h < h * (1 - 1e-9);
        EXPECT_LE(r.h, h * (1 + 1e-9));
    };
    for (std::size_t next = 0; next < stops.size();) {
        const StepOutcome outcome = radau->advance(stops[next]);
        EXPECT_TRUE(outcome.ok) << outcome.message;
        if (!outcome.ok)
            break;
        const State& s = radau->state();
        next += s.t == stops[next];
        truth(s, worst);
        // multipliers that belong to the positions and velocities reached: these are of order 5
        ws.angles = s.angles;
        set_motion(system, s.q, s.u, ws);
        EXPECT_TRUE(consistent.accelerations(s.t, s.q, s.u, ws, acceleration, lambda));
        if (radau->statistics().steps > shorter + 1)
            worst.multiplier = std::max(worst.multiplier, (s.lambda - lambda).norm());
    }
    EXPECT_LE(shorter, 5 + stops.size() + 0.05 * stops.back() / h); // also at the start
    return worst;
}

void compare(const Vec3& r, const Vec3& v, const State& s, Measured& worst) {
    worst.position = std::max(worst.position, (s.q.head<3>() - r).norm());
    worst.velocity = std::max(worst.velocity, (s.u.head<3>() - v).norm());
}

/// Least squares slopes of log error over log h.
double slope(const std::vector<double>& h, const std::vector<Measured>& runs, double Measured::*error) {
    double x = 0, y = 0, xx = 0, xy = 0;
    for (std::size_t i = 0; i < h.size(); ++i) {
        const double a = std::log(h[i]), b = std::log(runs[i].*error);
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    const auto n = static_cast<double>(h.size());
    return (n * xy - x * y) / (n * xx - x * x);
}

void expect_orders(const std::vector<double>& h, const std::vector<Measured>& runs) {
    EXPECT_GT(slope(h, runs, &Measured::position), 4.7);
    EXPECT_GT(slope(h, runs, &Measured::velocity), 4.7);
    EXPECT_GT(slope(h, runs, &Measured::multiplier), 2.7);
}

const auto formulations = testing::Values(Formulation::saddle_point, Formulation::tree);
class RadauOrderIn : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(Coordinates, RadauOrderIn, formulations);

TEST_P(RadauOrderIn, Pendulum) {
    const System system = compiled("pendulum");
    const std::vector<double> steps{0.05, 0.025, 0.0125, 0.00625};
    std::vector<Measured> runs;
    for (const double h : steps)
        runs.push_back(fixed_steps(
            system, h, {1.5}, 20,
            [](const State& s, Measured& worst) {
                const PendulumTruth truth(s.t);
                compare(truth.r, truth.v, s, worst);
            },
            GetParam()));
    expect_orders(steps, runs);
}

/// The row of a table at a time, or its size.
std::size_t row_at(const ReferenceTable& table, double t) {
    const std::vector<double>& times = table["t"];
    return static_cast<std::size_t>(std::find(times.begin(), times.end(), t) - times.begin());
}

std::vector<double> times_of(const ReferenceTable& table, const std::vector<std::size_t>& rows) {
    std::vector<double> out;
    for (const std::size_t i : rows)
        out.push_back(table["t"][i]);
    return out;
}

TEST_P(RadauOrderIn, HeavyTop) {
    const System system = compiled("heavy-top");
    const ReferenceTable exact("r7_slow_top_b.csv");
    const std::vector<double> stops = times_of(exact, {15, 20, 25, 30, 50, 60}); // the tilt's rate is plain
    const std::vector<double> steps{0.005, 0.0025, 0.00125};
    std::vector<Measured> runs;
    for (const double h : steps)
        runs.push_back(fixed_steps(
            system, h, stops, 3e5,
            [&](const State& s, Measured& worst) {
                const std::size_t i = row_at(exact, s.t);
                if (std::find(stops.begin(), stops.end(), s.t) == stops.end())
                    return;
                const bool falling = exact["theta"][i + 1] > exact["theta"][i - 1];
                compare({exact["cx"][i], exact["cy"][i], exact["cz"][i]},
                        top_velocity(exact["azimuth"][i], exact["theta"][i], falling), s, worst);
            },
            GetParam()));
    expect_orders(steps, runs);
}

TEST_P(RadauOrderIn, SliderCrank) {
    const System system = compiled("slider-crank");
    const ReferenceTable exact("r1_slider_crank_ideal.csv");
    const Eigen::Index slider = system.body_index("slider");
    const std::vector<double> stops = times_of(exact, {5, 10, 15, 20}); // before the dead centre
    const std::vector<double> steps{0.01, 0.005, 0.0025, 0.00125};
    std::vector<Measured> runs;
    for (const double h : steps)
        runs.push_back(fixed_steps(
            system, h, stops, 300,
            [&](const State& s, Measured& worst) {
                const std::size_t i = row_at(exact, s.t);
                if (i == exact.rows())
                    return;
                worst.position = std::max(worst.position, std::abs(s.q[7 * slider] - exact["x"][i]));
                worst.velocity = std::max(worst.velocity, std::abs(s.u[6 * slider] - exact["xd"][i]));
            },
            GetParam()));
    expect_orders(steps, runs);
}

// The drive leaves nothing free: positions and velocities follow from the constraints alone.
TEST(RadauOrder, DrivenSliderCrank) {
    const System system = integrator_tools::driven_slider_crank();
    const Eigen::Index slider = system.body_index("slider");
    const std::vector<double> steps{0.01, 0.005, 0.0025};
    std::vector<Measured> runs;
    for (const double h : steps)
        runs.push_back(fixed_steps(system, h, {0.5}, 1e5, [&](const State& s, Measured& worst) {
            const double x = 0.2 + integrator_tools::driven_slide(s.t);
            worst.position = std::max(worst.position, std::abs(s.q[7 * slider] - x));
            worst.velocity =
                std::max(worst.velocity, std::abs(s.u[6 * slider] - 0.24 * std::cos(8 * pi * s.t)));
        }));
    for (const Measured& run : runs) {
        EXPECT_LT(run.position, 1e-10);
        EXPECT_LT(run.velocity, 1e-10);
    }
    EXPECT_GT(slope(steps, runs, &Measured::multiplier), 2.7);
}

TEST(Radau, DenseOutputHasTheOrderOfTheStages) {
    const System system = Oscillator::system();
    const std::vector<double> steps{0.08, 0.04, 0.02};
    std::vector<Measured> runs;
    for (const double h : steps) {
        Measured worst;
        IntegratorOptions options;
        options.step = h;
        options.rtol = options.atol = 30 * std::pow(h, 4);
        const auto radau = make_integrator("radau", system, options);
        radau->start(initial_state(system));
        State at = radau->state();
        while (radau->state().t < 1) {
            const double from = radau->state().t;
            ASSERT_TRUE(radau->advance(1).ok);
            const double to = radau->state().t;
            for (const double share : {0.0, 0.1, 0.3, 0.5, 0.8, 1.0}) {
                const double t = from + share * (to - from);
                radau->interpolate(t, at);
                EXPECT_EQ(at.t, t);
                worst.position = std::max(worst.position, std::abs(at.q[0] - Oscillator::x(t)));
                worst.velocity = std::max(worst.velocity, std::abs(at.u[0] - Oscillator::v(t)));
                const double lost = Oscillator::energy(0) - Oscillator::energy(t);
                worst.multiplier = std::max(worst.multiplier, std::abs(at.dissipated() - lost));
            }
            EXPECT_LT((at.q - radau->state().q).norm() + (at.u - radau->state().u).norm(), 1e-13);
            EXPECT_NEAR(at.dissipated(), radau->state().dissipated(), 1e-14);
        }
        runs.push_back(worst);
    }
    EXPECT_GT(slope(steps, runs, &Measured::position), 3.7);
    EXPECT_GT(slope(steps, runs, &Measured::velocity), 3.7);
    EXPECT_GT(slope(steps, runs, &Measured::multiplier), 2.7); // dissipated energy
    EXPECT_LT(runs.back().velocity, 1e-6);
}

TEST(Radau, StiffDampedModeIsFollowedWithLongSteps) {
    // a mode at 1e4 rad/s, ratio 0.1, pushed slowly; it starts on the slow motion
    Model model;
    model.gravity.setZero();
    Body body;
    body.name = "mass";
    body.mass = 1;
    body.inertia = Mat3::Identity();
    body.position = {-2e-7, 0, 0};
    body.velocity = {0.01, 0, 0};
    model.bodies = {body};
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "mass"};
    spring.points = {Vec3(-1, 0, 0), body.position};
    spring.stiffness = 1e8;
    spring.damping = 2e3;
    spring.free_length = 1;
    model.forces = {spring};
    SimulationOptions options = tolerance(1e-6);
    options.user_forces = {{"load", {"ground", "mass"}, [](const UserForceInput& in, UserForceOutput& out) {
                                out.wrench.force_b.x() = 1e6 * std::sin(in.t);
                            }}};
    Simulation sim(model, options);
    ASSERT_TRUE(sim.advance_to(10).ok);
    EXPECT_NEAR(sim.state().q[0], 0.01 * (std::sin(10) - 2e-5 * std::cos(10)), 1e-8);
    EXPECT_NEAR(sim.state().u[0], 0.01 * std::cos(10), 1e-5);
    // the estimate must not follow the stiff mode: 1e5 rad of it in a few dozen steps
    EXPECT_LT(sim.statistics().steps, 100);
    EXPECT_LT(sim.statistics().rejected_error, 30);
}

TEST(Radau, ShortIntervalsChangeLittleAndCostLittle) {
    const double tol = 1e-6;
    Simulation once(build_mechanism("slider-crank"), tolerance(tol));
    Simulation often(build_mechanism("slider-crank"), tolerance(tol));
    ASSERT_TRUE(once.advance_to(1).ok);
    for (int i = 1; i <= 400; ++i) // between them intervals far shorter than any step
        ASSERT_TRUE(often.advance_to(i % 10 ? i / 400.0 : (i - 1) / 400.0 + 1e-9).ok);
    ASSERT_TRUE(often.advance_to(1).ok);
    EXPECT_LT((once.state().q - often.state().q).cwiseAbs().maxCoeff(), 30 * tol);
    EXPECT_LT((once.state().u - often.state().u).cwiseAbs().maxCoeff(), 300 * tol);
    EXPECT_LT(often.statistics().steps, 401 + once.statistics().steps / 2);
    EXPECT_LE(often.statistics().rejected_error + often.statistics().rejected_newton, 10);
}

TEST(Radau, StepCutShortDoesNotShortenTheNext) {
    Simulation sim(build_mechanism("pendulum"), tolerance(1e-6));
    ASSERT_TRUE(sim.advance_past(1, 10).ok);
    double before = 0, after = 0;
    Integrator& radau = sim.integrator();
    radau.on_step = [&](const StepRecord& r) { after = r.reason == StepReason::none ? r.h : after; };
    ASSERT_TRUE(radau.advance(10).ok);
    before = after;
    ASSERT_TRUE(radau.advance(radau.state().t + 1e-8).ok);
    EXPECT_NEAR(after, 1e-8, 1e-12);
    ASSERT_TRUE(radau.advance(10).ok);
    EXPECT_GT(after, 0.5 * before);
}

TEST(Radau, FastSpinLimitsStepsByTheTurnAlone) {
    for (const double tol : {1e-2, 1e-4, 1e-7}) {
        Simulation sim(build_mechanism("heavy-top", {{"spin", "400"}}), tolerance(tol));
        const State start = sim.state();
        const StepOutcome outcome = sim.advance_to(1);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Statistics& s = sim.statistics();
        EXPECT_LT(400 * s.largest_step, 3.3); // rad in one step
        EXPECT_LT(s.rejected_newton, 0.15 * s.steps + 1);
        // spin about the own axis is kept, the orientation stays one
        EXPECT_NEAR(sim.state().u[5], 400, 1e3 * tol);
        EXPECT_NEAR(sim.state().q.segment<4>(3).norm(), 1, 1e-14);
    }
}

TEST(Radau, NumberOfThreadsChangesNoBit) {
    VecX q[3];
    for (const int threads : {1, 2, 3}) {
        SimulationOptions options = tolerance(1e-4);
        options.integration.threads = threads;
        Simulation sim(build_mechanism("suspension-chain", {{"units", "80"}}), options);
        ASSERT_TRUE(sim.advance_to(0.02).ok);
        q[threads - 1] = sim.state().q;
    }
    for (const int other : {1, 2})
        EXPECT_EQ(std::memcmp(q[0].data(), q[other].data(), sizeof(double) * q[0].size()), 0);
}

TEST(Radau, RestartForgetsTheSteps) {
    Simulation sim(build_mechanism("slider-crank"), tolerance(1e-6));
    Simulation fresh(build_mechanism("slider-crank"), tolerance(1e-6));
    ASSERT_TRUE(sim.advance_to(0.3).ok);
    const State saved = sim.state();
    for (Simulation* s : {&sim, &fresh}) {
        s->restore(saved);
        ASSERT_TRUE(s->advance_to(0.5).ok);
    }
    EXPECT_LT((sim.state().q - fresh.state().q).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((sim.state().u - fresh.state().u).cwiseAbs().maxCoeff(), 1e-11);
}

} // namespace
} // namespace gudgeon
