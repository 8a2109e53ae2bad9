#include "core/joint_kinds.hpp"
#include "kernels.hpp"
#include "pairs.hpp"

namespace gudgeon::kernels {

namespace {

const Vec3 offset(1, 0.3, 0.2), turn(0.3, -0.2, 0.4);

Joint joint_of(const JointKindInfo& kind, bool driven) {
    Joint joint = make_joint("", kind.kind, "", "", Vec3::Zero());
    joint.points = {Vec3(0.4, 0.1, -0.2), Vec3(-0.5, 0.2, 0.1)};
    if (kind.needs_axis)
        joint.axes = {Vec3(1, 2, 2) / 3,
                      kind.kind == JointKind::universal ? Vec3(2, 1, -2) / 3 : Vec3(1, 2, 2) / 3};
    if (driven)
        for (const std::string_view coordinate : kind.driveable)
            if (!coordinate.empty())
                joint.drives[std::string(coordinate)] = HarmonicFunction{0.2, 0.7, 0.4, 0.1};
    return joint;
}

void add(Kernels& list, const JointKindInfo& kind, bool driven) {
    const std::string name = "joint/" + std::string(kind.name) + (driven ? "-driven" : "");
    const auto pairs = [joint = joint_of(kind, driven)](const Setup& setup) {
        return std::make_shared<Pairs>(joined_pairs(setup.bodies, joint, offset, turn), setup.threads);
    };
    const auto residual = [pairs](const Setup& setup) { // Phi, G u, f - G^T lambda
        const auto run = [p = pairs(setup)] {
            evaluate_constraints(p->system, 0.1, p->lambda.data(), false, p->ws);
        };
        return counted::Work{run, {}, {}};
    };
    const auto derivatives = [pairs](const Setup& setup) { // G, d(G^T lambda)/dq
        const auto run = [p = pairs(setup)] {
            for (const auto& batch : p->system.constraints) {
                batch->evaluate(p->e, {.rows = p->ws.rows.data()});
                batch->add_geometric(p->e, p->lambda.data(), p->ws.lin);
            }
        };
        return counted::Work{run, {}, {}};
    };
    list.push_back({name + "/residual", residual, counted_bodies, 2, true});
    list.push_back({name + "/derivatives", derivatives, counted_bodies, 2, true});
}

} // namespace

Kernels joint_kernels() {
    Kernels list;
    for (const JointKindInfo& kind : joint_kinds())
        add(list, kind, false);
    add(list, joint_kind(JointKind::cylindrical), true); // displacement and angle
    return list;
}

} // namespace gudgeon::kernels
