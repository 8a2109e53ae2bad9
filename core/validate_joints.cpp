#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"
#include "core/validate_parts.hpp"
#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

namespace {

constexpr double least_angle = 1e-6; // rad, below it two directions count as parallel

bool parallel(const Vec3& a, const Vec3& b) {
    return a.stableNormalized().cross(b.stableNormalized()).norm() < least_angle;
}

/// Member of the file that holds a direction of one side: "axis" stands for both sides.
std::string member(const Joint& joint, const std::array<Vec3, 2>& sides, std::size_t side, const char* one,
                   const char* two) {
    if (!joint.body_frame && joint.kind == JointKind::universal)
        return side == 0 ? "axis" : "axis2";
    return !joint.body_frame && sides[0] == sides[1] ? one : fmt::format("{}/{}", two, side);
}

void check_axes(const Checker& check, const std::string& at, const Joint& joint) {
    const JointKindInfo& info = joint_kind(joint.kind);
    if (!joint.axes) {
        if (info.needs_axis)
            check.refuse(at + (joint.body_frame ? "/axes" : "/axis"),
                         fmt::format("a {} joint without an axis", info.name), "an axis is required here");
        return;
    }
    const auto& axes = *joint.axes;
    for (std::size_t side = 0; side < 2; ++side)
        check.direction(at + '/' + member(joint, axes, side, "axis", "axes"), axes[side]);
    if (joint.kind != JointKind::universal)
        return;
    const Vec3 a = check.global_direction(joint.bodies[0], joint.body_frame, axes[0]);
    const Vec3 b = check.global_direction(joint.bodies[1], joint.body_frame, axes[1]);
    if (parallel(a, b))
        check.refuse(at + (joint.body_frame ? "/axes" : "/axis2"),
                     fmt::format("the axes {} and {} are parallel", shown(a), shown(b)),
                     "two axes that are not parallel");
}

void check_references(const Checker& check, const std::string& at, const Joint& joint) {
    if (!joint.references)
        return;
    const auto& references = *joint.references;
    const auto pointer = [&](std::size_t side) {
        const bool one = !joint.body_frame && references[0] == references[1];
        return at + (one ? "/reference" : fmt::format("/references/{}", side));
    };
    if (joint.kind == JointKind::universal)
        check.refuse(pointer(0), fmt::format("{} in a universal joint", shown(references[0])),
                     "no reference: the axes fix the joint frame");
    if (!joint.axes)
        check.refuse(pointer(0), fmt::format("{} without an axis", shown(references[0])),
                     "a reference beside an axis");
    for (std::size_t side = 0; side < 2; ++side) {
        check.direction(pointer(side), references[side]);
        if (parallel((*joint.axes)[side], references[side]))
            check.refuse(pointer(side),
                         fmt::format("{} is parallel to the axis {}", shown(references[side]),
                                     shown((*joint.axes)[side])),
                         "a direction across the axis");
    }
}

void check_length(const Checker& check, const std::string& at, const Joint& joint) {
    if (joint.kind == JointKind::distance) {
        if (joint.length)
            check.positive(at, "length", *joint.length);
        check.points_apart(at, joint.bodies, joint.body_frame, joint.points);
    } else if (joint.length) {
        check.refuse(at + "/length",
                     fmt::format("the length {} of a {} joint", *joint.length, joint_kind(joint.kind).name),
                     "a length for distance joints only");
    }
}

void check_bushing(const Checker& check, const std::string& at, const Joint& joint) {
    if (holds_any(joint, Fidelity::bushing)) {
        if (!joint.bushing)
            check.refuse(at + "/bushing", "the data of the bushing are missing",
                         "'bushing' is required here");
        if (joint.kind == JointKind::distance || joint.kind == JointKind::universal)
            check.refuse(at + "/fidelity",
                         fmt::format("bushing on a {} joint, which has no frame common to both sides",
                                     joint_kind(joint.kind).name),
                         "perfect, or another kind of joint");
    }
    if (!joint.bushing)
        return;
    const std::string base = at + "/bushing";
    static constexpr std::array<const char*, 6> axis{"x", "y", "z", "rx", "ry", "rz"};
    for (std::size_t i = 0; i < 6; ++i) {
        const std::string index = std::to_string(i);
        check.not_negative(base + "/stiffness", index.c_str(), joint.bushing->stiffness[i]);
        check.not_negative(base + "/damping", index.c_str(), joint.bushing->damping[i]);
        check.finite(base + "/preload", index.c_str(), joint.bushing->preload[i]);
        if (!joint.bushing->tables[i].empty())
            check.table(base + "/tables", axis[i], joint.bushing->tables[i]);
    }
}

void check_start_angles(const Checker& check, const std::string& at, const Joint& joint) {
    std::vector<std::string> names = joint_coordinates(joint);
    std::erase_if(names, [](const std::string& name) { return !name.starts_with("angle"); });
    for (const auto& [coordinate, angle] : joint.start_angles) {
        const std::string pointer = at + "/start_angles/" + coordinate;
        if (std::find(names.begin(), names.end(), coordinate) == names.end())
            check.refuse(pointer, fmt::format("the joint has no angle '{}'", coordinate),
                         names.empty() ? "no start_angles" : suggestion(coordinate, names) + listed(names));
        if (!std::isfinite(angle))
            check.refuse(pointer, fmt::format("{} is not finite", angle), "finite numbers");
    }
}

void check_drives(const Checker& check, const std::string& at, const Joint& joint) {
    const auto names = driveable_coordinates(joint.kind, Fidelity::perfect);
    for (const auto& [coordinate, function] : joint.drives) {
        const std::string pointer = at + "/drives/" + coordinate;
        if (!is_wholly_perfect(joint))
            check.refuse(pointer,
                         fmt::format("a drive of '{}' on a joint with {}", coordinate, imperfection(joint)),
                         "drives on perfect joints");
        if (std::find(names.begin(), names.end(), coordinate) == names.end())
            check.refuse(pointer,
                         fmt::format("a {} joint has no coordinate '{}' to drive",
                                     joint_kind(joint.kind).name, coordinate),
                         suggestion(coordinate, names) + listed(names));
        check.function(pointer, function);
    }
}

// Only constraints close loops.
void check_cut(const Checker& check, const std::string& at, const Joint& joint) {
    if (joint.cut && !holds_any(joint, Fidelity::perfect))
        check.refuse(at + "/cut",
                     fmt::format("a cut at a joint with {}, which closes no loop", imperfection(joint)),
                     "cuts at joints that hold some motion by a constraint");
}

} // namespace

void check_joints(const Checker& check) {
    const auto& joints = check.model().joints;
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const Joint& joint = joints[i];
        const std::string at = fmt::format("/joints/{}", i);
        check.body_pair(at, joint.bodies);
        const bool one = !joint.body_frame && joint.points[0] == joint.points[1];
        for (std::size_t side = 0; side < 2; ++side)
            check.finite(at, one ? "point" : fmt::format("points/{}", side), joint.points[side]);
        check_axes(check, at, joint);
        check_references(check, at, joint);
        check_length(check, at, joint);
        check_contacts(check, at, joint);
        check_bushing(check, at, joint);
        check_drives(check, at, joint);
        check_start_angles(check, at, joint);
        check_cut(check, at, joint);
    }
}

} // namespace gudgeon
