// Gear's method and Radau IIA on motions with first integrals, and energies that account for everything.
#include "models/builders.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/elliptic.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

class ImplicitMotion : public testing::TestWithParam<const char*> {
  protected:
    static SimulationOptions tolerance(double tol) {
        SimulationOptions options;
        options.integrator = GetParam();
        options.integration.rtol = options.integration.atol = tol;
        return options;
    }
};

INSTANTIATE_TEST_SUITE_P(Both, ImplicitMotion, testing::Values("gear", "radau"));

const Vec3 inertia(1, 2, 2.5);

/// A body in free fall that tumbles from (w1, 0, w3) at the start.
Model tumbler(const Vec3& spin) {
    Model model;
    Body body = make_body("tumbler", 2, inertia, {0, 0, 1});
    body.orientation = Vec4(0.8, 0.2, -0.4, 0.4).normalized();
    body.velocity = {1, 2, 3};
    body.angular_velocity = spin;
    model.bodies = {body};
    return model;
}

TEST_P(ImplicitMotion, TumblingBodyFollowsEulersSolution) {
    // J1 < J2 < J3 and M^2 > 2 E J2: w3 never vanishes (Landau & Lifshitz, section 37)
    const Vec3 spin(2, 0, 3);
    const double e2 = inertia.dot(spin.cwiseAbs2()), m2 = inertia.cwiseProduct(spin).squaredNorm();
    const double j1 = inertia[0], j2 = inertia[1], j3 = inertia[2];
    ASSERT_GT(m2, e2 * j2);
    const double k = std::sqrt((j2 - j1) * (e2 * j3 - m2) / ((j3 - j2) * (m2 - e2 * j1)));
    const double speed = std::sqrt((j3 - j2) * (m2 - e2 * j1) / (j1 * j2 * j3));
    const double b = std::sqrt((e2 * j3 - m2) / (j2 * (j3 - j2)));
    Simulation sim(tumbler(spin), tolerance(1e-9));
    const State start = sim.state();
    const Vec3 momentum = rotation(start.q.segment<4>(3)) * inertia.cwiseProduct(spin);
    for (const double t : {0.5, 1.7, 4.0, 8.0}) {
        ASSERT_TRUE(sim.advance_to(t).ok);
        const State s = sim.state();
        const Jacobi j = jacobi(speed * t, k);
        const Vec3 w = s.u.tail<3>();
        // which way w2 starts: J2 w2' = (J3 - J1) w3 w1
        EXPECT_LT((w - Vec3(2 * j.cn, b * j.sn, 3 * j.dn)).norm(), 2e-6) << t;
        EXPECT_LT((rotation(s.q.segment<4>(3)) * inertia.cwiseProduct(w) - momentum).norm(), 5e-6);
        EXPECT_NEAR(inertia.dot(w.cwiseAbs2()), e2, 5e-6);
        EXPECT_NEAR(s.q.segment<4>(3).norm(), 1, 1e-14);
        // the mass centre flies its parabola, which both have exactly from order 2 on
        EXPECT_LT((s.q.head<3>() - Vec3(t, 2 * t, 1 + 3 * t - 0.5 * 9.81 * t * t)).norm(), 1e-6);
        EXPECT_LT((s.u.head<3>() - Vec3(1, 2, 3 - 9.81 * t)).norm(), 1e-6);
        EXPECT_NEAR(sim.sample().balance, 0, 2e-5);
    }
}

TEST_P(ImplicitMotion, FreeBodyKeepsItsMomentumBetterWithATighterTolerance) {
    double last = 1;
    for (const double tol : {1e-4, 1e-6, 1e-8}) {
        Simulation sim(tumbler({0.1, 4, 0.1}), tolerance(tol)); // about the unstable axis
        const State start = sim.state();
        const auto momentum = [](const State& s) -> Vec3 {
            return rotation(s.q.segment<4>(3)) * inertia.cwiseProduct(Vec3(s.u.tail<3>()));
        };
        double worst = 0;
        for (double t = 0.25; t <= 5; t += 0.25) {
            ASSERT_TRUE(sim.advance_to(t).ok);
            worst = std::max(worst, (momentum(sim.state()) - momentum(start)).norm());
        }
        EXPECT_LT(worst, 300 * std::pow(tol, 5.0 / 6));
        EXPECT_LT(worst, last / 8);
        last = worst;
    }
}

