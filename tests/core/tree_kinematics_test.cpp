// Joint coordinates of trees against the constraints they replace and against finite differences.
#include "tests/core/tree_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

struct RandomTree {
    std::mt19937 rng;
    System system;
    TreeKinematics tree;
    explicit RandomTree(unsigned seed, int bodies = 24)
        : rng(seed), system(compiled(random_tree(rng, bodies))), tree(system) {}
    TreePose pose(const TreeState& x) const { return {system, tree, x.s, x.w}; }
    VecX rates(const TreeState& x) const {
        VecX out(tree.coordinates());
        tree.rates(x.s, x.w, out);
        return out;
    }
};

class TreeKinematicsOf : public testing::TestWithParam<int> {
  protected:
    RandomTree random{static_cast<unsigned>(GetParam())};
};

INSTANTIATE_TEST_SUITE_P(RandomTrees, TreeKinematicsOf, testing::Range(1, 9));

TEST_P(TreeKinematicsOf, CoordinatesAreAsManyAsFreedoms) {
    const System& system = random.system;
    EXPECT_EQ(random.tree.speeds(), system.velocities() - system.row_count());
    EXPECT_EQ(random.tree.tree().cut_rows, 0);
    EXPECT_TRUE(random.tree.tree().cut_joints.empty());
    EXPECT_EQ(random.tree.tree().tree_joints(), static_cast<int>(system.joints.size()));
}

TEST_P(TreeKinematicsOf, JointsHold) {
    for (int k = 0; k < 5; ++k) {
        const TreeState at(random.tree, random.rng);
        const TreePose pose = random.pose(at);
        Workspace ws = make_workspace(random.system);
        set_motion(random.system, pose.q, pose.u, ws);
        evaluate_constraints(random.system, 0, nullptr, false, ws);
        EXPECT_LT(ws.phi.cwiseAbs().maxCoeff(), 3e-14 * (1 + pose.q.cwiseAbs().maxCoeff()));
        EXPECT_LT(ws.rate.cwiseAbs().maxCoeff(), 3e-14 * (1 + pose.u.cwiseAbs().maxCoeff()));
    }
}

