#include "kernels.hpp"
#include "pairs.hpp"

namespace gudgeon::kernels {

namespace {

template <class AddForce> void add(Kernels& list, const std::string& name, const AddForce& add_force) {
    const auto work = [add_force](void (Pairs::*run)()) {
        return [add_force, run](const Setup& setup) {
            const auto p = std::make_shared<Pairs>(
                pairs_of(setup.bodies, Vec3(1, 0.3, 0.2), Vec3(0.3, -0.2, 0.4), add_force), setup.threads);
            return counted::Work{[p, run] { (*p.*run)(); }, {}, {}};
        };
    };
    list.push_back({name + "/forces", work(&Pairs::forces), counted_bodies, 2, true});
    list.push_back({name + "/derivatives", work(&Pairs::force_derivatives), counted_bodies, 2, true});
}

SpringDamper spring(const std::string& number) {
    SpringDamper spring;
    spring.name = "spring" + number;
    spring.bodies = {"a" + number, "b" + number};
    spring.body_frame = true;
    spring.points = {Vec3(0.1, 0.2, -0.1), Vec3(-0.2, 0.1, 0.1)};
    spring.stiffness = 3e4;
    spring.damping = 3e3;
    spring.free_length = 0.5;
    return spring;
}

void add_spring(Model& model, const std::string& number) { model.forces.push_back(spring(number)); }

void add_tabulated_spring(Model& model, const std::string& number) {
    SpringDamper with_table = spring(number);
    with_table.stiffness = 0;
    with_table.table = {{-0.5, -0.1, 0, 0.1, 0.5}, {-2e4, -3e3, 0, 3e3, 2e4}};
    model.forces.push_back(with_table);
}

void add_torsion_spring(Model& model, const std::string& number) {
    Joint joint = make_joint("joint" + number, JointKind::revolute, "a" + number, "b" + number, Vec3::Zero());
    joint.body_frame = true;
    joint.points = {Vec3(0.4, 0.1, -0.2), Vec3(-0.5, 0.2, 0.1)};
    joint.axes = {Vec3::UnitY(), Vec3::UnitY()};
    model.joints.push_back(joint);
    TorsionSpring spring;
    spring.name = "spring" + number;
    spring.joint = joint.name;
    spring.stiffness = 100;
    spring.damping = 1;
    model.forces.push_back(spring);
}

/// One per body, on a wavy road.
void add_tyres(Model& model, const std::string& number) {
    for (const char* body : {"a", "b"}) {
        Tyre tyre;
        tyre.name = std::string("tyre-") + body + number;
        tyre.body = body + number;
        tyre.body_frame = true;
        tyre.point = {0, 0.1, -0.3};
        tyre.stiffness = 2e5;
        tyre.damping = 200;
        tyre.preload = 2000;
        tyre.road = HarmonicFunction{0.02, 2, 0.5, 0};
        model.forces.push_back(tyre);
    }
}

} // namespace

Kernels force_kernels() {
    Kernels list;
    add(list, "spring/linear", add_spring);
    add(list, "spring/tabulated", add_tabulated_spring);
    add(list, "spring/torsion", add_torsion_spring);
    add(list, "tyre/wavy-road", add_tyres);
    return list;
}

} // namespace gudgeon::kernels
