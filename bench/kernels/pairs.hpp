// Many equal joints or forces, each between two moving bodies of its own in general position.
#pragma once

#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "models/builders.hpp"

#include <algorithm>
#include <memory>
#include <string>

namespace gudgeon::kernels {

inline constexpr int counted_bodies = 128;

/// A compiled model of pairs with all evaluated once.
struct Pairs {
    System system;
    Workspace ws;
    VecX lambda;
    Evaluation e;

    explicit Pairs(const Model& model, int threads = 1)
        : system(compile(model, standard_force_builders())), ws(make_workspace(system, threads)) {
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

/// Bodies a0, b0, a1, b1, ...: b at `offset` from a (m) and turned by `turn` (rotation vector, small) from
/// axes parallel to the global ones. add(model, k) joins the last two.
template <class Add> Model pairs_of(int bodies, const Vec3& offset, const Vec3& turn, Add&& add) {
    Model model;
    for (int k = 0; k < std::max(1, bodies / 2); ++k) {
        const std::string number = std::to_string(k);
        Body a = make_body("a" + number, 1, {0.3, 0.4, 0.5}, Vec3(k, 0, 0));
        Body b = make_body("b" + number, 2, {0.3, 0.4, 0.5}, a.position + offset);
        b.orientation = Vec4(1, turn.x() / 2, turn.y() / 2, turn.z() / 2).normalized();
        a.velocity = {0.1, -0.2, 0.05};
        b.velocity = {0.12, -0.17, 0.01};
        b.angular_velocity = {0.1, -0.3, 0.2};
        model.bodies.push_back(a);
        model.bodies.push_back(b);
        add(model, number);
    }
    return model;
}

/// The joint, its points and axes in body frames, in every pair.
inline Model joined_pairs(int bodies, const Joint& joint, const Vec3& offset, const Vec3& turn) {
    return pairs_of(bodies, offset, turn, [&joint](Model& model, const std::string& number) {
        Joint& copy = model.joints.emplace_back(joint);
        copy.name = "joint" + number;
        copy.bodies = {"a" + number, "b" + number};
        copy.body_frame = true;
    });
}

} // namespace gudgeon::kernels
