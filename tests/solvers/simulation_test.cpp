// The way in for other programs: stepping, saving, loads from outside, user forces, matrices, reactions.
#include "solvers/simulation.hpp"

#include "models/builders.hpp"
#include "tests/solvers/system_tools.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

namespace gudgeon {
namespace {

using namespace test;

SimulationOptions tolerance(double tol) {
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = tol;
    return options;
}

bool same_bits(const VecX& x, const VecX& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), sizeof(double) * x.size()) == 0;
}

TEST(Simulation, SavedStateGoesOnAlike) {
    for (const char* name : {"slider-crank", "suspension-chain"}) {
        const double tol = 1e-7;
        Simulation sim(build_mechanism(name), tolerance(tol));
        ASSERT_TRUE(sim.advance_to(0.3).ok);
        const State saved = sim.state();
        ASSERT_TRUE(sim.advance_to(0.6).ok);
        const State straight = sim.state();

        sim.restore(saved);
        EXPECT_EQ(sim.time(), 0.3);
        EXPECT_TRUE(same_bits(sim.state().q, saved.q) && same_bits(sim.state().u, saved.u));
        EXPECT_EQ(sim.state().dissipated(), saved.dissipated());
        EXPECT_EQ(sim.state().input(), saved.input());
        ASSERT_TRUE(sim.advance_to(0.6).ok);
        const State again = sim.state();
        // begun anew at 0.3 s, so the same within the tolerance only
        EXPECT_LT((again.q - straight.q).cwiseAbs().maxCoeff(), 1e3 * tol) << name;
        EXPECT_LT((again.u - straight.u).cwiseAbs().maxCoeff(), 3e4 * tol) << name;
        EXPECT_NEAR(again.dissipated(), straight.dissipated(), 1e-3) << name;

        // and in two other objects bit by bit alike
        State ends[2];
        for (State& end : ends) {
            Simulation other(build_mechanism(name), tolerance(tol));
            other.restore(saved);
            ASSERT_TRUE(other.advance_to(0.6).ok);
            end = other.state();
        }
        EXPECT_TRUE(same_bits(ends[0].q, ends[1].q) && same_bits(ends[0].u, ends[1].u)) << name;
        // the first kept its pivots: rounding may turn a decision about a sweep
        EXPECT_LT((ends[0].q - again.q).cwiseAbs().maxCoeff(), tol) << name;
    }
}

TEST(Simulation, UnwrappedAnglesAreSavedToo) {
    Model model = build_mechanism("slider-crank");
    joint_named(model, "A").drives["angle"] = RampFunction{0, 6, 0};
    Simulation sim(model, tolerance(1e-6));
    ASSERT_TRUE(sim.advance_to(3).ok); // nearly three turns
    const State saved = sim.state();
    Simulation other(model, tolerance(1e-6));
    other.restore(saved);
    ASSERT_TRUE(other.advance_to(3.2).ok);
    const int angle = other.system().joints[other.system().joint_index("A")].coordinates[0].index;
    EXPECT_NEAR(other.state().angles.value[angle], 6 * 3.2, 1e-9);
}

TEST(Simulation, StateOfAnotherSystemIsRefused) {
    Simulation sim(build_mechanism("pendulum"));
    Simulation other(build_mechanism("slider-crank"));
    EXPECT_THROW(sim.restore(other.state()), std::invalid_argument);
}

TEST(Simulation, UnknownNamesAreRefused) {
    SimulationOptions options;
    options.integrator = "guess";
    EXPECT_THROW(Simulation(build_mechanism("pendulum"), options), std::invalid_argument);
    Simulation sim(build_mechanism("pendulum"));
    EXPECT_THROW(sim.set_load("bobby", Vec3::Zero(), Vec3::Zero()), std::invalid_argument);
}

