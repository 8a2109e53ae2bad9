#include "contact/clearance.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

JointSide plain_side(const CompileContext& context, int joint) {
    const JointRecord& record = context.system.joints[joint];
    return {joint, record.a, record.b, false};
}

JointSide bearing_side(const CompileContext& context, int joint) {
    JointSide side = plain_side(context, joint);
    if (context.model.joints[joint].clearance->bearing_on_b) {
        std::swap(side.a, side.b);
        side.swapped = true;
    }
    return side;
}

void place(const JointSide& side, ForceElement& element) {
    element.joint = side.joint;
    element.a = side.a.body;
    element.b = side.b.body;
    element.swapped = side.swapped;
}

bool uses_model(const Joint& joint, std::string_view model) {
    return joint.kind != JointKind::spherical && joint.kind != JointKind::universal &&
           held_by_contact(joint, Motion::radial) && joint.clearance->model == model;
}

bool held_by_contact(const Joint& joint, Motion motion) {
    return holds_motion(joint.kind, motion) && joint.holds(motion) == Fidelity::clearance;
}

ContactGeometry contact_geometry(const Clearance& clearance) {
    ContactGeometry out;
    out.clearance = clearance.radial.value_or(0);
    out.length = clearance.length.value_or(0);
    if (clearance.radius)
        out.bearing_radius = *clearance.radius;
    else if (!clearance.profile.empty())
        out.bearing_radius = *std::ranges::min_element(clearance.profile);
    if (out.bearing_radius > 0)
        out.journal_radius = out.bearing_radius - out.clearance;
    return out;
}

NormalLaw joint_law(const CompileContext& context, int joint, const ContactLaw& law,
                    const ContactGeometry& geometry, const std::string& member) {
    try {
        return compile_law(law, geometry);
    } catch (const LawError& e) {
        throw ModelError(context.model.source, fmt::format("/joints/{}{}{}", joint, member, e.member),
                         e.problem, e.allowed);
    }
}

NormalLaw radial_law(const CompileContext& context, int joint) {
    const Clearance& clearance = *context.model.joints[joint].clearance;
    return joint_law(context, joint, clearance.law, contact_geometry(clearance), "/clearance/law");
}

std::optional<FrictionLaw> contact_friction(const CompileContext& context, int joint) {
    const std::optional<Friction>& friction = context.model.joints[joint].clearance->friction;
    return friction ? std::optional(compile_friction(*friction)) : std::nullopt;
}

double rubbing_radius(const Clearance& clearance) {
    if (clearance.friction && clearance.friction->radius)
        return *clearance.friction->radius;
    double sum = 0;
    for (const double radius : clearance.profile)
        sum += radius;
    return clearance.profile.empty() ? clearance.radius.value_or(0)
                                     : sum / static_cast<double>(clearance.profile.size());
}

NormalLaw axial_law(const CompileContext& context, int joint) {
    const Clearance& clearance = *context.model.joints[joint].clearance;
    if (!clearance.axial_law)
        return radial_law(context, joint);
    ContactGeometry geometry;
    geometry.clearance = clearance.axial.value_or(0);
    return joint_law(context, joint, *clearance.axial_law, geometry, "/clearance/axial_law");
}

NormalLaw rotation_law(const CompileContext& context, int joint) {
    const Clearance& clearance = *context.model.joints[joint].clearance;
    ContactGeometry geometry;
    geometry.rotation = true;
    if (clearance.rotation_law)
        return joint_law(context, joint, *clearance.rotation_law, geometry, "/clearance/rotation_law");
    return joint_law(context, joint, clearance.law, geometry, "/clearance/law");
}

} // namespace gudgeon
