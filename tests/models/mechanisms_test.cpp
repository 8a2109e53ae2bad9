// Ready mechanisms against the figures they are specified by: geometry, masses, exact starts.
#include "core/beam.hpp"
#include "core/joint_motions.hpp"
#include "models/mechanisms.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace gudgeon {
namespace {

const Body& body_of(const Model& model, const std::string& name) {
    static const Body ground = [] {
        Body body;
        body.name = "ground";
        body.fixed = true;
        return body;
    }();
    const auto it = std::find_if(model.bodies.begin(), model.bodies.end(),
                                 [&](const Body& body) { return body.name == name; });
    if (name != "ground" && it == model.bodies.end())
        throw std::runtime_error("no body " + name);
    return name == "ground" ? ground : *it;
}

const Joint& joint_of(const Model& model, const std::string& name) {
    const auto it = std::find_if(model.joints.begin(), model.joints.end(),
                                 [&](const Joint& joint) { return joint.name == name; });
    if (it == model.joints.end())
        throw std::runtime_error("no joint " + name);
    return *it;
}

template <class Kind> const Kind& force_of(const Model& model, const std::string& name) {
    for (const Force& force : model.forces)
        if (const Kind* found = std::get_if<Kind>(&force); found && found->name == name)
            return *found;
    throw std::runtime_error("no force " + name);
}

Vec3 global_point(const Body& body, const Vec3& local) {
    return body.position + rotation(body.orientation) * local;
}

Vec3 global_spin(const Body& body) { return rotation(body.orientation) * body.angular_velocity; }

Vec3 point_velocity(const Body& body, const Vec3& point) {
    return body.velocity + global_spin(body).cross(point - body.position);
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance, const std::string& what) {
    EXPECT_LE((a - b).norm(), tolerance) << what << ": " << a.transpose() << " and " << b.transpose();
}

/// What the joint would let through: residuals of position and velocity of a perfect joint.
void expect_closed(const Model& model, const Joint& joint) {
    SCOPED_TRACE(model.name + " " + joint.name);
    const Body &a = body_of(model, joint.bodies[0]), &b = body_of(model, joint.bodies[1]);
    ASSERT_FALSE(joint.body_frame);
    const Vec3 gap = joint.points[1] - joint.points[0];
    const Vec3 speed = point_velocity(b, joint.points[1]) - point_velocity(a, joint.points[0]);
    const Vec3 spin = global_spin(b) - global_spin(a);
    const Vec3 axis_a = joint.axes ? (*joint.axes)[0] : Vec3::Zero();
    const Vec3 axis_b = joint.axes ? (*joint.axes)[1] : Vec3::Zero();
    const auto across = [&](const Vec3& v) { return v.cross(axis_a).norm(); };
    const double eps = 1e-14;
    switch (joint.kind) {
    case JointKind::distance:
        EXPECT_GT(gap.norm(), 0);
        EXPECT_NEAR(gap.dot(speed), 0, eps);
        return;
    case JointKind::planar:
        EXPECT_NEAR(gap.dot(axis_a), 0, eps);
        EXPECT_NEAR(speed.dot(axis_a), 0, eps);
        EXPECT_LE(across(spin), eps);
        return;
    case JointKind::cylindrical:
    case JointKind::translation:
        EXPECT_LE(across(gap), eps);
        EXPECT_LE(across(speed), eps);
        EXPECT_LE(joint.kind == JointKind::translation ? spin.norm() : across(spin), eps);
        break;
    case JointKind::universal:
        EXPECT_NEAR(axis_a.dot(axis_b), 0, eps);
        // axis_a turns with a, axis_b with b.
        EXPECT_NEAR(global_spin(a).cross(axis_a).dot(axis_b) + axis_a.dot(global_spin(b).cross(axis_b)), 0,
                    eps);
        EXPECT_NEAR(axis_b.norm(), 1, eps);
        [[fallthrough]];
    case JointKind::spherical:
    case JointKind::revolute:
    case JointKind::rigid:
        EXPECT_LE(gap.norm(), eps);
        EXPECT_LE(speed.norm(), eps);
        break;
    default:
        FAIL() << "no check for this kind";
    }
    if (joint.kind == JointKind::revolute) {
        EXPECT_LE(across(spin), eps);
    }
    if (joint.axes) {
        EXPECT_NEAR(axis_a.norm(), 1, eps);
        if (joint.kind != JointKind::universal)
            expect_near(axis_a, axis_b, 0, "axes");
    }
}

double kinetic(const Model& model) {
    double sum = 0;
    for (const Body& body : model.bodies)
        sum += 0.5 * body.mass * body.velocity.squaredNorm() +
               0.5 * body.angular_velocity.dot(body.inertia * body.angular_velocity);
    return sum;
}

double potential(const Model& model) {
    double sum = 0;
    for (const Body& body : model.bodies)
        sum -= body.mass * model.gravity.dot(body.position);
    return sum;
}

/// Every mechanism with its defaults and with each choice of each parameter.
std::vector<Model> every_variant() {
    std::vector<Model> models;
    for (const Mechanism& mechanism : mechanisms()) {
        models.push_back(build_mechanism(mechanism.name));
        for (const MechanismParameter& p : mechanism.parameters)
            for (const std::string& choice : p.choices)
                models.push_back(build_mechanism(mechanism.name, {{p.name, choice}}));
    }
    return models;
}

TEST(Mechanisms, ListsTheOnesOfTheContract) {
    std::vector<std::string> names;
    for (const Mechanism& m : mechanisms())
        names.push_back(m.name);
    EXPECT_EQ(names, (std::vector<std::string>{"pendulum", "chain", "four-bar", "slider-crank", "heavy-top",
                                               "triple-pendulum", "suspension-chain", "hmmwv-corner",
                                               "bouncing-journal", "tilted-journal", "stick-slip", "rsup"}));
    EXPECT_EQ(find_mechanism("no such"), nullptr);
    const std::vector<double> ends{10, 1, 10, 5, 2, 4, 5, 5, 1, 0.2, 40, 5};
    for (std::size_t i = 0; i < names.size(); ++i) {
        const Model model = build_mechanism(names[i]);
        EXPECT_EQ(model.end, ends[i]) << names[i];
        EXPECT_GT(model.every.value(), 0) << names[i];
        EXPECT_EQ(model.name, names[i]);
        EXPECT_EQ(model.gravity, Vec3(0, 0, -9.81));
    }
    EXPECT_EQ(build_mechanism("suspension-chain").every, 0.05);
}

TEST(Mechanisms, EveryVariantStartsClosedWithPossibleBodies) {
    for (Model model : every_variant()) {
        expand_beams(model);
        std::set<std::string> names;
        for (const Body& body : model.bodies) {
            EXPECT_TRUE(names.insert(body.name).second) << body.name;
            EXPECT_NEAR(body.orientation.norm(), 1, 1e-15) << body.name;
            EXPECT_GE(body.orientation[0], 0) << body.name;
            if (body.fixed)
                continue;
            EXPECT_GT(body.mass, 0) << body.name;
            const Vec3 i = body.inertia.diagonal();
            EXPECT_GT(i.minCoeff(), 0) << body.name;
            EXPECT_LE(2 * i.maxCoeff(), i.sum() * (1 + 1e-12)) << model.name << " " << body.name;
        }
        names.clear();
        for (const Joint& joint : model.joints) {
            EXPECT_TRUE(names.insert(joint.name).second) << joint.name;
            if (joint.piece)
                continue; // tests/core/beam_test.cpp
            EXPECT_EQ(holds_any(joint, Fidelity::bushing), joint.bushing.has_value()) << joint.name;
            EXPECT_EQ(holds_any(joint, Fidelity::clearance), joint.clearance.has_value()) << joint.name;
            if (holds_any(joint, Fidelity::clearance))
                EXPECT_EQ(joint.points[0], joint.points[1]) << joint.name; // centred
            else
                expect_closed(model, joint);
        }
    }
}

TEST(Mechanisms, PendulumStartsHorizontal) {
    const Model model = build_mechanism("pendulum");
    ASSERT_EQ(model.bodies.size(), 1u);
    const Body& bob = body_of(model, "bob");
    EXPECT_EQ(bob.mass, 1);
    EXPECT_EQ(bob.inertia, Mat3(0.01 * Mat3::Identity()));
    EXPECT_EQ(bob.position, Vec3(-1, 0, 0));
    const Joint& rod = joint_of(model, "rod");
    EXPECT_EQ(rod.kind, JointKind::distance);
    EXPECT_EQ(rod.points[0], Vec3(0, 0, 0));
    EXPECT_EQ(rod.points[1], bob.position);
    EXPECT_EQ((*joint_of(model, "plane").axes)[0], Vec3::UnitY());
}

TEST(Mechanisms, ChainLinksMeetEndToEnd) {
    for (const char* kind : {"revolute", "spherical", "universal"}) {
        const Model model = build_mechanism("chain", {{"links", "4"}, {"joint", kind}, {"thin", "1"}});
        ASSERT_EQ(model.bodies.size(), 4u);
        ASSERT_EQ(model.joints.size(), 4u);
        for (int k = 1; k <= 4; ++k) {
            const Body& link = body_of(model, "link" + std::to_string(k));
            const Joint& joint = joint_of(model, "J" + std::to_string(k));
            EXPECT_EQ(joint.bodies[0], k == 1 ? "ground" : "link" + std::to_string(k - 1));
            EXPECT_EQ(joint.bodies[1], link.name);
            expect_near(joint.points[1], global_point(link, {-0.5, 0, 0}), 0, "start of the link");
            EXPECT_EQ(link.inertia.diagonal(), Vec3(5e-5, 1.0 / 12, 1.0 / 12));
            EXPECT_EQ(link.mass, 1);
        }
        EXPECT_EQ(model.parameters, (std::map<std::string, double>{{"links", 4}, {"thin", 1}}));
    }
    const Model universal = build_mechanism("chain", {{"joint", "universal"}});
    EXPECT_EQ(universal.bodies.size(), 10u);
    EXPECT_EQ((*joint_of(universal, "J3").axes)[0], Vec3::UnitY());
    EXPECT_EQ((*joint_of(universal, "J3").axes)[1], Vec3::UnitZ());
    EXPECT_DOUBLE_EQ(body_of(universal, "link7").inertia(1, 1), (1 + 3e-4) / 12);
    EXPECT_EQ((*joint_of(build_mechanism("chain"), "J3").axes)[0], Vec3::UnitY());
    EXPECT_EQ(universal.markers.at(0).point, Vec3(10, 0, 0));
}

TEST(Mechanisms, FourBarTurnsAboutPlusY) {
    const Model model = build_mechanism("four-bar", {{"loops", "3"}});
    EXPECT_EQ(model.bodies.size(), 7u);
    EXPECT_EQ(model.joints.size(), 10u);
    for (int k = 0; k <= 3; ++k) {
        const Body& crank = body_of(model, "crank" + std::to_string(k));
        const Vec3 foot(k, 0, 0), top(k, 0, 1);
        expect_near(global_point(crank, {-0.5, 0, 0}), foot, 1e-15, "foot");
        expect_near(global_point(crank, {0.5, 0, 0}), top, 1e-15, "top");
        // B0 = (sin a, 0, cos a) with a' = 1.
        expect_near(point_velocity(crank, top), {1, 0, 0}, 1e-15, "speed of the top");
        if (k > 0) {
            const Body& coupler = body_of(model, "coupler" + std::to_string(k));
            expect_near(global_point(coupler, {-0.5, 0, 0}), {k - 1.0, 0, 1}, 0, "left end");
            EXPECT_EQ(coupler.velocity, Vec3(1, 0, 0));
        }
    }
    EXPECT_EQ(joint_of(model, "B0").points[0], Vec3(0, 0, 1));
    EXPECT_EQ(joint_of(model, "B0").bodies, (std::array<std::string, 2>{"crank0", "coupler1"}));
    // (N + 1) cranks of 1/3 kg m2 about their feet and N couplers at 1 m/s.
    EXPECT_NEAR(kinetic(model), 0.5 * 4 / 3 + 0.5 * 3, 1e-14);
}

TEST(Mechanisms, SliderCrankHasTheExactStart) {
    const Model model = build_mechanism("slider-crank");
    const Body &crank = body_of(model, "crank"), &rod = body_of(model, "rod"),
               &slider = body_of(model, "slider");
    expect_near(global_point(crank, {0, 0, -0.04}), {0, 0.1, 0.12}, 1e-16, "A");
    expect_near(global_point(crank, {0, 0, 0.04}), {0, 0.1, 0.2}, 1e-16, "B on the crank");
    expect_near(global_point(rod, {-0.15, 0, 0}), {0, 0.1, 0.2}, 1e-16, "B on the rod");
    expect_near(global_point(rod, {0.15, 0, 0}), {0.2, 0, 0}, 1e-16, "C");
    EXPECT_EQ(slider.position, Vec3(0.2, 0, 0));
    const Vec4 p(0.8884507093343060, -0.2097347620608031, 0.3973272361458831, -0.0937962370425400);
    EXPECT_LE((rod.orientation - p).norm(), 1e-15);
    expect_near(rod.angular_velocity, {-1.6, -1.0733126291999, 1.4310835055999}, 1e-13, "rod omega");
    const Vec3 axis2 = rotation(rod.orientation) * Vec3(0, 0.8, 0.6);
    expect_near((*joint_of(model, "C").axes)[1], axis2, 1e-15, "rod side of the universal joint");
    EXPECT_EQ((*joint_of(model, "C").axes)[0], Vec3::UnitZ());
    EXPECT_EQ(joint_of(model, "C").bodies, (std::array<std::string, 2>{"slider", "rod"}));
    EXPECT_EQ(joint_of(model, "B").bodies, (std::array<std::string, 2>{"crank", "rod"}));
    // Energy of the reference solution.
    EXPECT_NEAR(kinetic(model) + potential(model), 0.76662, 1e-15);
}

TEST(Mechanisms, HeavyTopLeansTowardsX) {
    const Model model = build_mechanism("heavy-top");
    const Body& top = body_of(model, "top");
    expect_near(top.position, {0.25980762113533157, 0, 0.15}, 1e-16, "mass centre");
    EXPECT_LE((top.orientation - Vec4(0.8660254037844386, 0, 0.5, 0)).norm(), 1e-15);
    EXPECT_EQ(top.inertia.diagonal(), Vec3(0.02, 0.02, 0.01));
    EXPECT_EQ(top.angular_velocity, Vec3(0, 0, 40));
    expect_near(global_point(top, {0, 0, -0.3}), {0, 0, 0}, 1e-15, "O");

    const Model other = build_mechanism("heavy-top", {{"mass", "2"}, {"length", "0.5"}, {"tilt", "-0.1"}});
    EXPECT_EQ(body_of(other, "top").mass, 2);
    expect_near(body_of(other, "top").position, {-0.5 * std::sin(0.1), 0, 0.5 * std::cos(0.1)}, 1e-16,
                "centre");
    EXPECT_EQ(other.parameters.at("tilt"), -0.1);
    EXPECT_EQ(other.parameters.size(), 6u);
}

TEST(Mechanisms, TriplePendulumIsTableThree) {
    const Model model = build_mechanism("triple-pendulum");
    for (int k = 1; k <= 3; ++k) {
        const Body& body = body_of(model, "body" + std::to_string(k));
        const Joint& joint = joint_of(model, "J" + std::to_string(k));
        expect_near(global_point(body, {-0.3, 0, 0}), joint.points[1], 1e-15, "0.3 m beyond the joint");
        const double scale = k == 1 ? 1 : k == 2 ? 0.4 : 0.2;
        EXPECT_DOUBLE_EQ(body.mass, 0.1 * scale);
        expect_near(body.inertia.diagonal(), scale * Vec3(3e-3, 3e-2, 3e-2), 1e-17, "inertia");
    }
    EXPECT_EQ(joint_of(model, "J2").kind, JointKind::cylindrical);
    expect_near((*joint_of(model, "J2").axes)[0],
                rotation(body_of(model, "body1").orientation) * Vec3::UnitZ(), 0, "zeta of body 1");
    const Vec3 zeta3 = rotation(body_of(model, "body3").orientation) * Vec3::UnitZ();
    expect_near((*joint_of(model, "J3").axes)[0], zeta3, 1e-15, "zeta of body 3");
    expect_near(zeta3, {0, std::sqrt(0.5), std::sqrt(0.5)}, 1e-15, "45 degrees");
    EXPECT_NEAR(body_of(model, "body3").orientation[1], -0.383, 5e-4);
}

TEST(Mechanisms, SuspensionChainHasTheHardpoints) {
    const Model model = build_mechanism("suspension-chain", {{"units", "3"}});
    EXPECT_EQ(model.bodies.size(), 21u);
    EXPECT_EQ(model.joints.size(), 3 * 8 + 2u);
    EXPECT_EQ(model.forces.size(), 3 * 6u);
    double mass = 0;
    for (const Body& body : model.bodies) {
        mass += body.mass;
        EXPECT_EQ(body.orientation, Vec4(1, 0, 0, 0));
    }
    EXPECT_DOUBLE_EQ(mass, 3 * 478); // 2 x 239 kg on each pair of tyres

    const auto expect_joint = [&](const std::string& name, const std::string& a, const std::string& b,
                                  const Vec3& left, const Vec3& centre_b) {
        for (const int side : {1, -1}) {
            const std::string tag = side > 0 ? "1L" : "1R";
            const Vec3 point(left.x() - 2, left.y() * side, left.z());
            const Joint& joint = joint_of(model, name + tag);
            EXPECT_EQ(joint.points[0], point) << name << tag;
            EXPECT_EQ(joint.bodies[0], a == "chassis" ? "chassis1" : a + tag);
            EXPECT_EQ(joint.bodies[1], b + tag);
            EXPECT_EQ(body_of(model, b + tag).position,
                      Vec3(centre_b.x() - 2, centre_b.y() * side, centre_b.z()));
        }
    };
    const Vec3 lower(0, 0.575, 0.21), upper(-0.02, 0.575, 0.47), upright(0, 0.80, 0.34);
    expect_joint("LI", "chassis", "lower", {0, 0.40, 0.22}, lower);
    expect_joint("LO", "lower", "upright", {0, 0.75, 0.20}, upright);
    expect_joint("UI", "chassis", "upper", {-0.02, 0.45, 0.46}, upper);
    expect_joint("UO", "upper", "upright", {-0.02, 0.70, 0.48}, upright);
    EXPECT_EQ(body_of(model, "chassis2").inertia.diagonal(), Vec3(40, 200, 220));
    EXPECT_EQ(body_of(model, "chassis2").position, Vec3(-4, 0, 0.28));
    EXPECT_EQ(body_of(model, "lower2R").inertia.diagonal(), Vec3(0.06, 0.03, 0.08));
    EXPECT_EQ(body_of(model, "upper2R").inertia.diagonal(), Vec3(0.025, 0.02, 0.04));
    EXPECT_EQ(body_of(model, "upright2R").inertia.diagonal(), Vec3(0.8, 1.2, 0.8));

    const auto& tie = force_of<SpringDamper>(model, "tie1R");
    EXPECT_EQ(tie.points[0], Vec3(-1.85, -0.42, 0.26));
    EXPECT_EQ(tie.points[1], Vec3(-1.85, -0.74, 0.25));
    EXPECT_NEAR(tie.free_length.value(), std::hypot(0.32, 0.01), 1e-16);
    EXPECT_EQ(tie.stiffness, 2e7);
    EXPECT_EQ(tie.damping, 1e3);
    EXPECT_EQ(tie.bodies, (std::array<std::string, 2>{"chassis1", "upright1R"}));
    const auto& coil = force_of<SpringDamper>(model, "coil0L");
    EXPECT_EQ(coil.stiffness, 3e4);
    EXPECT_EQ(coil.damping, 3e3);
    EXPECT_EQ(coil.bodies, (std::array<std::string, 2>{"chassis0", "lower0L"}));
    EXPECT_EQ(coil.points[0], Vec3(0, 0.50, 0.62));
    EXPECT_EQ(coil.points[1], Vec3(0, 0.62, 0.212));
    // Compressed by 3400 N at the start.
    EXPECT_NEAR(coil.stiffness * (std::hypot(0.12, 0.408) - coil.free_length.value()), -3400, 1e-9);
}

TEST(Mechanisms, SuspensionChainHasTheElements) {
    const Model model = build_mechanism("suspension-chain", {{"units", "2"}});
    const Joint& inner = joint_of(model, "UI1L");
    EXPECT_EQ(inner.kind, JointKind::revolute);
    EXPECT_EQ((*inner.axes)[0], Vec3::UnitX());
    EXPECT_TRUE(inner.bushing.value().global_axes);
    EXPECT_EQ(inner.bushing->stiffness, (std::array<double, 6>{5e6, 5e6, 5e6, 100, 1e4, 1e4}));
    EXPECT_EQ(inner.bushing->damping, (std::array<double, 6>{1e3, 1e3, 1e3, 1, 10, 10}));

    const Joint& link = joint_of(model, "link1");
    EXPECT_EQ(link.bodies, (std::array<std::string, 2>{"chassis0", "chassis1"}));
    expect_near(link.points[0], global_point(body_of(model, "chassis0"), {-1, 0, 0}), 0, "rear end");
    expect_near(link.points[1], global_point(body_of(model, "chassis1"), {1, 0, 0}), 0, "front end");
    EXPECT_EQ(link.bushing.value().stiffness, (std::array<double, 6>{1e6, 1e6, 1e6, 1e5, 1e5, 1e5}));
    EXPECT_EQ(link.bushing->damping, (std::array<double, 6>{2e3, 2e3, 2e3, 5e2, 5e2, 5e2}));

    const auto& tyre = force_of<Tyre>(model, "tyre1L");
    EXPECT_DOUBLE_EQ(tyre.preload, 239 * 9.81);
    EXPECT_EQ(tyre.reference, 0.34);
    EXPECT_EQ(tyre.stiffness, 2e5);
    EXPECT_EQ(tyre.damping, 200);
    EXPECT_EQ(tyre.point, body_of(model, "upright1L").position);
    const auto& road = std::get<HarmonicFunction>(tyre.road.value());
    for (const double t : {0.0, 0.1, 0.37})
        EXPECT_NEAR(road.offset + road.amplitude * std::sin(2 * pi * road.frequency * t + road.phase),
                    0.02 * std::sin(4 * pi * t - 0.5), 1e-16);

    const Model perfect = build_mechanism("suspension-chain", {{"units", "2"}, {"joints", "perfect"}});
    EXPECT_EQ(joint_of(perfect, "LI0L").fidelity, Fidelity::perfect);
    EXPECT_EQ(joint_of(perfect, "link1").fidelity, Fidelity::bushing);
    EXPECT_EQ(joint_of(perfect, "tie1R").kind, JointKind::distance);
    EXPECT_EQ(joint_of(perfect, "tie1R").points[1], Vec3(-1.85, -0.74, 0.25));
    EXPECT_EQ(perfect.forces.size(), 2 * 4u);
}

void expect_law(const ContactLaw& law, double stiffness, double restitution) {
    EXPECT_EQ(law.kind, "lankarani-nikravesh");
    EXPECT_EQ(law.stiffness, stiffness);
    EXPECT_EQ(law.exponent, 1.5);
    EXPECT_EQ(law.restitution, restitution);
}

TEST(Mechanisms, SliderCrankLoosensOneJoint) {
    const Model ball = build_mechanism("slider-crank", {{"joint", "spherical"}});
    const Joint& b = joint_of(ball, "B");
    EXPECT_EQ(b.fidelity, Fidelity::clearance);
    EXPECT_EQ(b.clearance.value().radial, 1e-4);
    expect_law(b.clearance->law, 5e6, 0.75);
    EXPECT_EQ(joint_of(ball, "A").fidelity, Fidelity::perfect);
    EXPECT_EQ(ball.parameters.at("stiffness"), 5e6);

    const Model worn = build_mechanism("slider-crank", {{"joint", "revolute"}, {"clearance", "1e-3"}});
    const Joint& a = joint_of(worn, "A");
    EXPECT_EQ(a.fidelity, Fidelity::clearance);
    EXPECT_EQ(a.kind, JointKind::revolute);
    EXPECT_EQ(a.bodies, (std::array<std::string, 2>{"ground", "crank"}));
    EXPECT_FALSE(a.clearance.value().bearing_on_b);
    EXPECT_EQ((*a.axes)[0], Vec3::UnitX());
    EXPECT_EQ(a.clearance->radial, 1e-3);
    EXPECT_EQ(a.clearance->axial, 1e-3);
    EXPECT_EQ(a.clearance->radius, 0.01);
    EXPECT_EQ(a.clearance->length, 0.04);
    EXPECT_EQ(a.clearance->strips, 8);
    EXPECT_FALSE(a.clearance->axial_law); // that of the radial contact, with its whole stiffness
    expect_law(a.clearance->law, 5e7, 0.75);
    EXPECT_EQ(joint_of(worn, "B").fidelity, Fidelity::perfect);
    EXPECT_EQ(worn.parameters.at("stiffness"), 5e7);

    const Model other = build_mechanism("slider-crank", {{"joint", "revolute"},
                                                         {"stiffness", "3e6"},
                                                         {"restitution", "0.9"},
                                                         {"length", "0.02"},
                                                         {"strips", "5"}});
    expect_law(joint_of(other, "A").clearance->law, 3e6, 0.9);
    EXPECT_EQ(joint_of(other, "A").clearance->length, 0.02);
    EXPECT_EQ(joint_of(other, "A").clearance->strips, 5);
}

TEST(Mechanisms, TriplePendulumStops) {
    const Model model = build_mechanism("triple-pendulum");
    const Stop& slide = joint_of(model, "J2").stops.at("slide");
    const Stop& angle = joint_of(model, "J3").stops.at("angle");
    EXPECT_EQ(joint_of(model, "J2").stops.size(), 1u);
    EXPECT_EQ(slide.lower, -0.25);
    EXPECT_EQ(slide.upper, 0.25);
    expect_law(slide.law, 1e5, 0.75);
    EXPECT_EQ(angle.lower, -pi / 4);
    EXPECT_EQ(angle.upper, pi / 4);
    expect_law(angle.law, 1e3, 0.75);

    const Model soft = build_mechanism("triple-pendulum", {{"law", "kelvin-voigt"}});
    const ContactLaw& law = joint_of(soft, "J3").stops.at("angle").law;
    EXPECT_EQ(law.kind, "kelvin-voigt");
    EXPECT_EQ(law.stiffness, 1e3);
    EXPECT_EQ(law.restitution, 0.01);
    EXPECT_EQ(law.speed, 0.1);
    EXPECT_EQ(joint_of(soft, "J2").stops.at("slide").law.stiffness, 1e5);
    EXPECT_TRUE(joint_of(build_mechanism("triple-pendulum", {{"stops", "0"}}), "J2").stops.empty());
}

TEST(Mechanisms, SuspensionChainWithBearings) {
    const Model loose = build_mechanism("suspension-chain",
                                        {{"joints", "clearance"}, {"clearance", "2e-4"}, {"strips", "4"}});
    for (const char* name : {"LI0L", "LI0R", "UI0L", "UI0R"}) {
        const Joint& joint = joint_of(loose, name);
        EXPECT_EQ(joint.fidelity, Fidelity::clearance) << name;
        EXPECT_EQ(joint.bodies[0], "chassis0");
        EXPECT_FALSE(joint.clearance.value().bearing_on_b);
        EXPECT_EQ(joint.clearance->radius, 0.006);
        EXPECT_EQ(joint.clearance->length, 0.04);
        EXPECT_EQ(joint.clearance->radial, 2e-4);
        EXPECT_EQ(joint.clearance->axial, 2e-4);
        EXPECT_EQ(joint.clearance->strips, 4);
        expect_law(joint.clearance->law, 1e9, 0.8);
    }
    EXPECT_EQ(force_of<SpringDamper>(loose, "tie0R").stiffness, 2e7);
    const Model mixed = build_mechanism("suspension-chain", {{"joints", "mixed"}});
    EXPECT_EQ(joint_of(mixed, "LI0L").fidelity, Fidelity::bushing);
    EXPECT_EQ(joint_of(mixed, "UI0L").fidelity, Fidelity::clearance);
    EXPECT_EQ(joint_of(mixed, "UI0L").clearance->strips, 16);
    EXPECT_EQ(force_of<SpringDamper>(mixed, "tie0R").stiffness, 2e7);
}

TEST(Mechanisms, JournalsStartCentred) {
    const Model bouncing = build_mechanism("bouncing-journal");
    const Clearance& wide = joint_of(bouncing, "bearing").clearance.value();
    EXPECT_EQ(wide.radial, 1e-3);
    EXPECT_EQ(wide.radius, 0.011);
    EXPECT_EQ(wide.length, 0.02);
    EXPECT_EQ(wide.strips, 8);
    expect_law(wide.law, 5e6, 0.75);
    const Model steel = build_mechanism("bouncing-journal", {{"law", "cylinder"}});
    const ContactLaw& law = joint_of(steel, "bearing").clearance->law;
    EXPECT_EQ(law.kind, "cylinder");
    EXPECT_FALSE(law.stiffness);
    for (const Material& side : law.materials.value()) {
        EXPECT_EQ(side.young, 207e9);
        EXPECT_EQ(side.poisson, 0.3);
    }

    const Model tilted = build_mechanism("tilted-journal");
    const Body& journal = body_of(tilted, "journal");
    const Vec4 p(0.49561769378289866, 0.50434422928127265, 0.50434422928127265, 0.49561769378289866);
    EXPECT_LE((journal.orientation - p).norm(), 1e-15); // the reference's start
    EXPECT_EQ(journal.inertia.diagonal(), Vec3(4e-3, 4e-3, 2e-4));
    EXPECT_EQ(journal.velocity, Vec3(0.01, 0.03, 0));
    EXPECT_EQ(journal.angular_velocity, Vec3(0.4, 0.3, 50));
    const Joint& bearing = joint_of(tilted, "bearing");
    expect_near((*bearing.axes)[0], Vec3::UnitX(), 0, "bearing");
    const double tilt = pi / 180; // about +Y: the axis dips
    expect_near((*bearing.axes)[1], {std::cos(tilt), 0, -std::sin(tilt)}, 1e-15, "journal");
    EXPECT_EQ(bearing.clearance.value().strips, 16);
    EXPECT_EQ(bearing.clearance->radial, 5e-4);
    expect_law(bearing.clearance->law, 1e8, 0.8);
    const Model other = build_mechanism("tilted-journal", {{"ty", "0"}, {"tz", "2"}, {"tilt", "0.1"}});
    expect_near((*joint_of(other, "bearing").axes)[1], {std::cos(0.1), std::sin(0.1), 0}, 1e-15, "about Z");
    EXPECT_THROW(build_mechanism("tilted-journal", {{"ty", "0"}}), ModelError);
}

/// Corner moved by the angle of its lower arm, worked out from distances alone.
class CornerByDistances {
  public:
    /// Potential energy of weights and a constant tyre force, and the spring's length.
    std::pair<double, double> at(double angle) const {
        const Vec3 l = turned_about(lower_front, lower_back, angle, lower_ball);
        Vec4 unknowns(0, tie_outer.x(), tie_outer.y(), tie_outer.z()); // upper angle, tie rod end
        for (int i = 0; i < 20; ++i) {
            const Vec4 f = lengths(l, unknowns);
            Eigen::Matrix4d slope;
            for (int j = 0; j < 4; ++j) {
                const Vec4 step = 1e-6 * Vec4::Unit(j);
                slope.col(j) = (lengths(l, unknowns + step) - lengths(l, unknowns - step)) / 2e-6;
            }
            unknowns -= slope.partialPivLu().solve(f);
        }
        const Vec3 t = unknowns.tail<3>();
        const Vec3 u = turned_about(upper_front, upper_back, unknowns[0], upper_ball);
        const Mat3 turn = triad(l, u, t) * triad(lower_ball, upper_ball, tie_outer).transpose();
        const auto carried = [&](const Vec3& point) -> Vec3 { return l + turn * (point - lower_ball); };
        const double upper_z = turned_about(upper_front, upper_back, unknowns[0], {-0.106, 0.589, 0.218}).z();
        const double lower_z = turned_about(lower_front, lower_back, angle, {0, 0.547, -0.059}).z();
        const double spindle_z = carried({-0.040, 0.910, -0.026}).z();
        const double weights =
            9.81 * ((14.705 + 18.8) * spindle_z + 19.450 * carried({-0.040, 0.751, -0.026}).z() +
                    5.813 * upper_z + 23.965 * lower_z + 6 * (t.z() + tie_inner.z()) / 2);
        const Vec3 spring_end = turned_about(lower_front, lower_back, angle, {0.097, 0.543, -0.047});
        return {weights - 5000 * spindle_z, (spring_end - Vec3(0.104, 0.510, 0.197)).norm()};
    }

