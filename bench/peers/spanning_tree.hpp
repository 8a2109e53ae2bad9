// The spanning tree of a model in relative coordinates: which joints carry a body, which close a loop.
//
// What this folder's runners take of the model format: bodies that start in the pose as given, perfect joints
// revolute, spherical, rigid and distance, linear bushings, spring-dampers, tyres on a plain road, markers.
// Everything else is refused.
#pragma once

#include "core/model.hpp"

#include <vector>

namespace gudgeon::peers {

inline constexpr int ground = -1;

/// One body of the tree; its joint to the inboard body, or none: it moves freely from the ground.
struct TreeBody {
    int body = 0; // index in the model
    int inboard = ground;
    int joint = -1;
};

struct SpanningTree {
    std::vector<TreeBody> bodies; // every inboard body comes before its outboard ones
    std::vector<int> loops;       // joints that close a loop, distance joints among them
    /// Loops of revolute joints with parallel axes, all of them along the loop: two rows hold such a loop,
    /// the other three of its revolute joint repeat what the tree holds.
    std::vector<bool> planar; // by entry of loops
};

/// Throws ModelError where the model has something that is not listed above.
void refuse_unknown(const Model& model);

/// Breadth first from the ground; every part that no perfect joint ties to the ground starts at its body with
/// most joints.
SpanningTree spanning_tree(const Model& model);

/// Index of a body by name, ground for the ground.
int body_index(const Model& model, const std::string& name);

} // namespace gudgeon::peers
