#include "core/joint_motions.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

constexpr std::array<Motion, 4> all{Motion::radial, Motion::axial, Motion::misalignment, Motion::rotation};

} // namespace

bool holds_motion(JointKind kind, Motion motion) {
    switch (kind) {
    case JointKind::rigid:
        return true;
    case JointKind::revolute:
        return motion != Motion::rotation;
    case JointKind::translation:
        return motion != Motion::axial;
    case JointKind::cylindrical:
    case JointKind::universal:
        return motion == Motion::radial || motion == Motion::misalignment;
    case JointKind::spherical:
        return motion == Motion::radial;
    default:
        return false;
    }
}

std::vector<std::string> held_motions(JointKind kind) {
    std::vector<std::string> names;
    for (const Motion motion : all)
        if (holds_motion(kind, motion))
            names.emplace_back(motion_names[static_cast<std::size_t>(motion)]);
    return names;
}

bool may_have_clearance(JointKind kind) {
    return kind != JointKind::rigid && holds_motion(kind, Motion::radial);
}

bool is_mixed(const Joint& joint) {
    return std::ranges::any_of(joint.motions, [](const auto& word) { return word.has_value(); });
}

bool is_wholly_perfect(const Joint& joint) {
    if (!is_mixed(joint))
        return joint.fidelity == Fidelity::perfect;
    return std::ranges::none_of(all, [&](Motion motion) {
        return holds_motion(joint.kind, motion) && joint.holds(motion) != Fidelity::perfect;
    });
}

bool holds_any(const Joint& joint, Fidelity fidelity) {
    if (!is_mixed(joint))
        return joint.fidelity == fidelity;
    return std::ranges::any_of(all, [&](Motion motion) {
        return holds_motion(joint.kind, motion) && joint.holds(motion) == fidelity;
    });
}

std::string imperfection(const Joint& joint) {
    if (is_mixed(joint))
        return "mixed fidelity";
    return joint.fidelity == Fidelity::bushing ? "a bushing" : "clearance";
}

} // namespace gudgeon
