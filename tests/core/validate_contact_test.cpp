// Imperfect joints built in C++: what a file cannot say is refused too, data may wait for their fidelity.
// (The table of refused files: bad_inputs_test.cpp.)
#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"
#include "core/model.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace gudgeon {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

ContactLaw hertz() {
    ContactLaw law;
    law.kind = "hertz";
    law.stiffness = 1e9;
    return law;
}

Model good() {
    Model m;
    Body body;
    body.name = "a";
    body.mass = 1;
    body.inertia = Vec3(1, 1, 1).asDiagonal();
    m.bodies = {body};
    Joint joint;
    joint.name = "J";
    joint.kind = JointKind::revolute;
    joint.bodies = {"ground", "a"};
    joint.axes = {Vec3(0, 1, 0), Vec3(0, 1, 0)};
    joint.fidelity = Fidelity::clearance;
    Clearance clearance;
    clearance.radial = 1e-4;
    clearance.radius = 0.01;
    clearance.length = 0.04;
    clearance.law = hertz();
    joint.clearance = clearance;
    joint.stops["angle"] = {-1, 1, hertz(), {}};
    Friction friction;
    friction.kinetic = 0.1;
    friction.speed = 1e-3;
    friction.normal_force = 1;
    friction.radius = 0.01;
    joint.friction = {friction};
    m.joints = {joint};
    FrictionForce force;
    force.name = "F";
    force.bodies = {"ground", "a"};
    force.friction = friction;
    force.friction.radius.reset();
    m.forces = {force};
    return m;
}

/// Where the changed model is refused; "" if it is not.
std::string refused(const std::function<void(Model&)>& change) {
    Model m = good();
    change(m);
    try {
        validate(m);
    } catch (const ModelError& error) {
        return error.pointer();
    }
    return "";
}

std::string in_clearance(const std::function<void(Clearance&)>& change) {
    return refused([&](Model& m) { change(*m.joints[0].clearance); });
}

std::string in_law(const std::function<void(ContactLaw&)>& change) {
    return in_clearance([&](Clearance& c) { change(c.law); });
}

TEST(ValidateContact, GoodModelPasses) {
    EXPECT_EQ(refused([](Model&) {}), "");
}

TEST(ValidateContact, NumbersThatAreNotFinite) {
    const std::string clearance = "/joints/0/clearance", stop = "/joints/0/stops/angle",
                      friction = "/joints/0/friction";
    for (const double bad : {nan, infinity, -infinity}) {
        EXPECT_EQ(in_clearance([&](Clearance& c) { c.radial = bad; }), clearance + "/radial");
        EXPECT_EQ(in_clearance([&](Clearance& c) { c.axial = bad; }), clearance + "/axial");
        EXPECT_EQ(in_clearance([&](Clearance& c) { c.radius = bad; }), clearance + "/radius");
        EXPECT_EQ(in_clearance([&](Clearance& c) { c.length = bad; }), clearance + "/length");
        EXPECT_EQ(in_clearance([&](Clearance& c) { c.journal_length = bad; }), clearance + "/journal_length");
        EXPECT_EQ(in_law([&](ContactLaw& law) { law.stiffness = bad; }), clearance + "/law/stiffness");
        EXPECT_EQ(in_law([&](ContactLaw& law) { law.exponent = bad; }), clearance + "/law/exponent");
        EXPECT_EQ(in_law([&](ContactLaw& law) {
                      law.kind = "flores";
                      law.restitution = bad;
                  }),
                  clearance + "/law/restitution");
        EXPECT_EQ(refused([&](Model& m) { m.joints[0].stops["angle"].lower = bad; }), stop + "/lower");
        EXPECT_EQ(refused([&](Model& m) { m.joints[0].stops["angle"].upper = bad; }), stop + "/upper");
        EXPECT_EQ(refused([&](Model& m) { m.joints[0].friction[0].kinetic = bad; }), friction + "/mu_k");
        EXPECT_EQ(refused([&](Model& m) { m.joints[0].friction[0].normal_force = bad; }),
                  friction + "/normal_force");
        EXPECT_EQ(refused([&](Model& m) { std::get<FrictionForce>(m.forces[0]).points[1][2] = bad; }),
                  "/forces/0/points/1/2");
        EXPECT_EQ(refused([&](Model& m) { std::get<FrictionForce>(m.forces[0]).axis[1] = bad; }),
                  "/forces/0/axis/1");
        EXPECT_EQ(refused([&](Model& m) { m.onset.force = bad; }), "/onset/force");
    }
}

