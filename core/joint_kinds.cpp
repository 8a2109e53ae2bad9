#include "core/joint_kinds.hpp"

#include "core/joint_motions.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

constexpr std::array<JointKindInfo, 9> kinds{{
    {JointKind::rigid, "rigid", false, {}},
    {JointKind::revolute, "revolute", true, {"angle"}},
    {JointKind::translation, "translation", true, {"slide"}},
    {JointKind::cylindrical, "cylindrical", true, {"slide", "angle"}},
    {JointKind::spherical, "spherical", false, {}},
    {JointKind::universal, "universal", true, {"angle1", "angle2"}},
    {JointKind::planar, "planar", true, {"u", "v", "angle"}},
    {JointKind::point_on_axis, "point-on-axis", true, {"slide"}},
    {JointKind::distance, "distance", false, {}},
}};

constexpr bool in_order() {
    for (std::size_t i = 0; i < kinds.size(); ++i)
        if (static_cast<std::size_t>(kinds[i].kind) != i)
            return false;
    return true;
}
static_assert(in_order(), "joint_kind() indexes the table by the enumerator");

} // namespace

std::span<const JointKindInfo> joint_kinds() { return kinds; }

const JointKindInfo& joint_kind(JointKind kind) { return kinds[static_cast<std::size_t>(kind)]; }

const JointKindInfo* find_joint_kind(std::string_view name) {
    const auto* found = std::ranges::find(kinds, name, &JointKindInfo::name);
    return found == kinds.end() ? nullptr : found;
}

std::vector<std::string> joint_coordinates(const Joint& joint) {
    std::vector<std::string> names = free_coordinates(joint.kind);
    for (const auto& [name, stop] : joint.stops)
        if (std::ranges::find(names, name) == names.end())
            names.push_back(name);
    if (is_wholly_perfect(joint) && joint.kind != JointKind::spherical)
        return names;
    const auto unused = [&](const std::string& name) {
        const auto rubs = [&](const Friction& f) { return f.coordinate.value_or(name) == name; };
        return !joint.stops.contains(name) && std::ranges::none_of(joint.friction, rubs);
    };
    std::erase_if(names, unused);
    if (joint.clearance && joint.kind == JointKind::translation &&
        holds_motion(joint.kind, Motion::rotation) && joint.holds(Motion::rotation) == Fidelity::clearance)
        names.emplace_back("angle"); // of its key
    names.insert(names.begin(), {"dx", "dy", "dz", "ax", "ay", "az"});
    return names;
}

std::vector<std::string> free_coordinates(JointKind kind) {
    std::vector<std::string> names;
    for (const std::string_view name : joint_kind(kind).driveable)
        if (!name.empty())
            names.emplace_back(name);
    return names;
}

std::vector<std::string> stop_coordinates(const Joint& joint) {
    std::vector<std::string> names = free_coordinates(joint.kind);
    const auto freed = [&](Motion motion) {
        const Fidelity word = joint.holds(motion);
        return holds_motion(joint.kind, motion) && (word == Fidelity::free || word == Fidelity::bushing);
    };
    if (freed(Motion::axial))
        names.emplace_back("slide");
    if (freed(Motion::rotation))
        names.emplace_back("angle");
    if (joint.kind == JointKind::spherical || joint.kind == JointKind::point_on_axis)
        names.emplace_back("swing");
    return names;
}

std::vector<std::string> driveable_coordinates(JointKind kind, Fidelity fidelity) {
    return fidelity == Fidelity::perfect ? free_coordinates(kind) : std::vector<std::string>{};
}

std::vector<std::string> rotation_coordinates(JointKind kind, Fidelity fidelity) {
    auto names = driveable_coordinates(kind, fidelity);
    std::erase_if(names, [](const std::string& name) { return !name.starts_with("angle"); });
    return names;
}

} // namespace gudgeon
