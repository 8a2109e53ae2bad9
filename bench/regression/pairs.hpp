// Many equal joints, each between two moving bodies of its own in general position.
#pragma once

#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "models/builders.hpp"

#include <cmath>
#include <memory>

namespace gudgeon::regression {

inline constexpr int pair_count = 64;

/// A compiled model of pairs with all evaluated once.
struct Pairs {
    System system;
    Workspace ws;
    VecX lambda;
    Evaluation e;

    explicit Pairs(const Model& model)
        : system(compile(model, standard_force_builders())), ws(make_workspace(system)) {
        const State state = initial_state(system);
        lambda = VecX::Constant(system.row_count(), 3);
        ws.lambda = lambda;
        for (double& speed : ws.contacts.start_speed)
            speed = 0.1;
        set_motion(system, state.q, state.u, ws);
        e = evaluation(system, ws, 0.1);
        linearise(system, 0.1, lambda.data(), ws);
    }
    Pairs(const Pairs&) = delete;
    Pairs& operator=(const Pairs&) = delete;

    void forces() {
        for (const auto& batch : system.forces)
            batch->add_forces(e, {ws.f.data(), system.moving});
    }
    void force_derivatives() {
        ws.lin.states.clear();
        ws.lin.reactions.clear();
        for (const auto& batch : system.forces)
            batch->add_linearisation(e, ws.lin);
    }
};

/// The joint, its points and axes in body frames, in every pair: b at `offset` from a (m) and turned by
/// `turn` (rotation vector, small) from axes parallel to the global ones.
inline Model pairs_of(const Joint& joint, const Vec3& offset, const Vec3& turn) {
    Model model;
    for (int k = 0; k < pair_count; ++k) {
        const std::string number = std::to_string(k);
        Body a = make_body("a" + number, 1, {0.3, 0.4, 0.5}, Vec3(k, 0, 0));
        Body b = make_body("b" + number, 2, {0.3, 0.4, 0.5}, a.position + offset);
        b.orientation = Vec4(1, turn.x() / 2, turn.y() / 2, turn.z() / 2).normalized();
        a.velocity = {0.1, -0.2, 0.05};
        b.velocity = {0.12, -0.17, 0.01};
        b.angular_velocity = {0.1, -0.3, 0.2};
        model.bodies.push_back(a);
        model.bodies.push_back(b);
        Joint& copy = model.joints.emplace_back(joint);
        copy.name = "joint" + number;
        copy.bodies = {a.name, b.name};
        copy.body_frame = true;
    }
    return model;
}

} // namespace gudgeon::regression
