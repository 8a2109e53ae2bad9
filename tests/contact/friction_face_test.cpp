// Friction of end faces, keys and stops, in whole systems.
#include "contact/friction_face.hpp"
#include "tests/allocation_count.hpp"
#include "tests/contact/friction_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

ContactLaw spring() {
    ContactLaw law;
    law.kind = "linear";
    law.stiffness = 1e6;
    law.damping = 30;
    return law;
}

struct Case {
    std::string name;
    JointKind kind;
    Vec3 shift, turn; // of b along and about the joint axis Z, h = X
    std::function<void(Joint&, const std::optional<Friction>&)> rub;
};

void put_clearance(Joint& joint, const std::optional<Friction>& friction) {
    Clearance clearance;
    clearance.radial = 1e-3;
    clearance.radius = 0.05;
    clearance.length = 0.1;
    clearance.law = spring();
    clearance.friction = friction;
    joint.clearance = clearance;
    joint.fidelity = Fidelity::clearance;
}

void end_faces(Joint& joint, const std::optional<Friction>& friction) { put_clearance(joint, friction); }

void end_faces_on_b(Joint& joint, const std::optional<Friction>& friction) {
    put_clearance(joint, friction);
    joint.clearance->bearing_on_b = true;
    if (friction)
        joint.clearance->friction->radius = 0.7;
}

void key(Joint& joint, const std::optional<Friction>& friction) {
    put_clearance(joint, friction);
    joint.clearance->rotation = 0.02;
    joint.clearance->rotation_law = spring();
    joint.clearance->rotation_law->stiffness = 500;
}

auto stop_of(const std::string& coordinate, double limit, std::optional<double> radius) {
    return [=](Joint& joint, const std::optional<Friction>& friction) {
        Stop stop{-limit, limit, spring(), friction};
        if (friction)
            stop.friction->radius = radius;
        joint.stops[coordinate] = stop;
    };
}

// Nothing but the face or the key touches.
const std::vector<Case> cases{
    {"upper end face", JointKind::revolute, {2e-4, -3e-4, 1.3e-3}, {2e-3, -3e-3, 0.4}, end_faces},
    {"lower end face", JointKind::revolute, {2e-4, -3e-4, -1.3e-3}, {2e-3, -3e-3, 0.4}, end_faces},
    {"end face of a bearing on b",
     JointKind::revolute,
     {2e-4, -3e-4, 1.3e-3},
     {2e-3, -3e-3, 0.4},
     end_faces_on_b},
    {"key", JointKind::translation, {2e-4, -3e-4, 0.2}, {2e-3, -3e-3, 0.4}, key},
    {"key turned back", JointKind::translation, {2e-4, -3e-4, 0.2}, {2e-3, -3e-3, -0.4}, key},
    {"stop of a slide",
     JointKind::cylindrical,
     {0.01, 0.02, 0.1003},
     {0.02, -0.03, 0.4},
     stop_of("slide", 0.1, 0.3)},
    {"lower stop of u", JointKind::planar, {-0.1003, 0.3, 0.02}, {0.02, -0.03, 0.4}, stop_of("u", 0.1, {})},
    {"stop of v", JointKind::planar, {0.3, 0.1003, 0.02}, {0.02, -0.03, 0.4}, stop_of("v", 0.1, 0.2)},
    {"stop of an angle",
     JointKind::cylindrical,
     {0.01, 0.02, 0.1},
     {0.02, -0.03, -0.4004},
     stop_of("angle", 0.4, 0.3)},
};

Model rubbing(const Case& c, const std::optional<Friction>& friction) {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {free_body("a"), free_body("b")};
    Joint joint;
    joint.name = "J";
    joint.kind = c.kind;
    joint.bodies = {"a", "b"};
    joint.body_frame = true;
    joint.points = {Vec3(0.3, -0.2, 0.1), Vec3(-0.1, 0.4, 0.2)};
    joint.axes = {Vec3::UnitZ(), Vec3::UnitZ()};
    joint.references = {Vec3::UnitX(), Vec3::UnitX()};
    c.rub(joint, friction);
    model.joints = {joint};
    return model;
}

