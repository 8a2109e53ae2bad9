// Friction at contact points, in whole systems: a journal pressed into its bearing, both free.
#include "contact/friction_point.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

Friction lugre() {
    Friction friction;
    friction.kind = "lugre";
    friction.kinetic = 0.3;
    friction.statics = 0.5;
    friction.speed = 0.8;
    friction.sigma0 = 40;
    friction.sigma1 = 0.2;
    friction.sigma2 = 0.05;
    return friction;
}

Friction coulomb() {
    Friction friction;
    friction.kinetic = 0.3;
    friction.speed = 1e-3;
    return friction;
}

Body free_body(const std::string& name) {
    Body body;
    body.name = name;
    body.mass = 1;
    body.inertia = Mat3::Identity();
    return body;
}

/// Bearing along X on `a`, journal `b`, both free and centred at the origin.
Model bearing(JointKind kind, const std::string& model, std::optional<Friction> friction, bool on_b = false) {
    Model out;
    out.gravity = Vec3::Zero();
    out.bodies = {free_body("a"), free_body("b")};
    Joint joint;
    joint.name = "J";
    joint.kind = kind;
    joint.bodies = {"a", "b"};
    joint.fidelity = Fidelity::clearance;
    if (kind != JointKind::spherical)
        joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
    Clearance clearance;
    clearance.model = model;
    clearance.radial = 1e-3;
    clearance.radius = 0.05;
    if (kind != JointKind::spherical && model != "planar")
        clearance.length = 0.1;
    if (model == "slot") {
        clearance.radius.reset();
        clearance.section = {{0.08, 0.06}};
    }
    clearance.bearing_on_b = on_b;
    clearance.law.kind = "linear";
    clearance.law.stiffness = 1e6;
    clearance.law.damping = 30;
    clearance.friction = friction;
    joint.clearance = clearance;
    out.joints = {joint};
    return out;
}

struct Case {
    std::string name;
    JointKind kind;
    std::string model;
};
const std::vector<Case> cases{{"ball", JointKind::spherical, "strips"},
                              {"strips", JointKind::cylindrical, "strips"},
                              {"planar", JointKind::cylindrical, "planar"},
                              {"two ends", JointKind::cylindrical, "two-end"},
                              {"slot", JointKind::translation, "slot"}};

/// b pushed into a and everything moving.
State pressed(const System& system, std::mt19937& rng) {
    State s = initial_state(system);
    s.q.segment<3>(7) = Vec3(2e-4, 1.1e-3, -0.9e-3);
    s.q.segment<4>(10) = turned(s.q.segment<4>(10), Vec3(0.1, 2e-3, -3e-3));
    for (double& u : s.u)
        u = std::uniform_real_distribution<double>(-2, 2)(rng);
    for (double& z : s.z)
        z = std::uniform_real_distribution<double>(-5e-3, 5e-3)(rng);
    return s;
}

void set(const System& system, const State& s, Workspace& ws) {
    ws.z = s.z;
    ws.contacts = s.contacts;
    ws.contacts.start_speed.setConstant(0.1);
    set_motion(system, s.q, s.u, ws);
}

VecX forces(const System& system, const State& s, Workspace& ws) {
    set(system, s, ws);
    evaluate_forces(system, 0, ws);
    return ws.f;
}

void check_derivatives(const System& system, const State& s) {
    Workspace ws = make_workspace(system);
    set(system, s, ws);
    linearise(system, 0, s.lambda.data(), ws);
    const Linearisation lin = ws.lin;
    const Eigen::Index n = system.velocities();
    MatX by_speed(n, n), by_pose(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
        by_speed.col(j) = test::derivative(
            [&](double h) {
                State other = s;
                other.u[j] += h;
                return MatX(forces(system, other, ws));
            },
            1e-3);
        by_pose.col(j) = test::derivative(
            [&](double h) {
                State other = s;
                VecX step = VecX::Zero(n);
                step[j] = h;
                move(system, step, other.q);
                return MatX(forces(system, other, ws));
            },
            1e-5);
    }
    EXPECT_LT(test::error(test::dense(blocks_as_matrix(system, lin.C)), -by_speed), 1e-8);
    EXPECT_LT(test::error(test::dense(blocks_as_matrix(system, lin.S)), -by_pose), 1e-7);

    ASSERT_EQ(lin.states.size(), static_cast<std::size_t>(system.friction_states()));
    VecX source(system.friction_states()), decay = source;
    for (std::size_t i = 0; i < lin.states.size(); ++i) {
        const Linearisation::StateCoupling& x = lin.states[i];
        ASSERT_EQ(x.state, static_cast<int>(i));
        const MatX by_state = test::derivative([&](double h) {
            State other = s;
            other.z[x.state] += h;
            return MatX(forces(system, other, ws));
        });
        VecX force(n), rate(n);
        const int a = 6 * x.a, b = 6 * x.b;
        force.segment<3>(a) = x.force.ra.transpose();
        force.segment<3>(a + 3) = x.force.ta.transpose();
        force.segment<3>(b) = x.force.rb.transpose();
        force.segment<3>(b + 3) = x.force.tb.transpose();
        rate.segment<3>(a) = x.rate.ra.transpose();
        rate.segment<3>(a + 3) = x.rate.ta.transpose();
        rate.segment<3>(b) = x.rate.rb.transpose();
        rate.segment<3>(b + 3) = x.rate.tb.transpose();
        EXPECT_LT(test::error(force, by_state), 1e-7);
        VecX z_rate(n);
        for (Eigen::Index j = 0; j < n; ++j)
            z_rate[j] = test::derivative(
                [&](double h) {
                    State other = s;
                    other.u[j] += h;
                    set(system, other, ws);
                    state_terms(system, 0, ws, source, decay);
                    return MatX(MatX::Constant(1, 1, source[x.state] - decay[x.state] * s.z[x.state]));
                },
                1e-3)(0);
        EXPECT_LT(test::error(rate, z_rate), 1e-8);
    }
}

