#include "kernels.hpp"
#include "pairs.hpp"

#include <functional>

namespace gudgeon::kernels {

namespace {

constexpr double clearance = 1e-4; // m

/// Touching contacts of one joint, for the reader.
std::string note(Pairs& p) {
    if (p.system.contacts.empty())
        return "";
    sample_contacts(p.system, 0.1, p.ws);
    return std::to_string(joint_contacts(p.system, p.ws).at(0).touching) + " touching";
}

void add(Kernels& list, const std::string& name, const Joint& joint, const Vec3& offset, const Vec3& turn) {
    const auto work = [=](void (Pairs::*run)()) {
        return [=](const Setup& setup) {
            const auto p =
                std::make_shared<Pairs>(joined_pairs(setup.bodies, joint, offset, turn), setup.threads);
            return counted::Work{[p, run] { (*p.*run)(); }, {}, [p] { return note(*p); }};
        };
    };
    list.push_back({name + "/forces", work(&Pairs::forces), counted_bodies, 2, true});
    list.push_back({name + "/derivatives", work(&Pairs::force_derivatives), counted_bodies, 2, true});
}

Joint bushing(bool tables) {
    Joint joint = make_joint("", JointKind::rigid, "", "", Vec3::Zero());
    joint.fidelity = Fidelity::bushing;
    joint.bushing = Bushing{};
    joint.bushing->stiffness = {5e6, 5e6, 5e6, 100, 1e4, 1e4};
    joint.bushing->damping = {1e3, 1e3, 1e3, 1, 10, 10};
    if (tables)
        for (int axis = 0; axis < 3; ++axis)
            joint.bushing->tables[axis] = {{-1e-2, -1e-3, 1e-3, 1e-2}, {-1e5, -5e3, 5e3, 1e5}};
    return joint;
}

/// Axis along x in both bodies.
Joint bearing(const std::string& model) {
    Joint joint = make_joint("", JointKind::cylindrical, "", "", Vec3::Zero(), Vec3::UnitX());
    joint.fidelity = Fidelity::clearance;
    joint.clearance = strip_bearing(0.006, 0.04, clearance, 16, lankarani_nikravesh(1e9, 0.8));
    joint.clearance->model = model;
    return joint;
}

Friction lugre() {
    Friction friction;
    friction.kind = "lugre";
    friction.kinetic = 0.1;
    friction.statics = 0.15;
    friction.speed = 1e-3;
    friction.sigma0 = 1e5;
    friction.sigma1 = 300;
    return friction;
}

Friction coulomb() {
    Friction friction;
    friction.kinetic = 0.1;
    friction.speed = 1e-3;
    return friction;
}

Joint rubbing(Joint joint, const Friction& friction) {
    joint.clearance->friction = friction;
    return joint;
}

Joint ball() {
    Joint joint = make_joint("", JointKind::spherical, "", "", Vec3::Zero());
    joint.fidelity = Fidelity::clearance;
    joint.clearance = Clearance{};
    joint.clearance->radial = clearance;
    joint.clearance->law = lankarani_nikravesh(5e6, 0.75);
    return joint;
}

Joint slot() {
    Joint joint = make_joint("", JointKind::translation, "", "", Vec3::Zero(), Vec3::UnitX());
    joint.fidelity = Fidelity::clearance;
    joint.clearance = Clearance{};
    joint.clearance->model = "slot";
    joint.clearance->radial = clearance;
    joint.clearance->section = {0.02, 0.03};
    joint.clearance->length = 0.1;
    joint.clearance->law = lankarani_nikravesh(5e6, 0.75);
    return joint;
}

Joint stopped() {
    Joint joint = make_joint("", JointKind::translation, "", "", Vec3::Zero(), Vec3::UnitX());
    joint.stops["slide"] = {-0.1, 0.1, lankarani_nikravesh(1e5, 0.75)};
    return joint;
}

/// A rail that rubs with the force of its own reaction.
Joint rail() {
    Joint joint = make_joint("", JointKind::translation, "", "", Vec3::Zero(), Vec3::UnitX());
    joint.friction = {lugre()};
    return joint;
}

} // namespace

Kernels contact_kernels() {
    Kernels list;
    const Vec3 deep(0, 0, -1.05 * clearance), tilt(0, 0.02, 0);
    add(list, "bushing/linear", bushing(false), Vec3(1e-3, 2e-4, -5e-4), tilt);
    add(list, "bushing/tabulated", bushing(true), Vec3(1e-3, 2e-4, -5e-4), tilt);
    add(list, "strips/touching", bearing("strips"), deep, Vec3::Zero());
    add(list, "strips/tilted", bearing("strips"), 1.5 * deep, Vec3(0, 0.01, 0));
    add(list, "strips/one-end", bearing("strips"), 0.3 * deep, Vec3(0, 0.0045, 0));
    add(list, "strips/skipped", bearing("strips"), 0.3 * deep, Vec3::Zero());
    add(list, "strips/touching-coulomb", rubbing(bearing("strips"), coulomb()), deep, Vec3::Zero());
    add(list, "strips/touching-lugre", rubbing(bearing("strips"), lugre()), deep, Vec3::Zero());
    add(list, "bearing/planar", bearing("planar"), deep, Vec3::Zero());
    add(list, "bearing/two-end", bearing("two-end"), deep, Vec3(0, 1e-3, 0));
    add(list, "ball/touching", ball(), deep, Vec3::Zero());
    add(list, "slot/touching", slot(), deep, Vec3(0, 1e-3, 0));
    add(list, "stop/touching", stopped(), Vec3(0.101, 0, 0), Vec3::Zero());
    add(list, "friction/rail-lugre", rail(), Vec3(0.05, 0, 0), Vec3::Zero());
    return list;
}

} // namespace gudgeon::kernels