TEST_P(ImplicitMotion, PairOfBodiesKeepsItsMomenta) {
    // two free bodies with a damped spring between them: forces inside change no momentum
    Model model = tumbler({1, 2, 3});
    Body other = make_body("other", 1, {0.4, 0.5, 0.6}, {1.5, 0.2, 0.3});
    model.bodies.push_back(other);
    model.gravity.setZero();
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"tumbler", "other"};
    spring.points = {Vec3(0.2, 0.1, 1.1), Vec3(1.4, 0.3, 0.2)};
    spring.stiffness = 40;
    spring.damping = 2;
    spring.free_length = 1;
    model.forces = {spring};
    Simulation sim(model, tolerance(1e-9));
    const auto momenta = [&](const State& s) {
        Vec6 sum = Vec6::Zero();
        const System& system = sim.system();
        for (int i = 0; i < 2; ++i) {
            const Vec3 p = system.mass[i] * s.u.segment<3>(6 * i);
            const Vec3 l =
                rotation(s.q.segment<4>(7 * i + 3)) * (system.inertia[i] * Vec3(s.u.segment<3>(6 * i + 3)));
            sum.head<3>() += p;
            sum.tail<3>() += Vec3(s.q.segment<3>(7 * i)).cross(p) + l;
        }
        return sum;
    };
    const Vec6 start = momenta(sim.state());
    ASSERT_TRUE(sim.advance_to(3).ok);
    EXPECT_LT((momenta(sim.state()) - start).norm(), 2e-5);
    EXPECT_GT(sim.state().dissipated(), 0.1);
    EXPECT_EQ(sim.state().input(), 0);
    EXPECT_NEAR(sim.sample().balance, 0, 1e-5);
}

TEST_P(ImplicitMotion, DampedSpringLosesWhatTheClosedFormSays) {
    // 2 kg, 50 N/m, 3 N s/m along X from 0.4 m at rest
    Model model;
    model.gravity.setZero();
    model.bodies = {make_body("mass", 2, {1, 1, 1}, {0.4, 0, 0})};
    model.joints = {
        make_joint("guide", JointKind::translation, "ground", "mass", {0.4, 0, 0}, Vec3::UnitX())};
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "mass"};
    spring.points = {Vec3(-1, 0, 0), Vec3(0.4, 0, 0)};
    spring.stiffness = 50;
    spring.damping = 3;
    spring.free_length = 1;
    model.forces = {spring};
    Simulation sim(model, tolerance(1e-9));
    const double decay = 0.75, w = std::sqrt(25 - decay * decay), x0 = 0.4;
    for (const double t : {0.3, 1.0, 2.5}) {
        ASSERT_TRUE(sim.advance_past(t, 3).ok); // inside a step: energies are interpolated too
        const Sample& sample = sim.sample_at(t);
        const double envelope = x0 * std::exp(-decay * t);
        const double x = envelope * (std::cos(w * t) + decay / w * std::sin(w * t));
        const double v = -envelope * (w + decay * decay / w) * std::sin(w * t);
        EXPECT_NEAR(sample.state.q[0], x, 1e-7);
        EXPECT_NEAR(sample.state.u[0], v, 1e-6);
        EXPECT_NEAR(sample.energies.elastic, 25 * x * x, 1e-6);
        EXPECT_NEAR(sample.energies.kinetic, v * v, 1e-6);
        EXPECT_NEAR(sample.state.dissipated(), 25 * x0 * x0 - 25 * x * x - v * v, 1e-6);
    }
}

TEST_P(ImplicitMotion, SuspensionBooksRoadAndDamping) {
    Simulation sim(build_mechanism("suspension-chain"), tolerance(1e-6));
    const double at_start = sim.sample().energies.mechanical();
    double last = 0;
    for (double t = 0.1; t < 2.05; t += 0.1) {
        ASSERT_TRUE(sim.advance_to(t).ok);
        const Sample& sample = sim.sample();
        EXPECT_GE(sample.state.dissipated(), last); // dampers only take
        last = sample.state.dissipated();
        // one ledger: what is there now, what was there, what left and what came in
        const double now = sample.energies.mechanical();
        EXPECT_NEAR(sample.balance, now + last - sample.state.input() - at_start, 1e-9 * std::abs(now));
        EXPECT_LT(std::abs(sample.balance), 0.05);
    }
    EXPECT_GT(last, 50);                      // J
    EXPECT_GT(sim.state().input(), last / 2); // which came from the road
}

} // namespace
} // namespace gudgeon
