// The articulated-body recursion against dense solutions of the acceleration equations.
#include "solvers/articulated_body.hpp"

#include "tests/core/tree_tools.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

/// u' of [M G^T; G 0] (u', lambda) = (f, gamma).
VecX dense_accelerations(const System& system, const TreePose& pose, const VecX& f) {
    Workspace ws = make_workspace(system);
    State state = initial_state(system);
    state.q = pose.q;
    state.u = pose.u;
    const MatX G = dense_rows(system, state, ws);
    const Eigen::Index n = system.velocities(), m = system.row_count();
    MatX K = MatX::Zero(n + m, n + m);
    K.topLeftCorner(n, n) = dense_mass(system);
    K.bottomLeftCorner(m, n) = G;
    K.topRightCorner(n, m) = G.transpose();
    VecX gamma = VecX::Zero(m), rhs(n + m);
    const Evaluation e = evaluation(system, ws, 0);
    for (const auto& batch : system.constraints)
        batch->acceleration_rhs(e, gamma.data());
    rhs << f, gamma;
    return K.fullPivLu().solve(rhs).head(n);
}

class ArticulatedBodyOf : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(RandomTrees, ArticulatedBodyOf, testing::Range(1, 13));

TEST_P(ArticulatedBodyOf, GivesTheAccelerationsOfTheSaddlePoint) {
    std::mt19937 rng(static_cast<unsigned>(GetParam()));
    const System system = compiled(random_tree(rng, 4 + GetParam()));
    const TreeKinematics tree(system);
    const TreeState x(tree, rng);
    const TreePose pose(system, tree, x.s, x.w);
    VecX f(system.velocities());
    for (double& value : f)
        value = random_vector(rng, 20)[0];
    ArticulatedBody articulated(system, tree.tree());
    VecX speeds = VecX::Zero(tree.speeds()), products(system.velocities()), found = products;
    articulated.solve(pose.links, pose.motion, f, speeds);
    tree.expand(pose.motion, pose.links, speeds, found);
    tree.products(pose.motion, pose.links, products);
    found += products;
    const VecX truth = dense_accelerations(system, pose, f);
    EXPECT_LT((found - truth).norm(), 1e-12 * truth.norm());
    VecX again = VecX::Zero(tree.speeds()); // nothing of the first solution is left
    articulated.solve(pose.links, pose.motion, f, again);
    EXPECT_EQ(again, speeds);
}

// A bar on a hinge under its weight: s'' = -m g (l/2) cos s / (I + m l^2 / 4), s about -Y from the X axis.
TEST(ArticulatedBody, PendulumByHand) {
    Model model;
    model.bodies = {make_bar("bar", 0.1, {0.5, 0, 0})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, -1, 0})};
    const System system = compiled(model);
    const TreeKinematics tree(system);
    const double angle = 0.4;
    const TreePose pose(system, tree, VecX::Constant(1, angle), VecX::Constant(1, 3.0));
    Workspace ws = make_workspace(system);
    set_motion(system, pose.q, pose.u, ws);
    evaluate_forces(system, 0, ws);
    VecX speeds = VecX::Zero(1);
    ArticulatedBody(system, tree.tree()).solve(pose.links, pose.motion, ws.f, speeds);
    EXPECT_NEAR(speeds[0], -9.81 * 0.5 * std::cos(angle) / (0.1 + 0.25), 1e-12);
}

} // namespace
} // namespace gudgeon
