// The explicit methods with error control against closed forms and references, in both formulations.
#include "solvers/erk.hpp"

#include "tests/solvers/integrator_tools.hpp"
#include "tests/solvers/reference_runs.hpp"

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using namespace integrator_tools;
using testing_data::ReferenceTable;

struct Method {
    int order;
    Formulation formulation;
};

void PrintTo(const Method& m, std::ostream* out) {
    *out << m.order << " " << formulation_name(m.formulation);
}

std::unique_ptr<Integrator> begun(const Method& m, const System& system, double tolerance, double step = 0) {
    IntegratorOptions options;
    options.rtol = options.atol = tolerance;
    options.step = step;
    options.formulation = m.formulation;
    auto integrator = m.order == 5 ? make_erk5(system, options) : make_erk8(system, options);
    integrator->start(initial_state(system));
    return integrator;
}

class Erk : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Erk,
                         testing::Values(Method{5, Formulation::saddle_point},
                                         Method{8, Formulation::saddle_point}, Method{5, Formulation::tree},
                                         Method{8, Formulation::tree}),
                         [](const auto& info) {
                             return std::to_string(info.param.order) +
                                    (info.param.formulation == Formulation::tree ? "Tree" : "Cartesian");
                         });

TEST_P(Erk, OscillatorFollowsItsClosedForm) {
    const System system = Oscillator::system();
    auto erk = begun(GetParam(), system, 1e-9);
    int samples = 0;
    const StepOutcome outcome = run(*erk, 2, 0.0037, [&](const State& s) {
        EXPECT_NEAR(s.q[0], Oscillator::x(s.t), 2e-8);
        EXPECT_NEAR(s.u[0], Oscillator::v(s.t), 1e-7);
        EXPECT_NEAR(s.dissipated(), Oscillator::energy(0) - Oscillator::energy(s.t), 1e-7);
        EXPECT_EQ(s.input(), 0);
        ++samples;
    });
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_EQ(samples, 541);
}

TEST_P(Erk, HasItsOrder) {
    const System system = ready("chain", {{"links", "4"}, {"thin", "1"}});
    const ReferenceTable reference("r5_chain_N4.csv");
    std::vector<double> errors;
    const int first = GetParam().order == 5 ? 50 : 25;
    for (const int steps : {first, 2 * first}) {
        auto erk = begun(GetParam(), system, 1e9, 1.0 / steps); // every step has the largest length
        erk->advance(1e-9);                                     // the first, estimated step
        ASSERT_TRUE(run(*erk, 1).ok);
        const State& s = erk->state();
        const Vec3 tip = s.q.segment<3>(21) + rotation(s.q.segment<4>(24)) * Vec3(0.5, 0, 0);
        errors.push_back(std::hypot(tip.x() - reference["tip_x"][100], tip.z() - reference["tip_z"][100]));
    }
    // the tip's error has not quite come to its last power there; explicit_pair_test.cpp sees that
    EXPECT_GT(std::log2(errors[0] / errors[1]), GetParam().order - 0.4);
    EXPECT_LT(std::log2(errors[0] / errors[1]), GetParam().order + 1.2);
}

TEST_P(Erk, ErrorFollowsTheTolerance) {
    const System system = ready("chain", {{"links", "4"}, {"thin", "1"}});
    const ReferenceTable reference("r5_chain_N4.csv");
    double before = 1;
    long evaluations = 0;
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
        auto erk = begun(GetParam(), system, tolerance);
        double error = 0;
        std::size_t row = 0;
        ASSERT_TRUE(run(*erk, 1, 0.01, [&](const State& s) {
                        const Vec3 tip = s.q.segment<3>(21) + rotation(s.q.segment<4>(24)) * Vec3(0.5, 0, 0);
                        error = std::max(error, std::hypot(tip.x() - reference["tip_x"][row],
                                                           tip.z() - reference["tip_z"][row]));
                        ++row;
                    }).ok);
        EXPECT_GE(row, 100u);
        EXPECT_LT(error, 20 * tolerance);
        EXPECT_LT(error, before / 10);
        EXPECT_GT(erk->statistics().evaluations, evaluations);
        evaluations = erk->statistics().evaluations;
        before = error;
    }
}