TEST(Simulation, AdvancePastStepsFreelyAndSamplesInside) {
    Simulation exact(build_mechanism("heavy-top"), tolerance(1e-10));
    Simulation sim(build_mechanism("heavy-top"), tolerance(1e-8));
    long steps = 0;
    for (int k = 1; k <= 200; ++k) {
        const double t = 0.001 * k;
        ASSERT_TRUE(sim.advance_past(t, 1).ok);
        EXPECT_GE(sim.time(), t);
        const Sample& sample = sim.sample_at(t);
        EXPECT_EQ(sample.state.t, t);
        ASSERT_TRUE(exact.advance_to(t).ok);
        EXPECT_LT((sample.state.q - exact.state().q).cwiseAbs().maxCoeff(), 1e-5);
        steps = sim.statistics().steps;
    }
    EXPECT_LT(steps, 190); // it did not step to every sample
}

TEST(Simulation, LoadSetFromOutsideEqualsTheForceInTheModel) {
    const Vec3 force(3, 0, 8), moment(0, 0.5, 0);
    Model model = build_mechanism("chain", {{"links", "3"}});
    AppliedForce push;
    push.name = "push";
    push.body = "link2";
    push.body_frame = true; // at the mass centre
    push.vector = force;
    AppliedForce twist = push;
    twist.name = "twist";
    twist.torque = true;
    twist.vector = moment;
    Model loaded = model;
    loaded.forces = {push, twist};

    Simulation inside(loaded, tolerance(1e-8)), outside(model, tolerance(1e-8));
    outside.set_load("link2", force, moment);
    for (const double t : {0.2, 0.5, 0.8}) {
        ASSERT_TRUE(inside.advance_to(t).ok);
        ASSERT_TRUE(outside.advance_to(t).ok);
        EXPECT_LT((inside.state().q - outside.state().q).cwiseAbs().maxCoeff(), 1e-6);
        EXPECT_LT((inside.state().u - outside.state().u).cwiseAbs().maxCoeff(), 1e-5);
        EXPECT_NEAR(inside.state().input(), outside.state().input(), 1e-5);
        EXPECT_NEAR(outside.sample().balance, 0, 1e-5);
        const Sample& a = inside.sample();
        EXPECT_LT((a.joint[0].force - outside.sample().joint[0].force).norm(), 1e-3);
    }
    // a load on the ground changes nothing
    outside.set_load("ground", force, moment);
    const State before = outside.state();
    EXPECT_EQ(outside.time(), 0.8);
    EXPECT_TRUE(same_bits(outside.state().q, before.q));
}

TEST(Simulation, LoadChangedBetweenStepsMakesParabolas) {
    Model model;
    model.gravity.setZero();
    model.bodies = {make_body("block", 2, {1, 1, 1}, Vec3::Zero())};
    Simulation sim(model, tolerance(1e-9));
    sim.set_load("block", {4, 0, 0}, {0, 0, 0}); // 2 m/s2 for 1 s
    ASSERT_TRUE(sim.advance_to(1).ok);
    sim.set_load("block", {-2, 0, 0}, {0, 0, 1}); // back with 1 m/s2, and a turn
    ASSERT_TRUE(sim.advance_to(2).ok);
    const State s = sim.state();
    EXPECT_NEAR(s.q[0], 1 + 2 - 0.5, 1e-6);
    EXPECT_NEAR(s.u[0], 1, 1e-6);
    EXPECT_NEAR(s.u[5], 1, 1e-6);
    EXPECT_NEAR(2 * std::asin(s.q[6]), 0.5, 1e-6);
    EXPECT_NEAR(s.input(), 4 * 1 - 2 * 1.5 + 1 * 0.5, 1e-5);
}

/// A mass on springs to the ground along X, without and with damping.
Model spring_mass(double stiffness, double damping) {
    Model model;
    model.gravity.setZero();
    model.bodies = {make_body("mass", 2, {0.1, 0.2, 0.3}, {0.3, 0.2, 0})};
    model.bodies[0].velocity = {0.4, -0.3, 0.2};
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "mass"};
    spring.points = {Vec3(-1, 0, 0), model.bodies[0].position};
    spring.stiffness = stiffness;
    spring.damping = damping;
    spring.free_length = 0.9;
    model.forces = {spring};
    return model;
}

