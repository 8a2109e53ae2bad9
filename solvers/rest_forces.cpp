// What an equilibrium is made of: the model that starts there, reactions, forces by name.

#include "solvers/statics.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr double half_turn = 3; // rad: angles beyond need their turn named

void set_rest(const System& system, const State& state, Workspace& ws) {
    ws.remember(state);
    ws.angles.rate.setZero();
    ws.frozen = true;
    set_motion(system, state.q, VecX::Zero(system.velocities()), ws);
}

std::vector<std::string> bodies_of(const Model& model, const Force& force) {
    if (const auto* spring = std::get_if<TorsionSpring>(&force)) {
        for (const Joint& joint : model.joints)
            if (joint.name == spring->joint)
                return {joint.bodies[0], joint.bodies[1]};
        return {};
    }
    if (const auto* x = std::get_if<SpringDamper>(&force))
        return {x->bodies[0], x->bodies[1]};
    if (const auto* x = std::get_if<FrictionForce>(&force))
        return {x->bodies[0], x->bodies[1]};
    if (const auto* x = std::get_if<Tyre>(&force))
        return {x->body};
    return {std::get<AppliedForce>(force).body};
}

// A model of one force, the bodies it joins and, where it acts in a joint, that joint.
Model part_of(const Model& whole, const Force& force, const std::vector<std::string>& bodies) {
    Model part;
    part.name = whole.name;
    part.gravity.setZero();
    for (const Body& body : whole.bodies)
        if (std::ranges::find(bodies, body.name) != bodies.end())
            part.bodies.push_back(body);
    if (const auto* spring = std::get_if<TorsionSpring>(&force))
        for (const Joint& joint : whole.joints)
            if (joint.name == spring->joint)
                part.joints.push_back(joint);
    part.forces.push_back(force);
    return part;
}

} // namespace

Model model_at(const System& system, const State& state) {
    Model model = system.model;
    for (Beam& beam : model.beams) { // its pieces are among the bodies
        beam.velocity.setZero();
        beam.angular_velocity.setZero();
    }
    int i = 0;
    for (Body& body : model.bodies) {
        body.velocity.setZero();
        body.angular_velocity.setZero();
        if (body.fixed)
            continue;
        body.start_position = state.q.segment<3>(7 * i);
        body.start_orientation = Vec4(state.q.segment<4>(7 * i + 3));
        ++i;
    }
    for (std::size_t j = 0; j < model.joints.size(); ++j)
        for (const JointCoordinate& c : system.joints[j].coordinates) {
            const std::string name(c.name);
            if (c.kind != JointCoordinate::Kind::angle || model.joints[j].drives.contains(name))
                continue;
            const double angle = state.angles.value[c.index];
            model.joints[j].start_angles.erase(name);
            if (std::abs(angle) > half_turn)
                model.joints[j].start_angles[name] = angle;
        }
    return model;
}

RestForces rest_forces(const System& system, const State& state,
                       const std::vector<ForceBatchBuilder>& builders) {
    RestForces out;
    Workspace ws = make_workspace(system);
    set_rest(system, state, ws);
    evaluate_constraints(system, state.t, nullptr, true, ws);
    joint_wrenches(system, state.t, state.lambda, ws, out.joint);
    sample_contacts(system, state.t, ws);
    out.contact = joint_contacts(system, ws);

    const Model model = model_at(system, state);
    for (const Force& force : model.forces) {
        const std::vector<std::string> bodies = bodies_of(model, force);
        const System part = compile(part_of(model, force, bodies), builders);
        Workspace alone = make_workspace(part);
        State at = initial_state(part);
        at.t = state.t;
        at.angles.t = state.t;
        at.u.setZero();
        set_rest(part, at, alone);
        VecX f = VecX::Zero(part.velocities());
        const Evaluation here = evaluation(part, alone, state.t);
        for (const auto& batch : part.forces)
            batch->add_forces(here, {f.data(), part.moving});
        const std::string& name =
            std::visit([](const auto& x) -> const std::string& { return x.name; }, force);
        // on the second body, or the first where that one is fixed
        for (auto body = bodies.rbegin(); body != bodies.rend(); ++body)
            if (const int i = part.body_index(*body); i >= 0 && i < part.moving) {
                out.forces.push_back(
                    {name, *body, {f.segment<3>(6 * i), alone.motion[i].A * f.segment<3>(6 * i + 3)}});
                break;
            }
    }
    return out;
}

} // namespace gudgeon