TEST(ValidateContact, WhatAFileCannotSay) {
    EXPECT_EQ(refused([](Model& m) { m.joints[0].fidelity = Fidelity::free; }), "/joints/0/fidelity");
    EXPECT_EQ(in_clearance([](Clearance& c) { c.strips = -3; }), "/joints/0/clearance/strips");
    EXPECT_EQ(in_law([](ContactLaw& law) { law.smooth = true; }), "/joints/0/clearance/law/blend");
    EXPECT_EQ(in_law([](ContactLaw& law) {
                  law.kind = "blend";
                  law.thickness = law.width = 1e-3;
                  law.hard = {hertz(), hertz()};
              }),
              "/joints/0/clearance/law/hard");
    EXPECT_EQ(in_law([](ContactLaw& law) { law = ContactLaw{}; }), "/joints/0/clearance/law/stiffness");
    EXPECT_EQ(refused([](Model& m) { m.onset = {1e-6, 1, {}}; }), "/onset/force");
    EXPECT_EQ(refused([](Model& m) {
                  m.joints[0].motions[static_cast<std::size_t>(Motion::radial)] = Fidelity::bushing;
                  m.joints[0].motions[static_cast<std::size_t>(Motion::misalignment)] = Fidelity::perfect;
              }),
              "/joints/0/bushing");
}

TEST(ValidateContact, DataWaitForTheirFidelity) {
    EXPECT_EQ(refused([](Model& m) {
                  m.joints[0].fidelity = Fidelity::perfect;
                  m.joints[0].clearance->radius.reset();
                  m.joints[0].clearance->radial.reset();
                  m.joints[0].clearance->axial = 1e-4;
              }),
              "");
    EXPECT_EQ(refused([](Model& m) {
                  m.joints[0].fidelity = Fidelity::perfect;
                  m.joints[0].clearance->radial = -1e-4;
              }),
              "/joints/0/clearance/radial");
}

TEST(ValidateContact, ReactionGivesTheNormalForceOfPerfectJointsOnly) {
    const auto place = [](Fidelity axial) {
        return refused([&](Model& m) {
            Joint& j = m.joints[0];
            j.fidelity = Fidelity::perfect;
            j.motions[static_cast<std::size_t>(Motion::axial)] = axial;
            j.clearance.reset();
            j.friction[0].normal_force.reset();
        });
    };
    EXPECT_EQ(place(Fidelity::perfect), "");
    EXPECT_EQ(place(Fidelity::free), "/joints/0/friction/normal_force");
}

TEST(JointMotions, CoordinatesThatMayCarryStops) {
    using Names = std::vector<std::string>;
    Joint joint;
    const auto names = [&](JointKind kind, std::optional<Fidelity> axial, std::optional<Fidelity> rotation) {
        joint.kind = kind;
        joint.motions = {std::nullopt, axial, std::nullopt, rotation};
        return stop_coordinates(joint);
    };
    EXPECT_EQ(names(JointKind::revolute, {}, {}), Names{"angle"});
    EXPECT_EQ(names(JointKind::revolute, Fidelity::free, {}), (Names{"angle", "slide"}));
    EXPECT_EQ(names(JointKind::revolute, Fidelity::bushing, {}), (Names{"angle", "slide"}));
    EXPECT_EQ(names(JointKind::revolute, Fidelity::clearance, {}), Names{"angle"});
    EXPECT_EQ(names(JointKind::translation, {}, Fidelity::free), (Names{"slide", "angle"}));
    EXPECT_EQ(names(JointKind::rigid, Fidelity::free, Fidelity::free), (Names{"slide", "angle"}));
    EXPECT_EQ(names(JointKind::cylindrical, {}, {}), (Names{"slide", "angle"}));
    EXPECT_EQ(names(JointKind::spherical, {}, {}), Names{"swing"});
    EXPECT_EQ(names(JointKind::point_on_axis, {}, {}), (Names{"slide", "swing"}));
    EXPECT_EQ(names(JointKind::universal, {}, {}), (Names{"angle1", "angle2"}));
    EXPECT_EQ(names(JointKind::distance, {}, {}), Names{});
}

TEST(JointMotions, EveryKind) {
    using Names = std::vector<std::string>;
    EXPECT_EQ(held_motions(JointKind::revolute), (Names{"radial", "axial", "misalignment"}));
    EXPECT_EQ(held_motions(JointKind::cylindrical), (Names{"radial", "misalignment"}));
    EXPECT_EQ(held_motions(JointKind::translation), (Names{"radial", "misalignment", "rotation"}));
    EXPECT_EQ(held_motions(JointKind::rigid), (Names{"radial", "axial", "misalignment", "rotation"}));
    EXPECT_EQ(held_motions(JointKind::spherical), Names{"radial"});
    EXPECT_EQ(held_motions(JointKind::universal), (Names{"radial", "misalignment"}));
    for (const JointKind kind : {JointKind::planar, JointKind::point_on_axis, JointKind::distance})
        EXPECT_TRUE(held_motions(kind).empty());
    EXPECT_TRUE(may_have_clearance(JointKind::universal));
    EXPECT_FALSE(may_have_clearance(JointKind::rigid));
}

} // namespace
} // namespace gudgeon