TEST(Simulation, UserForceEqualsTheBuiltInSpring) {
    const double k = 60, c = 1.5, l0 = 0.9;
    Model bare = spring_mass(k, c);
    bare.forces.clear();
    const Vec3 anchor(-1, 0, 0);
    for (const bool derivatives : {true, false}) {
        SimulationOptions options = tolerance(1e-9);
        options.user_forces = {
            {"spring", {"ground", "mass"}, [=](const UserForceInput& in, UserForceOutput& out) {
                 const Vec3 d = in.b.r - anchor;
                 const double l = d.norm(), rate = d.dot(in.b.v) / l;
                 const Vec3 n = d / l;
                 out.wrench.force_b = -(k * (l - l0) + c * rate) * n;
                 out.energies = EnergyRates{0.5 * k * (l - l0) * (l - l0), c * rate * rate, 0};
                 if (!in.derivatives || !derivatives)
                     return;
                 const Mat3 across = (Mat3::Identity() - n * n.transpose()) / l;
                 out.has_derivatives = true;
                 out.C->block[2][2] = c * n * n.transpose();
                 out.S->block[2][2] = k * n * n.transpose() + (k * (l - l0) + c * rate) * across +
                                      c * n * (across * in.b.v).transpose();
             }}};
        Simulation user(bare, options), built_in(spring_mass(k, c), tolerance(1e-9));
        for (const double t : {0.5, 1.5, 3.0}) {
            ASSERT_TRUE(user.advance_to(t).ok);
            ASSERT_TRUE(built_in.advance_to(t).ok);
            EXPECT_LT((user.state().q - built_in.state().q).cwiseAbs().maxCoeff(), 1e-7);
            EXPECT_LT((user.state().u - built_in.state().u).cwiseAbs().maxCoeff(), 1e-6);
            EXPECT_NEAR(user.state().dissipated(), built_in.state().dissipated(), 1e-6);
            EXPECT_NEAR(user.sample().energies.elastic, built_in.sample().energies.elastic, 1e-6);
        }
        const MatX ours = dense(user.matrices().K), theirs = dense(built_in.matrices().K);
        EXPECT_LT(error(ours, theirs), derivatives ? 1e-5 : 1e-4);
    }
}

TEST(Simulation, UserForceOnABodyThatIsNotThereIsRefused) {
    SimulationOptions options;
    options.user_forces = {{"wind", {"ground", "sail"}, [](const UserForceInput&, UserForceOutput&) {}}};
    EXPECT_THROW(Simulation(build_mechanism("pendulum"), options), ModelError);
}

TEST(Simulation, MatricesOfTwoMassesGiveTheirFrequencies) {
    // wall - k - m - k - m - k - wall along X: w2 = k/m and 3 k/m
    const double k = 300, mass = 2;
    Model model;
    model.gravity.setZero();
    for (const auto& [name, x] : {std::pair("left", 1.0), {"right", 2.0}}) {
        model.bodies.push_back(make_body(name, mass, {1, 1, 1}, {x, 0, 0}));
        model.joints.push_back(make_joint(std::string("guide-") + name, JointKind::translation, "ground",
                                          name, {x, 0, 0}, Vec3::UnitX()));
    }
    const std::vector<std::pair<std::string, std::string>> links{
        {"ground", "left"}, {"left", "right"}, {"right", "ground"}};
    for (std::size_t i = 0; i < links.size(); ++i) {
        SpringDamper spring;
        spring.name = "spring" + std::to_string(i);
        spring.bodies = {links[i].first, links[i].second};
        const double x = static_cast<double>(i);
        spring.points = {Vec3(x, 0, 0), Vec3(x + 1, 0, 0)};
        spring.stiffness = k;
        spring.damping = 4;
        model.forces.push_back(spring);
    }
    Simulation sim(model);
    const Simulation::Matrices matrices = sim.matrices();
    const MatX M = dense(matrices.M), K = dense(matrices.K), C = dense(matrices.C), G = dense(matrices.G);
    EXPECT_EQ(M, dense_mass(sim.system()));
    ASSERT_EQ(G.rows(), 10);
    const MatX free = G.fullPivLu().kernel(); // the two slides
    ASSERT_EQ(free.cols(), 2);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatX> modes(free.transpose() * K * free,
                                                               free.transpose() * M * free);
    EXPECT_NEAR(modes.eigenvalues()[0], k / mass, 1e-9);
    EXPECT_NEAR(modes.eigenvalues()[1], 3 * k / mass, 1e-9);
    EXPECT_LT(error(free.transpose() * C * free, 4.0 / k * (free.transpose() * K * free)), 1e-12);
}

