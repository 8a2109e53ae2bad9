// A spanning tree of a compiled mechanism: every moving body hangs by one joint on a body nearer to the
// ground.
//
// Tree joints are perfect joints of the kinds below; a body that hangs on nothing is free (parent: ground).
// Constraint rows that no tree joint keeps are cut rows: those of joints that close loops, of distance and
// point-on-axis joints, of mixed joints, and of drives. What only pushes (bushings, clearances, stops,
// springs) needs no cut.
//
// Branches are as short as they can be (breadth first from the ground); where several joints lead to bodies
// of one depth, those with the most rows come first, so that cuts keep few rows. Parts without a way to the
// ground hang on their heaviest body, which is free. Joints that the model names as cut are never in the
// tree.
#pragma once

#include "core/system.hpp"

#include <array>
#include <vector>

namespace gudgeon {

enum class TreeKind { rigid, revolute, translation, cylindrical, universal, spherical, planar, free };

/// Coordinates (Euler parameters for spherical and the rotation of free) and speeds by kind.
constexpr int coordinate_count(TreeKind kind) {
    constexpr std::array<int, 8> counts{0, 1, 1, 2, 2, 4, 3, 7};
    return counts[static_cast<std::size_t>(kind)];
}
constexpr int speed_count(TreeKind kind) {
    constexpr std::array<int, 8> counts{0, 1, 1, 2, 2, 3, 3, 6};
    return counts[static_cast<std::size_t>(kind)];
}

/// One body and the joint it hangs on.
struct TreeLink {
    int body = 0;         // in System
    int parent = 0;       // body in System
    int parent_link = -1; // in SpanningTree::links; -1: the parent is fixed
    int joint = -1;       // in System::joints; -1: free
    TreeKind kind = TreeKind::free;
    bool swapped = false;          // the body is the joint's first one
    int depth = 1;                 // joints to the ground
    int coordinate = 0, speed = 0; // first ones in s and w
};

struct SpanningTree {
    std::vector<TreeLink> links; // parents before children, branches in one piece
    std::vector<int> link_of;    // per moving body
    std::vector<bool> kept;      // per row of the system: a tree joint keeps it
    std::vector<int> cut_joints; // in System::joints: those with cut rows
    int cut_rows = 0;
    int coordinates = 0, speeds = 0, depth = 0;
    int tree_joints() const; // links that are not free
};

SpanningTree spanning_tree(const System& system);

} // namespace gudgeon