// a in general position, b shifted and turned against it, everything moving.
State pressed(const System& system, const Case& c) {
    std::mt19937 rng(5);
    State s = initial_state(system);
    const JointRecord& j = system.joints[0];
    s.q.segment<3>(0) = random_vector(rng);
    s.q.segment<4>(3) = random_orientation(rng);
    const Mat3 A = rotation(s.q.segment<4>(3));
    s.q.segment<4>(10) =
        turned(turned(s.q.segment<4>(3), Vec3(c.turn[0], c.turn[1], 0)), Vec3(0, 0, c.turn[2]));
    s.q.segment<3>(7) =
        s.q.segment<3>(0) + A * (j.a.point + c.shift) - rotation(s.q.segment<4>(10)) * j.b.point;
    for (double& u : s.u)
        u = std::uniform_real_distribution<double>(-2, 2)(rng);
    for (double& z : s.z)
        z = std::uniform_real_distribution<double>(-5e-3, 5e-3)(rng);
    return s;
}

TEST(FrictionFace, Derivatives) {
    for (const Case& c : cases)
        for (const Friction& friction : {lugre(), coulomb()}) {
            SCOPED_TRACE(c.name + ", " + friction.kind);
            const System system = compiled(rubbing(c, friction));
            EXPECT_EQ(system.friction_states() > 0, friction.kind == "lugre");
            check_derivatives(system, pressed(system, c));
        }
}

TEST(FrictionFace, BalanceAndPower) {
    for (const Case& c : cases)
        for (const Friction& friction : {lugre(), coulomb()}) {
            SCOPED_TRACE(c.name + ", " + friction.kind);
            const System plain = compiled(rubbing(c, std::nullopt)), rough = compiled(rubbing(c, friction));
            State s = pressed(rough, c);
            check_balance(plain, rough, s, false);
            if (friction.kind != "coulomb")
                continue;
            // whatever the motion, a law without bristles only takes energy
            Workspace ws = make_workspace(plain), wr = make_workspace(rough);
            std::mt19937 rng(6);
            State without = initial_state(plain);
            without.q = s.q;
            for (int k = 0; k < 20; ++k) {
                for (double& u : s.u)
                    u = std::uniform_real_distribution<double>(-2, 2)(rng);
                without.u = s.u;
                EXPECT_LT((forces(rough, s, wr) - forces(plain, without, ws)).dot(s.u), 0);
            }
        }
}

// A shaft at rest on the ground's end face, 1e-4 deep: 100 N.
struct Shaft {
    System system;
    State s;
    Workspace ws;
    explicit Shaft(const Friction& friction)
        : system(compiled(model(friction))), s(initial_state(system)), ws(make_workspace(system)) {
        s.q[2] = 1.1e-3;
    }
    static Model model(const Friction& friction) {
        Model model;
        model.gravity = Vec3::Zero();
        model.bodies = {free_body("b")};
        Joint joint;
        joint.name = "J";
        joint.kind = JointKind::revolute;
        joint.bodies = {"ground", "b"};
        joint.axes = {Vec3::UnitZ(), Vec3::UnitZ()};
        put_clearance(joint, friction);
        joint.clearance->friction->radius = 0.05;
        model.joints = {joint};
        return model;
    }
};

// Slip of 0.3 m/s sideways and of 0.4 m/s at the radius: mu N = 30 N in the ratio 3 to 4.
TEST(FrictionFace, SlidingAndTurningByHand) {
    Shaft shaft(coulomb());
    shaft.s.u << 0, 0.3, 0, 0, 0, -8;
    const VecX f = forces(shaft.system, shaft.s, shaft.ws);
    EXPECT_NEAR(f[0], 0, 1e-9);
    EXPECT_NEAR(f[1], -18, 1e-9);
    EXPECT_NEAR(f[2], -100, 1e-7);
    EXPECT_NEAR(f[5], 24 * 0.05, 1e-9);
    sample_contacts(shaft.system, 0, shaft.ws);
    const JointContact contact = joint_contacts(shaft.system, shaft.ws)[0];
    EXPECT_NEAR(contact.friction_force, 30, 1e-9); // turning counted at the radius
    EXPECT_NEAR(contact.normal_force, 100, 1e-7);
    double power = 0;
    for (const ContactSample& sample : shaft.ws.samples)
        power += sample.dissipated_power;
    EXPECT_NEAR(power, 30 * 0.5, 1e-9);
}

TEST(FrictionFace, SlidingAloneAndTurningAloneByHand) {
    Shaft shaft(coulomb());
    shaft.s.u << 0.3, 0, 0, 0, 0, 0;
    EXPECT_NEAR(forces(shaft.system, shaft.s, shaft.ws)[0], -30, 1e-9);
    shaft.s.u << 0, 0, 0, 0, 0, 8;
    EXPECT_NEAR(forces(shaft.system, shaft.s, shaft.ws)[5], -30 * 0.05, 1e-9);
    shaft.s.u << 0, 0, 0, 8, 0, 0; // tilting does not rub
    EXPECT_NEAR(forces(shaft.system, shaft.s, shaft.ws).tail<3>().norm(), 0, 1e-9);
}