TEST(Simulation, PendulumMatricesHoldItsGeometricStiffness) {
    // hanging at rest: w2 = m g l / (J + m l2) comes from d(G^T lambda)/dq alone
    Model model;
    Body bob = make_body("bob", 1.5, {0.1, 0.06, 0.1}, {0, 0, -0.4});
    model.bodies = {bob};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "bob", Vec3::Zero(), Vec3::UnitY())};
    Simulation sim(model);
    const Simulation::Matrices matrices = sim.matrices();
    const MatX free = dense(matrices.G).fullPivLu().kernel();
    ASSERT_EQ(free.cols(), 1);
    const double stiffness = (free.transpose() * dense(matrices.K) * free)(0, 0);
    const double inertia = (free.transpose() * dense(matrices.M) * free)(0, 0);
    EXPECT_NEAR(stiffness / inertia, 1.5 * 9.81 * 0.4 / (0.06 + 1.5 * 0.16), 1e-10);
}

VecX trajectory(const std::string& name) {
    Simulation sim(build_mechanism(name), tolerance(1e-6));
    VecX all;
    for (int k = 1; k <= 10; ++k) {
        EXPECT_TRUE(sim.advance_past(0.05 * k, 0.5).ok);
        const Sample& s = sim.sample_at(0.05 * k);
        VecX longer(all.size() + s.state.q.size() + s.state.u.size() + s.state.lambda.size());
        longer << all, s.state.q, s.state.u, s.state.lambda;
        all = longer;
    }
    return all;
}

TEST(Simulation, TwoInTwoThreadsAreTheSameAsOneAfterTheOther) {
    const VecX crank = trajectory("slider-crank"), car = trajectory("suspension-chain");
    for (int repeat = 0; repeat < 3; ++repeat) {
        VecX in_thread[2];
        std::thread first([&] { in_thread[0] = trajectory("slider-crank"); });
        std::thread second([&] { in_thread[1] = trajectory("suspension-chain"); });
        first.join();
        second.join();
        EXPECT_TRUE(same_bits(in_thread[0], crank));
        EXPECT_TRUE(same_bits(in_thread[1], car));
    }
}

TEST(Simulation, NumberOfThreadsChangesNoBit) {
    VecX q[3];
    for (const int threads : {1, 2, 3}) {
        SimulationOptions options = tolerance(1e-4);
        options.integration.threads = threads;
        Simulation sim(build_mechanism("suspension-chain", {{"units", "80"}}), options);
        ASSERT_TRUE(sim.advance_to(0.02).ok);
        q[threads - 1] = sim.state().q;
    }
    EXPECT_TRUE(same_bits(q[0], q[1]));
    EXPECT_TRUE(same_bits(q[0], q[2]));
}

TEST(Simulation, MovedObjectGoesOn) {
    Simulation first(build_mechanism("pendulum"));
    ASSERT_TRUE(first.advance_to(0.2).ok);
    Simulation second(std::move(first));
    EXPECT_EQ(second.time(), 0.2);
    EXPECT_TRUE(second.advance_to(0.4).ok);
}

