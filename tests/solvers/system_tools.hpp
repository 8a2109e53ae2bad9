// Dense oracles and random states of whole systems.
#pragma once

#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "core/matrices.hpp"
#include "models/builders.hpp"
#include "models/mechanisms.hpp"
#include "tests/core/motion_tools.hpp"

#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

namespace gudgeon::test {

inline System compiled(Model model) { return compile(std::move(model), standard_force_builders()); }

inline System compiled(const std::string& name, const std::map<std::string, std::string>& parameters = {}) {
    return compiled(build_mechanism(name, parameters));
}

/// 3 kg on a bushing to the ground: 4e4, 5e4, 6e4 N/m and 100, 200 N m/rad; about z as given.
inline Model block_on_rubber(double stiffness_z, double damping_z) {
    Model model;
    model.bodies = {make_body("block", 3, {0.02, 0.03, 0.04}, {0, 0, 0})};
    Joint joint = make_joint("rubber", JointKind::rigid, "ground", "block", {0, 0, 0});
    joint.fidelity = Fidelity::bushing;
    joint.bushing =
        Bushing{{4e4, 5e4, 6e4, 100, 200, stiffness_z}, {40, 50, 60, 0.1, 0.2, damping_z}, {}, {}};
    model.joints = {joint};
    return model;
}

/// 2 kg in a ball joint with a play of 1 mm.
inline Model ball_in_socket(const ContactLaw& law) {
    Model model;
    model.bodies = {make_body("ball", 2, {0.01, 0.01, 0.01}, {0, 0, 0})};
    Joint joint = make_joint("socket", JointKind::spherical, "ground", "ball", {0, 0, 0});
    joint.fidelity = Fidelity::clearance;
    joint.clearance = Clearance{};
    joint.clearance->radial = 1e-3;
    joint.clearance->law = law;
    model.joints = {joint};
    return model;
}

inline MatX dense(const CscMatrix& m) {
    MatX out = MatX::Zero(m.pattern.rows, m.pattern.cols);
    for (int c = 0; c < m.pattern.cols; ++c)
        for (int i = m.pattern.col_start[c]; i < m.pattern.col_start[c + 1]; ++i)
            out(m.pattern.row[i], c) += m.values[i];
    return out;
}

/// M from the bodies alone.
inline MatX dense_mass(const System& system) {
    MatX m = MatX::Zero(system.velocities(), system.velocities());
    for (int i = 0; i < system.moving; ++i) {
        m.block<3, 3>(6 * i, 6 * i) = system.mass[i] * Mat3::Identity();
        m.block<3, 3>(6 * i + 3, 6 * i + 3) = system.inertia[i];
    }
    return m;
}

/// Every body moved, turned and given some speed: nothing stays special.
inline State shaken(const System& system, std::mt19937& rng, double moved, double speed) {
    State state = initial_state(system);
    for (int i = 0; i < system.moving; ++i) {
        state.q.segment<3>(7 * i) += random_vector(rng, moved);
        state.q.segment<4>(7 * i + 3) = turned(state.q.segment<4>(7 * i + 3), random_vector(rng, moved));
        state.u.segment<3>(6 * i) += random_vector(rng, speed);
        state.u.segment<3>(6 * i + 3) += random_vector(rng, speed);
    }
    for (double& x : state.lambda)
        x = std::uniform_real_distribution<double>(-20, 20)(rng);
    return state;
}

/// G at a state.
inline MatX dense_rows(const System& system, const State& state, Workspace& ws) {
    set_motion(system, state.q, state.u, ws);
    evaluate_constraints(system, state.t, nullptr, true, ws);
    return dense(rows_as_matrix(system, ws));
}

inline Body& body_named(Model& model, const std::string& name) {
    for (Body& body : model.bodies)
        if (body.name == name)
            return body;
    throw std::out_of_range("no body " + name);
}

inline Joint& joint_named(Model& model, const std::string& name) {
    for (Joint& joint : model.joints)
        if (joint.name == name)
            return joint;
    throw std::out_of_range("no joint " + name);
}

} // namespace gudgeon::test