TEST(FrictionPoint, Derivatives) {
    for (const Case& c : cases)
        for (const bool on_b : {false, true})
            for (const Friction& friction : {lugre(), coulomb()}) {
                SCOPED_TRACE(c.name + (on_b ? " on b, " : " on a, ") + friction.kind);
                const System system = test::compiled(bearing(c.kind, c.model, friction, on_b));
                std::mt19937 rng(11);
                check_derivatives(system, pressed(system, rng));
            }
}

// Friction changes neither momentum; what it takes is what the samples and energies say.
TEST(FrictionPoint, BalanceAndPower) {
    for (const Case& c : cases)
        for (const Friction& friction : {lugre(), coulomb()}) {
            SCOPED_TRACE(c.name + ", " + friction.kind);
            const System plain = test::compiled(bearing(c.kind, c.model, std::nullopt)),
                         rough = test::compiled(bearing(c.kind, c.model, friction));
            std::mt19937 rng(12);
            State s = pressed(rough, rng);
            Workspace ws = make_workspace(plain), wr = make_workspace(rough);
            State without = initial_state(plain);
            without.q = s.q;
            without.u = s.u;
            const VecX f = forces(rough, s, wr) - forces(plain, without, ws);
            const Vec3 on_a = f.segment<3>(0), on_b = f.segment<3>(6);
            EXPECT_GT(on_b.norm(), 1);
            EXPECT_LT((on_a + on_b).norm(), 1e-12 * on_b.norm());
            const Vec3 moments = wr.motion[0].A * f.segment<3>(3) + wr.motion[1].A * f.segment<3>(9) +
                                 wr.motion[0].r.cross(on_a) + wr.motion[1].r.cross(on_b);
            EXPECT_LT(moments.norm(), 1e-12 * on_b.norm());
            const double power = -f.dot(s.u);
            const double extra = energies(rough, 0, nullptr, wr).dissipated_power -
                                 energies(plain, 0, nullptr, ws).dissipated_power;
            EXPECT_NEAR(extra, power, 1e-10 * std::abs(power));
            sample_contacts(rough, 0, wr);
            sample_contacts(plain, 0, ws);
            Vec3 friction_force = Vec3::Zero();
            double sampled = 0;
            for (std::size_t k = 0; k < rough.contacts.size(); ++k) {
                friction_force += wr.samples[k].friction_force;
                sampled += wr.samples[k].dissipated_power - ws.samples[k].dissipated_power;
                EXPECT_NEAR(wr.samples[k].friction, wr.samples[k].friction_force.norm(), 1e-12);
                EXPECT_NEAR(wr.samples[k].friction_force.dot(wr.samples[k].normal_force), 0, 1e-9);
            }
            EXPECT_LT((friction_force - on_b).norm(), 1e-12 * on_b.norm());
            EXPECT_NEAR(sampled, power, 1e-10 * std::abs(power));
        }
}

// A ball sliding along X in the bottom of its socket: mu N against it, at the contact point.
TEST(FrictionPoint, SlidingBallByHand) {
    const System system = test::compiled(bearing(JointKind::spherical, "strips", coulomb()));
    State s = initial_state(system);
    s.q[9] = -1.1e-3; // 1e-4 deep: 100 N
    s.u[6] = 0.5;     // along X
    Workspace ws = make_workspace(system);
    const VecX f = forces(system, s, ws);
    EXPECT_NEAR(f[6], -30, 1e-9);
    EXPECT_NEAR(f[8], 100, 1e-9);
    EXPECT_NEAR(f[0], 30, 1e-9);
    // the point lies below the ball's centre: the force turns the ball forwards, about +Y ... by its arm
    EXPECT_GT(f[10], 30 * 0.048);
    EXPECT_LT(f[10], 30 * 0.051);
}

// Apart, bristles only relax.
TEST(FrictionPoint, BristlesOfBodiesApartRelax) {
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name);
        const System system = test::compiled(bearing(c.kind, c.model, lugre()));
        State s = initial_state(system);
        s.u.setConstant(1);
        s.z.setConstant(2e-3);
        Workspace ws = make_workspace(system);
        EXPECT_EQ(forces(system, s, ws).segment<3>(0).norm(), 0);
        VecX source(s.z.size()), decay(s.z.size());
        state_terms(system, 0, ws, source, decay);
        EXPECT_EQ(source.norm(), 0);
        EXPECT_LT((decay.array() - 200).matrix().norm(), 1e-10);
    }
}

} // namespace
} // namespace gudgeon