// Reactions on b by a, at b's point.
TEST(Reactions, HangingBodyIsHeldByItsWeight) {
    Model model;
    model.bodies = {make_body("lamp", 3, {1, 1, 1}, {0.2, 0.1, -1})};
    model.joints = {make_joint("hook", JointKind::rigid, "ground", "lamp", {0, 0, 0})};
    Simulation sim(model);
    const Wrench& w = sim.sample().joint[0];
    const double weight = 3 * 9.81;
    EXPECT_LT((w.force - Vec3(0, 0, weight)).norm(), 1e-12);
    // r x F of the weight about the hook must be balanced
    EXPECT_LT((w.moment + Vec3(0.2, 0.1, -1).cross(Vec3(0, 0, -weight))).norm(), 1e-12);
}

TEST(Reactions, WrenchActsOnTheSecondBody) {
    Model model;
    model.bodies = {make_body("lamp", 3, {1, 1, 1}, {0.2, 0.1, -1})};
    model.joints = {make_joint("hook", JointKind::rigid, "lamp", "ground", {0, 0, 0})};
    Simulation sim(model);
    const Wrench& w = sim.sample().joint[0]; // of the lamp on the ground
    EXPECT_LT((w.force - Vec3(0, 0, -3 * 9.81)).norm(), 1e-12);
    EXPECT_LT((w.moment - Vec3(0.2, 0.1, -1).cross(Vec3(0, 0, -3 * 9.81))).norm(), 1e-12);
}

TEST(Reactions, StaticChainBearsWhatHangsBelow) {
    Model model;
    std::string previous = "ground";
    for (int k = 1; k <= 5; ++k) {
        const std::string link = "link" + std::to_string(k);
        Body body = make_bar(link, 1.0 / 12, {0, 0, 0.5 - k});
        body.orientation = {std::sqrt(0.5), 0, std::sqrt(0.5), 0}; // body x down
        model.bodies.push_back(body);
        model.joints.push_back(make_joint("J" + std::to_string(k),
                                          k % 2 ? JointKind::revolute : JointKind::spherical, previous, link,
                                          {0, 0, 1.0 - k}));
        if (k % 2)
            model.joints.back().axes = {Vec3::UnitY(), Vec3::UnitY()};
        previous = link;
    }
    Simulation sim(model);
    ASSERT_TRUE(sim.advance_to(0.5).ok);
    const Sample& sample = sim.sample();
    for (int k = 0; k < 5; ++k) {
        EXPECT_LT((sample.joint[k].force - Vec3(0, 0, (5 - k) * 9.81)).norm(), 1e-9) << "J" << k + 1;
        EXPECT_LT(sample.joint[k].moment.norm(), 1e-9);
        EXPECT_LT(sample.acceleration.segment<6>(6 * k).norm(), 1e-9);
    }
}

TEST(Reactions, BushingCarriesLikeAJoint) {
    Model model;
    model.bodies = {make_body("engine", 50, {2, 2, 2}, {0, 0, 0})};
    Joint mount = make_joint("mount", JointKind::rigid, "ground", "engine", {0.1, 0, 0});
    mount.fidelity = Fidelity::bushing;
    mount.bushing = Bushing{};
    mount.bushing->stiffness = {1e5, 1e5, 1e5, 1e4, 1e4, 1e4};
    mount.bushing->damping = {2e3, 2e3, 2e3, 4e2, 4e2, 4e2};
    model.joints = {mount};
    Simulation sim(model, tolerance(1e-8));
    ASSERT_TRUE(sim.advance_to(5).ok);
    const Sample& sample = sim.sample();
    const Wrench& w = sample.joint[0];
    EXPECT_LT((w.force - Vec3(0, 0, 50 * 9.81)).norm(), 1e-3); // it came to rest
    const Vec3 arm = sample.state.q.head<3>() -
                     (sample.state.q.head<3>() + rotation(sample.state.q.segment<4>(3)) * Vec3(0.1, 0, 0));
    EXPECT_LT((w.moment + arm.cross(Vec3(0, 0, -50 * 9.81))).norm(), 1e-3);
    // sinks by weight / stiffness, and more where the mount tilts
    EXPECT_LT(sample.state.q[2], -50 * 9.81 / 1e5);
}

} // namespace
} // namespace gudgeon