TEST_P(TreeKinematicsOf, ComesBackFromTheBodies) {
    const TreeState x(random.tree, random.rng);
    const TreePose pose = random.pose(x);
    VecX s, w;
    random.tree.take(pose.q, pose.u, s, w);
    const TreePose again(random.system, random.tree, s, w);
    EXPECT_LT((again.q - pose.q).cwiseAbs().maxCoeff(), 1e-13 * (1 + pose.q.cwiseAbs().maxCoeff()));
    EXPECT_LT((again.u - pose.u).cwiseAbs().maxCoeff(), 1e-13 * (1 + pose.u.cwiseAbs().maxCoeff()));
    EXPECT_LT((w - x.w).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(TreeKinematicsOf, TheStartOfTheModelIsTakenAsItIs) {
    const State start = initial_state(random.system);
    VecX s, w;
    random.tree.take(start.q, start.u, s, w);
    const TreePose pose(random.system, random.tree, s, w);
    EXPECT_LT((pose.q - start.q).cwiseAbs().maxCoeff(), 1e-13);
}

// q(t) along s' = N w against u: positions directly, Euler parameters by p' = 1/2 L^T omega'.
TEST_P(TreeKinematicsOf, VelocitiesAreTheRatesOfThePose) {
    const TreeState x(random.tree, random.rng);
    const VecX rate = random.rates(x);
    const double h = 1e-5;
    const TreePose ahead(random.system, random.tree, x.s + h * rate, x.w),
        behind(random.system, random.tree, x.s - h * rate, x.w), here = random.pose(x);
    const VecX difference = (ahead.q - behind.q) / (2 * h);
    for (int i = 0; i < random.system.moving; ++i) {
        EXPECT_LT((difference.segment<3>(7 * i) - here.u.segment<3>(6 * i)).norm(), 2e-6);
        const Vec4 turn = 0.5 * lt_times(here.q.segment<4>(7 * i + 3), here.u.segment<3>(6 * i + 3));
        EXPECT_LT((difference.segment<4>(7 * i + 3) - turn).norm(), 2e-6);
    }
}

// u(t) along s' = N w, w' given, against J w' + products.
TEST_P(TreeKinematicsOf, AccelerationsAreTheRatesOfVelocities) {
    const TreeState x(random.tree, random.rng), other(random.tree, random.rng);
    const VecX rate = random.rates(x), &acceleration = other.w;
    const double h = 1e-5;
    const TreePose ahead(random.system, random.tree, x.s + h * rate, x.w + h * acceleration),
        behind(random.system, random.tree, x.s - h * rate, x.w - h * acceleration), here = random.pose(x);
    const VecX difference = (ahead.u - behind.u) / (2 * h);
    VecX products(random.system.velocities()), out = products;
    random.tree.products(here.motion, here.links, products);
    random.tree.expand(here.motion, here.links, acceleration, out);
    out += products;
    EXPECT_LT((difference - out).cwiseAbs().maxCoeff(), 1e-7 * (1 + out.cwiseAbs().maxCoeff()));
}

TEST_P(TreeKinematicsOf, ProjectionUndoesExpansion) {
    const TreeState x(random.tree, random.rng), other(random.tree, random.rng);
    const TreePose pose = random.pose(x);
    VecX u(random.system.velocities()), w(random.tree.speeds());
    random.tree.expand(pose.motion, pose.links, x.w, u);
    EXPECT_LT((u - pose.u).cwiseAbs().maxCoeff(), 1e-13 * (1 + u.cwiseAbs().maxCoeff()));
    random.tree.expand(pose.motion, pose.links, other.w, u);
    random.tree.project(pose.motion, pose.links, u, w);
    EXPECT_LT((w - other.w).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(TreeKinematicsOf, MovesAlongItsSpeeds) {
    const TreeState x(random.tree, random.rng);
    const double h = 1e-6;
    VecX ahead = x.s, behind = x.s;
    random.tree.move(h * x.w, ahead);
    random.tree.move(-h * x.w, behind);
    EXPECT_LT(((ahead - behind) / (2 * h) - random.rates(x)).cwiseAbs().maxCoeff(), 1e-8);
}

// One hinge by hand: a bar of 1 m turned by s about Y from the X axis, at s'.
TEST_P(TreeKinematicsOf, DifferencesAreTheStepsBetween) {
    const TreeState x(random.tree, random.rng);
    const VecX step = 1e-6 * x.w;
    VecX s = x.s, found(random.tree.speeds());
    random.tree.normalise(s);
    VecX moved = s;
    random.tree.move(step, moved);
    random.tree.difference(moved, s, found);
    EXPECT_LT((found - step).cwiseAbs().maxCoeff(), 1e-14 * (1 + s.cwiseAbs().maxCoeff()));
}

TEST(TreeKinematics, HingeByHand) {
    Model model;
    model.bodies = {make_bar("bar", 0.1, {0.5, 0, 0})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, 1, 0})};
    const System system = compiled(model);
    const TreeKinematics tree(system);
    const double angle = 0.7, speed = 2;
    const TreePose pose(system, tree, VecX::Constant(1, angle), VecX::Constant(1, speed));
    const double c = std::cos(angle), s = std::sin(angle);
    EXPECT_LT((pose.q.head<3>() - Vec3(0.5 * c, 0, -0.5 * s)).norm(), 1e-15);
    EXPECT_LT((pose.u.head<3>() - speed * Vec3(-0.5 * s, 0, -0.5 * c)).norm(), 1e-15);
    EXPECT_LT((pose.u.tail<3>() - Vec3(0, speed, 0)).norm(), 1e-15);
    VecX products(6);
    tree.products(pose.motion, pose.links, products);
    EXPECT_LT((products.head<3>() - speed * speed * Vec3(-0.5 * c, 0, 0.5 * s)).norm(), 1e-14);
}

// Axes that point against each other close a joint as well; angles keep the sign of Euler parameters.
TEST(TreeKinematics, AntiparallelAxes) {
    for (const JointKind kind : {JointKind::rigid, JointKind::revolute, JointKind::translation,
                                 JointKind::cylindrical, JointKind::planar}) {
        Model model;
        model.bodies = {make_bar("bar", 0.1, {0.5, 0, 0})};
        model.joints = {make_joint("joint", kind, "ground", "bar", {0, 0, 0}, {0, 1, 0})};
        model.joints[0].body_frame = true;
        model.joints[0].points[1] = {-0.5, 0, 0};
        (*model.joints[0].axes)[1] = {0, -1, 0};
        const System system = compiled(model);
        TreeKinematics tree(system);
        State state = initial_state(system);
        state.q.segment<4>(3) *= -1;
        Workspace ws = make_workspace(system);
        set_motion(system, state.q, state.u, ws);
        evaluate_constraints(system, 0, nullptr, false, ws);
        ASSERT_LT(ws.phi.cwiseAbs().maxCoeff(), 1e-15);
        VecX s, w;
        tree.take(state.q, state.u, s, w);
        const TreePose pose(system, tree, s, w);
        EXPECT_LT((pose.q - state.q).cwiseAbs().maxCoeff(), 1e-15);
    }
}

TEST(TreeKinematics, ArchiveKeepsTheClosures) {
    Model model;
    model.bodies = {make_bar("bar", 0.1, {0.5, 0, 0})};
    model.joints = {make_joint("joint", JointKind::rigid, "ground", "bar", {0, 0, 0}, {0, 1, 0})};
    model.bodies[0].start_orientation = Vec4(0, 0, 1, 0); // half a turn about the axis
    model.bodies[0].start_position = Vec3(-0.5, 0, 0);
    const System system = compiled(model);
    TreeKinematics tree(system), other(system);
    const State state = initial_state(system);
    VecX s, w;
    tree.take(state.q, state.u, s, w);
    Archive saved;
    tree.visit(saved);
    Archive loaded(saved.content());
    other.visit(loaded);
    EXPECT_EQ(TreePose(system, other, s, w).q, TreePose(system, tree, s, w).q);
    EXPECT_NEAR(TreePose(system, other, s, w).q[0], -0.5, 1e-15);
}

} // namespace
} // namespace gudgeon
