// Which relative motions a joint kind holds, and what a mixed joint holds them with.
#pragma once

#include "core/model.hpp"

#include <string>
#include <vector>

namespace gudgeon {

/// False for the kinds without such motions (planar, point-on-axis, distance).
bool holds_motion(JointKind kind, Motion motion);
/// Names of the motions that a kind holds.
std::vector<std::string> held_motions(JointKind kind);
/// Kinds whose motions may be held by contact after a free play.
bool may_have_clearance(JointKind kind);

/// A fidelity is given for single motions.
bool is_mixed(const Joint& joint);
/// Every motion that the kind holds is held by a constraint.
bool is_wholly_perfect(const Joint& joint);
/// Some motion that the kind holds is held by this.
bool holds_any(const Joint& joint, Fidelity fidelity);
/// For messages: "a bushing", "clearance" or "mixed fidelity".
std::string imperfection(const Joint& joint);

} // namespace gudgeon
