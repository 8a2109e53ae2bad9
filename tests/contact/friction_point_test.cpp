// Friction at contact points, in whole systems: a journal pressed into its bearing, both free.
#include "tests/contact/friction_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

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
            check_balance(plain, rough, pressed(rough, rng), true);
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