TEST(FrictionFace, BristlesOfFacesApartRelax) {
    Shaft shaft(lugre());
    shaft.s.q[2] = 0;
    shaft.s.u << 1, 2, 0, 0, 0, 3;
    shaft.s.z.setConstant(2e-3);
    EXPECT_EQ(forces(shaft.system, shaft.s, shaft.ws).norm(), 0);
    VecX source(shaft.s.z.size()), decay(shaft.s.z.size());
    state_terms(shaft.system, 0, shaft.ws, source, decay);
    EXPECT_EQ(source.norm(), 0);
    EXPECT_LT((decay.array() - 200).matrix().norm(), 1e-10);
}

// Without a radius of its own the friction of end faces takes that of the bearing, of a profile its mean.
TEST(FrictionFace, RadiusOfTheBearing) {
    Clearance clearance;
    clearance.friction = coulomb();
    EXPECT_EQ(compile_friction(*clearance.friction).kinetic, 0.3);
    Model model = Shaft::model(coulomb());
    model.joints[0].clearance->friction->radius.reset();
    const auto moment = [&] {
        const System system = compiled(model);
        Workspace ws = make_workspace(system);
        State s = initial_state(system);
        s.q[2] = 1.1e-3;
        s.u << 0, 0, 0, 0, 0, 8;
        return forces(system, s, ws)[5];
    };
    model.joints[0].clearance->radius = 0.02;
    EXPECT_NEAR(moment(), -30 * 0.02, 1e-9);
    model.joints[0].clearance->radius.reset();
    model.joints[0].clearance->profile = {0.02, 0.03, 0.04};
    model.joints[0].clearance->strips = 3;
    EXPECT_NEAR(moment(), -30 * 0.03, 1e-9);
}

TEST(FrictionFace, TakesNoMemory) {
    if (!GUDGEON_COUNTS_ALLOCATIONS)
        GTEST_SKIP() << "allocations are not counted in this build";
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name);
        const System system = compiled(rubbing(c, lugre()));
        const State s = pressed(system, c);
        Workspace ws = make_workspace(system);
        VecX source(system.friction_states()), decay = source;
        const auto evaluate_all = [&] {
            evaluate_forces(system, 0, ws);
            linearise(system, 0, s.lambda.data(), ws);
            sample_contacts(system, 0, ws);
            state_terms(system, 0, ws, source, decay);
        };
        set(system, s, ws);
        evaluate_all(); // vectors grow once
        EXPECT_EQ(count_allocations(evaluate_all), 0);
    }
}

TEST(FrictionFace, SameBitsForAnyNumberOfThreads) {
    Model model;
    for (int k = 0; k < 300; ++k) {
        const Model one = Shaft::model(lugre());
        const std::string name = "b" + std::to_string(k);
        model.bodies.push_back(one.bodies[0]);
        model.bodies.back().name = name;
        model.bodies.back().velocity = {0.01 * k, 0.2, -0.1};
        model.bodies.back().angular_velocity = {0.1, 0.2, 3 - 0.02 * k};
        model.joints.push_back(one.joints[0]);
        model.joints.back().name = "J" + std::to_string(k);
        model.joints.back().bodies = {k % 3 == 2 ? "b" + std::to_string(k - 1) : "ground", name};
    }
    const System system = compiled(model);
    State state = initial_state(system);
    state.z.setConstant(1e-3);
    for (int k = 0; k < 300; ++k)
        state.q[7 * k + 2] = k % 3 == 2 ? 2.3e-3 : 1.1e-3;
    VecX first;
    std::vector<double> c, s;
    for (const int threads : {1, 2, 3}) {
        Workspace ws = make_workspace(system, threads);
        const VecX f = forces(system, state, ws);
        linearise(system, 0, state.lambda.data(), ws);
        if (threads == 1) {
            first = f;
            c = ws.lin.C;
            s = ws.lin.S;
            EXPECT_GT(first.norm(), 1);
        }
        EXPECT_EQ((f - first).cwiseAbs().maxCoeff(), 0.0) << threads;
        EXPECT_EQ(ws.lin.C, c) << threads;
        EXPECT_EQ(ws.lin.S, s) << threads;
    }
}

} // namespace
} // namespace gudgeon
