// The one list of joint kinds: name in the model file, what the kind needs, its free coordinates.
#pragma once

#include "core/model.hpp"

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace gudgeon {

struct JointKindInfo {
    JointKind kind;
    std::string_view name;
    bool needs_axis;
    /// Free coordinates of the perfect joint that may be driven, in output order; unused entries empty.
    std::array<std::string_view, 3> driveable;
};

std::span<const JointKindInfo> joint_kinds();
const JointKindInfo& joint_kind(JointKind kind);
const JointKindInfo* find_joint_kind(std::string_view name);

/// Coordinates along which a joint of the kind is free: they may carry stops and friction.
std::vector<std::string> free_coordinates(JointKind kind);
/// Coordinates of a joint that may carry stops: those, the swing of a ball, and the slide and angle along an
/// axis that the fidelity frees or leaves to rubber.
std::vector<std::string> stop_coordinates(const Joint& joint);
/// Coordinates of a joint that a drive may prescribe (none for a bushing).
std::vector<std::string> driveable_coordinates(JointKind kind, Fidelity fidelity);
/// Those of them that are angles: a torsion spring may act on them.
std::vector<std::string> rotation_coordinates(JointKind kind, Fidelity fidelity);

} // namespace gudgeon