TEST_P(Erk, ConstraintsHoldThroughALoop) {
    const System system = ready("slider-crank");
    auto erk = begun(GetParam(), system, 1e-7);
    const double energy = mechanical_energy(system, erk->state());
    ASSERT_TRUE(run(*erk, 0.5).ok);
    EXPECT_LT(erk->statistics().constraint_position_max, 1e-12);
    EXPECT_LT(erk->statistics().constraint_velocity_max, 1e-11);
    EXPECT_NEAR(mechanical_energy(system, erk->state()), energy, 1e-5);
    const ReferenceTable reference("r1_slider_crank_ideal.csv");
    const auto row =
        std::ranges::find(reference["t"], 0.5, [](double t) { return std::round(t * 1e6) / 1e6; }) -
        reference["t"].begin();
    EXPECT_NEAR(erk->state().q[7 * system.body_index("slider")], reference["x"][row], 1e-5);
}

TEST_P(Erk, ContactsBeginShallow) {
    const System system = ready("bouncing-journal");
    auto erk = begun(GetParam(), system, 1e-7);
    int started = 0;
    ASSERT_TRUE(run(*erk, 0.05).ok);
    for (const ContactHistory& history : erk->state().history)
        started += history.impacts;
    EXPECT_GT(started, 0);
    EXPECT_EQ(erk->statistics().deep_starts, 0);
}

// All cranks of a parallelogram's loops lie flat at once every turn; the angle of one is that of all:
// a'' = g (9N+3)/(8N+2) sin a, by small steps of the classical method.
double crank_angle(int loops, double end) {
    const double k = 9.81 * (9.0 * loops + 3) / (8.0 * loops + 2), h = 1e-4;
    double a = 0, w = 1;
    for (long i = 0; i < std::lround(end / h); ++i) {
        const double k1 = k * std::sin(a), k2 = k * std::sin(a + h / 2 * w);
        const double k3 = k * std::sin(a + h / 2 * w + h * h / 4 * k1);
        const double k4 = k * std::sin(a + h * w + h * h / 2 * k2);
        a += h * w + h * h / 6 * (k1 + k2 + k3);
        w += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    return a;
}

TEST(ErkSingular, LoopsPassTheirFlatPositionsInJointCoordinates) {
    for (const int loops : {1, 10}) {
        const double exact = crank_angle(loops, 3);
        ASSERT_GT(exact, 2 * pi) << "flat positions lie behind";
        SimulationOptions options;
        options.integrator = "erk8";
        options.integration.rtol = options.integration.atol = 1e-9;
        options.integration.formulation = Formulation::automatic;
        Simulation sim(build_mechanism("four-bar", {{"loops", std::to_string(loops)}}), options);
        EXPECT_STREQ(sim.formulation(), "tree");
        ASSERT_TRUE(sim.advance_to(3).ok);
        const Vec3 centre = sim.state().q.segment<3>(7 * sim.system().body_index("crank0"));
        EXPECT_LT((centre - 0.5 * Vec3(std::sin(exact), 0, std::cos(exact))).norm(), 1e-5) << loops;
        EXPECT_LT(sim.statistics().steps, 500) << loops;
    }
}

TEST_P(Erk, NewLoadsCountAtOnce) {
    Model model;
    Body body;
    body.name = "probe";
    body.mass = 2;
    body.inertia = Mat3::Identity();
    model.bodies = {body};
    model.gravity = Vec3::Zero();
    const System system = compile(std::move(model), standard_force_builders());
    auto erk = begun(GetParam(), system, 1e-8);
    ASSERT_TRUE(run(*erk, 1).ok);
    erk->workspace().external[0] = 6; // 3 m/s2
    ASSERT_TRUE(run(*erk, 2).ok);
    EXPECT_NEAR(erk->state().q[0], 1.5, 1e-8);
    EXPECT_NEAR(erk->state().u[0], 3, 1e-8);
}

TEST_P(Erk, BadNumbersStopTheRunAndAreNamed) {
    const System system = pushed_body([](const UserForceInput& in, UserForceOutput& out) {
        out.wrench.force_b = {in.t < 0.5 ? 1.0 : std::numeric_limits<double>::quiet_NaN(), 0, 0};
    });
    auto erk = begun(GetParam(), system, 1e-6);
    const StepOutcome outcome = run(*erk, 1);
    EXPECT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.reason, StepReason::non_finite);
    EXPECT_NE(outcome.message.find("push"), std::string::npos) << outcome.message;
    EXPECT_NEAR(erk->state().t, 0.5, 1e-6);
}

TEST(ErkOptions, WhatCannotBeIsRefused) {
    const System system = ready("pendulum");
    IntegratorOptions options;
    options.atol = 0;
    EXPECT_THROW((void)make_erk(system, options), std::invalid_argument);
    options = {};
    options.step = -1;
    EXPECT_THROW((void)make_erk8(system, options), std::invalid_argument);
}

} // namespace
} // namespace gudgeon
