// Random trees of all joint kinds, for the tests of joint coordinates.
#pragma once

#include "core/tree_kinematics.hpp"
#include "tests/solvers/system_tools.hpp"

#include <string>

namespace gudgeon::test {

inline Mat3 random_inertia(std::mt19937& rng) {
    const Mat3 axes = rotation(random_orientation(rng));
    const Vec3 size = Vec3(0.35, 0.45, 0.55) + random_vector(rng, 0.05);
    return axes * size.asDiagonal() * axes.transpose();
}

/// Bodies at random poses, each on an earlier one or on the ground, or free; joints with either body first.
/// All kinds occur from eight bodies on.
inline Model random_tree(std::mt19937& rng, int bodies) {
    Model model;
    model.gravity = random_vector(rng, 5);
    for (int i = 0; i < bodies; ++i) {
        Body body = make_body("b" + std::to_string(i), 1 + 0.5 * random_vector(rng)[0], {1, 1, 1},
                              random_vector(rng, 2));
        body.inertia = random_inertia(rng);
        body.orientation = random_orientation(rng);
        const int kind = i % 8;
        if (kind < 7) {
            static constexpr std::array<JointKind, 7> kinds{
                JointKind::rigid,     JointKind::revolute,  JointKind::translation, JointKind::cylindrical,
                JointKind::universal, JointKind::spherical, JointKind::planar};
            const int on = std::uniform_int_distribution<int>(-1, i - 1)(rng);
            const std::string parent = on < 0 ? "ground" : "b" + std::to_string(on);
            const bool swapped = rng() % 2 == 0;
            const Vec3 axis = random_vector(rng).normalized();
            Joint joint =
                make_joint("j" + std::to_string(i), kinds[kind], swapped ? body.name : parent,
                           swapped ? parent : body.name, body.position + random_vector(rng, 0.5), axis);
            if (kinds[kind] == JointKind::universal)
                (*joint.axes)[1] = axis.cross(random_vector(rng)).normalized();
            model.joints.push_back(joint);
        }
        model.bodies.push_back(body);
    }
    return model;
}

/// Random joint coordinates and speeds.
struct TreeState {
    VecX s, w;
    TreeState(const TreeKinematics& tree, std::mt19937& rng) : s(tree.coordinates()), w(tree.speeds()) {
        std::uniform_real_distribution<double> range(-2, 2);
        for (VecX* x : {&s, &w})
            for (double& value : *x)
                value = range(rng);
        tree.normalise(s);
    }
};

/// Bodies of a tree at joint coordinates and speeds.
struct TreePose {
    std::vector<BodyMotion> motion;
    std::vector<LinkMotion> links;
    VecX q, u;
    TreePose(const System& system, const TreeKinematics& tree, const VecX& s, const VecX& w)
        : motion(system.start), links(tree.make_links()), q(system.positions()), u(system.velocities()) {
        tree.set_motion(s, w, motion, links);
        tree.store(motion, q, u);
    }
};

} // namespace gudgeon::test
