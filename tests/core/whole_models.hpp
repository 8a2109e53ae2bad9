// Models that hold every kind of joint, drive and force between moving bodies in general position.
#pragma once

#include "models/builders.hpp"
#include "tests/core/motion_tools.hpp"

#include <string>
#include <utility>
#include <vector>

namespace gudgeon::test {

/// A ladder of bodies: each perfect joint kind, free and driven, between neighbours, points and axes of
/// both sides chosen freely in the body frames.
inline Model every_joint() {
    struct Rung {
        JointKind kind;
        std::vector<std::string> drives;
    };
    const std::vector<Rung> rungs{{JointKind::rigid, {}},
                                  {JointKind::revolute, {}},
                                  {JointKind::revolute, {"angle"}},
                                  {JointKind::translation, {}},
                                  {JointKind::translation, {"slide"}},
                                  {JointKind::cylindrical, {}},
                                  {JointKind::cylindrical, {"slide", "angle"}},
                                  {JointKind::spherical, {}},
                                  {JointKind::universal, {}},
                                  {JointKind::universal, {"angle1", "angle2"}},
                                  {JointKind::planar, {}},
                                  {JointKind::planar, {"u", "v", "angle"}},
                                  {JointKind::point_on_axis, {}},
                                  {JointKind::point_on_axis, {"slide"}},
                                  {JointKind::distance, {}}};
    std::mt19937 rng(11);
    Model model;
    std::string previous = "ground";
    for (std::size_t k = 0; k < rungs.size(); ++k) {
        Body body = make_body("body" + std::to_string(k), 1 + 0.1 * static_cast<double>(k), {0.3, 0.4, 0.5},
                              {static_cast<double>(k), 0, 0});
        body.orientation = random_orientation(rng);
        model.bodies.push_back(body);
        Joint joint =
            make_joint("joint" + std::to_string(k), rungs[k].kind, previous, body.name, Vec3::Zero());
        joint.body_frame = true;
        joint.points = {random_vector(rng), random_vector(rng)};
        if (rungs[k].kind != JointKind::spherical && rungs[k].kind != JointKind::distance)
            joint.axes = {random_vector(rng).normalized(), random_vector(rng).normalized()};
        for (const std::string& coordinate : rungs[k].drives)
            joint.drives[coordinate] = HarmonicFunction{0.2, 0.7, 0.4, 0.1};
        model.joints.push_back(joint);
        previous = body.name;
    }
    return model;
}

/// The same with bushings, springs, a torsion spring, a tyre and loads fixed in space and in a body.
inline Model every_force() {
    Model model = every_joint();
    Joint mount = make_joint("mount", JointKind::rigid, "body0", "body3", {1, 0.5, 0.2});
    mount.fidelity = Fidelity::bushing;
    mount.bushing = Bushing{};
    mount.bushing->stiffness = {30, 40, 50, 3, 4, 5};
    mount.bushing->damping = {3, 2, 1, 0.3, 0.2, 0.1};
    mount.bushing->preload = {1, 2, 3, 0.1, 0.2, 0.3};
    model.joints.push_back(mount);
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"body1", "body5"};
    spring.points = {Vec3(1, 0.2, 0), Vec3(5, 0.3, 0.4)};
    spring.stiffness = 20;
    spring.damping = 2;
    spring.preload = 7;
    spring.actuator = HarmonicFunction{2, 1, 0, 0};
    TorsionSpring torsion;
    torsion.name = "torsion";
    torsion.joint = "joint1";
    torsion.stiffness = 5;
    torsion.damping = 0.4;
    torsion.free_angle = 0.2;
    Tyre tyre;
    tyre.name = "tyre";
    tyre.body = "body2";
    tyre.point = {2, 0.1, -0.3};
    tyre.stiffness = 30;
    tyre.damping = 3;
    tyre.preload = 10;
    tyre.road = HarmonicFunction{0.1, 1, 0.3, 0};
    AppliedForce push;
    push.name = "push";
    push.body = "body4";
    push.point = {4, 0.1, 0.2};
    push.vector = {1, 2, 3};
    push.time = HarmonicFunction{1, 1, 0.5, 2};
    AppliedForce thrust = push;
    thrust.name = "thrust";
    thrust.follows = true;
    AppliedForce torque = thrust;
    torque.name = "torque";
    torque.torque = true;
    torque.follows = false;
    torque.point = Vec3::Zero();
    model.forces = {spring, torsion, tyre, push, thrust, torque};
    return model;
}

} // namespace gudgeon::test