  private:
    const Vec3 upper_front{-0.048, 0.446, 0.245}, upper_back{-0.268, 0.478, 0.196};
    const Vec3 upper_ball{-0.053, 0.716, 0.215}, lower_ball{-0.036, 0.787, -0.118};
    const Vec3 lower_front{0.223, 0.307, 0}, lower_back{-0.223, 0.307, 0};
    const Vec3 tie_inner{-0.250, 0.448, 0.054}, tie_outer{-0.176, 0.821, -0.016};

    static Vec3 turned_about(const Vec3& front, const Vec3& back, double angle, const Vec3& point) {
        return back + Eigen::AngleAxisd(angle, (front - back).normalized()) * (point - back);
    }
    static Mat3 triad(const Vec3& o, const Vec3& a, const Vec3& b) {
        Mat3 m;
        m.col(0) = (a - o).normalized();
        m.col(1) = (a - o).cross(b - o).normalized();
        m.col(2) = m.col(0).cross(m.col(1));
        return m;
    }
    Vec4 lengths(const Vec3& l, const Vec4& unknowns) const {
        const Vec3 u = turned_about(upper_front, upper_back, unknowns[0], upper_ball), t = unknowns.tail<3>();
        return {(u - l).norm() - (upper_ball - lower_ball).norm(),
                (t - l).norm() - (tie_outer - lower_ball).norm(),
                (t - u).norm() - (tie_outer - upper_ball).norm(),
                (t - tie_inner).norm() - (tie_outer - tie_inner).norm()};
    }
};

TEST(Mechanisms, HmmwvSpringBalancesTheTyre) {
    // Virtual work: dV + tension dl = 0 for the one motion perfect joints leave.
    const CornerByDistances corner;
    const auto [up, length_up] = corner.at(1e-4);
    const auto [down, length_down] = corner.at(-1e-4);
    const double tension = -(up - down) / (length_up - length_down);
    EXPECT_LT(tension, -5000); // the wheel is farther out than the spring
    for (const char* joints : {"bushing", "perfect"}) {
        const Model model = build_mechanism("hmmwv-corner", {{"joints", joints}});
        const auto& spring = force_of<SpringDamper>(model, "spring");
        EXPECT_NEAR(spring.preload.value(), tension, 1e-6 * std::abs(tension));
        EXPECT_FALSE(spring.free_length);
        EXPECT_EQ(spring.stiffness, 1.2e5);
    }
}

TEST(Mechanisms, HmmwvCornerIsTheVehiclesData) {
    const Model model = build_mechanism("hmmwv-corner");
    EXPECT_TRUE(body_of(model, "chassis").fixed);
    EXPECT_DOUBLE_EQ(body_of(model, "spindle").mass, 33.505);
    expect_near(body_of(model, "spindle").inertia.diagonal(), {0.50457, 0.69782, 0.50457}, 1e-15, "wheel");
    EXPECT_EQ(body_of(model, "lower_arm").inertia.diagonal(), Vec3(0.4, 0.4, 0.8));
    EXPECT_EQ(body_of(model, "upper_arm").inertia.diagonal(), Vec3(0.03, 0.03, 0.06));

    EXPECT_EQ(body_of(model, "upright").inertia.diagonal(), Vec3(0.1656, 0.1934, 0.04367));

    const Body& rod = body_of(model, "tie_rod");
    EXPECT_EQ(rod.mass, 6);
    EXPECT_EQ(rod.inertia.diagonal(), Vec3(0.5, 0.5, 0.05));
    const double length = Vec3(0.074, 0.373, -0.070).norm();
    expect_near(global_point(rod, {0, 0, -length / 2}), {-0.250, 0.448, 0.054}, 1e-15, "chassis end");
    expect_near(global_point(rod, {0, 0, length / 2}), {-0.176, 0.821, -0.016}, 1e-15, "upright end");

    const Joint& upper = joint_of(model, "upper_hinge");
    expect_near(upper.points[0], {-0.158, 0.462, 0.2205}, 1e-15, "middle of the hinge");
    expect_near((*upper.axes)[0], Vec3(0.22, -0.032, 0.049).normalized(), 1e-15, "hinge line");
    EXPECT_EQ(upper.bushing.value().stiffness, (std::array<double, 6>{7e7, 7e7, 7e7, 1e5, 1e5, 0}));
    EXPECT_EQ(upper.bushing->damping, (std::array<double, 6>{3.5e4, 3.5e4, 3.5e4, 500, 500, 0}));
    EXPECT_EQ(joint_of(model, "lower_hinge").points[0], Vec3(0, 0.307, 0));
    EXPECT_EQ((*joint_of(model, "wheel_bearing").axes)[0], Vec3::UnitY());

    const auto& damper = force_of<SpringDamper>(model, "damper");
    EXPECT_EQ(damper.damping, 19015.5692);
    EXPECT_EQ(damper.stiffness, 0);
    EXPECT_EQ(damper.points[0], Vec3(0.104, 0.498, 0.323));
    EXPECT_EQ(damper.points[1], Vec3(0.097, 0.543, -0.047));
    const auto& tyre = force_of<Tyre>(model, "tyre");
    EXPECT_EQ(tyre.preload, 5000);
    EXPECT_EQ(tyre.stiffness, 3e5);
    EXPECT_EQ(tyre.damping, 500);
    EXPECT_EQ(tyre.body, "spindle");
    EXPECT_EQ(tyre.point, body_of(model, "spindle").position);
    EXPECT_EQ(tyre.reference, -0.026);
    EXPECT_EQ(std::get<HarmonicFunction>(tyre.road.value()).frequency, 2);
    EXPECT_EQ(joint_of(build_mechanism("hmmwv-corner", {{"joints", "perfect"}}), "upper_hinge").fidelity,
              Fidelity::perfect);
}

TEST(Mechanisms, ProgressiveSpringIsOddAndPushesBack) {
    const Table table = hmmwv_progressive_spring();
    ASSERT_EQ(table.x.size(), 21u);
    ASSERT_EQ(table.y.size(), 21u);
    EXPECT_TRUE(std::is_sorted(table.x.begin(), table.x.end()));
    for (std::size_t i = 0; i < 21; ++i) {
        EXPECT_EQ(table.x[i], -table.x[20 - i]);
        EXPECT_EQ(table.y[i], -table.y[20 - i]);
    }
    EXPECT_EQ(table.x[15], 0.10);
    EXPECT_EQ(table.y[15], 52791.592); // lengthened: pulls
}

void expect_refused(const std::string& name, const std::map<std::string, std::string>& overrides,
                    const std::string& pointer, const std::string& value, const std::string& allowed) {
    try {
        build_mechanism(name, overrides);
        FAIL() << name << " " << pointer << " was accepted";
    } catch (const ModelError& error) {
        EXPECT_EQ(error.pointer(), pointer);
        EXPECT_NE(error.problem().find(value), std::string::npos) << error.problem();
        EXPECT_NE(error.allowed().find(allowed), std::string::npos) << error.allowed();
        EXPECT_EQ(std::string(error.what()).rfind(name + ":", 0), 0u) << error.what();
    }
}

TEST(Mechanisms, RefuseWhatIsNotAllowed) {
    expect_refused("no-such", {}, "", "no-such", "slider-crank");
    expect_refused("chain", {{"lnks", "3"}}, "/parameters/lnks", "lnks", "links, joint, thin");
    expect_refused("pendulum", {{"a/b", "3"}}, "/parameters/a~1b", "a/b", "none");
    for (const char* bad : {"0", "-1", "2.5", "1000001", "three", "", "3x", "nan", "inf", "1e999", " 3"})
        expect_refused("chain", {{"links", bad}}, "/parameters/links", bad,
                       "a whole number from 1 to 1000000");
    expect_refused("chain", {{"joint", "prismatic"}}, "/parameters/joint", "prismatic",
                   "revolute, spherical, universal");
    expect_refused("slider-crank", {{"joint", "rubber"}}, "/parameters/joint", "rubber", "spherical");
    expect_refused("triple-pendulum", {{"stops", "2"}}, "/parameters/stops", "2", "0");
    expect_refused("bouncing-journal", {{"restitution", "0"}}, "/parameters/restitution", "0", "1");
    expect_refused("heavy-top", {{"mass", "-1"}}, "/parameters/mass", "-1", "kg");
    expect_refused("heavy-top", {{"iaxial", "0.05"}}, "/parameters/iaxial", "0.05", "twice iperp");
    EXPECT_NO_THROW(build_mechanism("heavy-top", {{"iaxial", "0.04"}}));
    EXPECT_EQ(build_mechanism("chain", {{"links", "1e1"}}).bodies.size(), 10u);
}

} // namespace
} // namespace gudgeon
