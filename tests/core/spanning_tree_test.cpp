// Which joints a spanning tree takes and which it cuts.
#include "core/spanning_tree.hpp"

#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

std::vector<std::string> names(const System& system, const std::vector<int>& joints) {
    std::vector<std::string> out;
    for (const int j : joints)
        out.push_back(system.joints[j].name);
    return out;
}

/// Bars in a row, a hinge to the ground at one end of the row or at both.
Model row(int bars, bool closed) {
    Model model;
    for (int i = 0; i < bars; ++i) {
        model.bodies.push_back(make_bar("b" + std::to_string(i), 0.1, {i + 0.5, 0, 0}));
        model.joints.push_back(make_joint("j" + std::to_string(i), JointKind::revolute,
                                          i ? "b" + std::to_string(i - 1) : "ground", "b" + std::to_string(i),
                                          {double(i), 0, 0}, {0, 1, 0}));
    }
    if (closed)
        model.joints.push_back(make_joint("end", JointKind::revolute, "b" + std::to_string(bars - 1),
                                          "ground", {double(bars), 0, 0}, {0, 1, 0}));
    return model;
}

TEST(SpanningTree, ChainHasNoCuts) {
    const System system = compiled(row(5, false));
    const SpanningTree tree = spanning_tree(system);
    EXPECT_EQ(tree.cut_rows, 0);
    EXPECT_EQ(tree.depth, 5);
    EXPECT_EQ(tree.coordinates, 5);
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(tree.links[i].body, i);
        EXPECT_EQ(tree.links[i].parent_link, i - 1);
        EXPECT_EQ(tree.link_of[i], i);
        EXPECT_FALSE(tree.links[i].swapped);
    }
}

TEST(SpanningTree, LoopIsCutFarFromTheGround) {
    const System system = compiled(row(4, true));
    const SpanningTree tree = spanning_tree(system);
    EXPECT_EQ(tree.depth, 2);
    EXPECT_EQ(tree.cut_rows, 5);
    EXPECT_EQ(names(system, tree.cut_joints), std::vector<std::string>{"j2"});
    EXPECT_TRUE(tree.links[tree.link_of[3]].swapped); // hangs on the ground by "end", as its first body
    EXPECT_EQ(tree.links[tree.link_of[3]].depth, 1);
    for (int r = 0; r < system.row_count(); ++r)
        EXPECT_EQ(tree.kept[r], system.joints[system.rows[r].joint].name != "j2");
}

TEST(SpanningTree, NamedCut) {
    Model model = row(4, true);
    joint_named(model, "j1").cut = true;
    const System system = compiled(model);
    const SpanningTree tree = spanning_tree(system);
    EXPECT_EQ(names(system, tree.cut_joints), std::vector<std::string>{"j1"});
    EXPECT_EQ(tree.depth, 3);
}

TEST(SpanningTree, CutsKeepFewRows) {
    Model model = row(3, true); // the middle bar could hang on either side
    joint_named(model, "j1").kind = JointKind::spherical;
    const System system = compiled(model);
    EXPECT_EQ(names(system, spanning_tree(system).cut_joints), std::vector<std::string>{"j1"});
    EXPECT_EQ(spanning_tree(system).cut_rows, 3);
}

TEST(SpanningTree, DrivesAreCutRowsOfTreeJoints) {
    Model model = row(2, false);
    joint_named(model, "j1").drives["angle"] = RampFunction{1, 0, 0};
    const System system = compiled(model);
    const SpanningTree tree = spanning_tree(system);
    EXPECT_EQ(tree.cut_rows, 1);
    EXPECT_EQ(tree.speeds, 2);
    EXPECT_FALSE(tree.kept[10]);
}

TEST(SpanningTree, WhatOnlyPushesNeedsNoCut) {
    for (const Fidelity fidelity : {Fidelity::bushing, Fidelity::free}) {
        Model model = row(3, true);
        Joint& joint = joint_named(model, "j2");
        joint.fidelity = fidelity == Fidelity::bushing ? fidelity : Fidelity::perfect;
        joint.bushing = Bushing{{1e5, 1e5, 1e5, 10, 10, 10}, {}, {}, {}};
        if (fidelity == Fidelity::free)
            joint.motions = {fidelity, fidelity, fidelity, std::nullopt};
        const SpanningTree tree = spanning_tree(compiled(model));
        EXPECT_EQ(tree.cut_rows, 0);
        EXPECT_EQ(tree.speeds, 3);
    }
}

TEST(SpanningTree, PartsWithoutGroundHangOnTheirHeaviestBody) {
    Model model = row(4, false);
    model.joints.erase(model.joints.begin()); // off the ground
    body_named(model, "b2").mass = 9;
    const System system = compiled(model);
    const SpanningTree tree = spanning_tree(system);
    EXPECT_EQ(tree.links[0].body, 2);
    EXPECT_EQ(tree.links[0].kind, TreeKind::free);
    EXPECT_EQ(tree.links[0].parent, system.body_index("ground"));
    EXPECT_EQ(tree.depth, 3);
    EXPECT_EQ(tree.speeds, 9);
    EXPECT_EQ(tree.coordinates, 10);
    EXPECT_EQ(tree.tree_joints(), 3);
}

TEST(SpanningTree, MixedDistanceAndPointOnAxisAreCut) {
    Model model = row(1, false);
    model.bodies.push_back(make_bar("far", 0.1, {3, 0, 0}));
    Joint rod = make_joint("rod", JointKind::distance, "b0", "far", {1, 0, 0});
    rod.points[1] = {2.5, 0, 0};
    model.joints.push_back(rod);
    model.joints.push_back(
        make_joint("guide", JointKind::point_on_axis, "ground", "far", {3, 0, 0}, {1, 0, 0}));
    Joint mixed = make_joint("mixed", JointKind::revolute, "ground", "far", {3, 0, 0}, {0, 1, 0});
    mixed.motions[static_cast<std::size_t>(Motion::axial)] = Fidelity::free;
    model.joints.push_back(mixed);
    const System system = compiled(model);
    const SpanningTree tree = spanning_tree(system);
    EXPECT_EQ(names(system, tree.cut_joints), (std::vector<std::string>{"rod", "guide", "mixed"}));
    EXPECT_EQ(tree.cut_rows, 1 + 2 + 4);
    EXPECT_EQ(tree.links[tree.link_of[1]].kind, TreeKind::free);
}

} // namespace
} // namespace gudgeon
