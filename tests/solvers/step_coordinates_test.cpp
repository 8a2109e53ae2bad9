// Coordinates of implicit steps on random trees of all joint kinds.
#include "solvers/step_coordinates.hpp"

#include "core/assembly.hpp"
#include "tests/core/tree_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

struct OnTree {
    std::mt19937 rng{11};
    System system = compiled(random_tree(rng, 12));
    TreeKinematics tree{system};
    TreeState at{tree, rng};
    std::vector<BodyMotion> motion = system.start;
    std::vector<LinkMotion> links = tree.make_links();
    std::unique_ptr<StepCoordinates> coordinates = make_step_coordinates(system, Formulation::tree, 1);
    Workspace ws = make_workspace(system);
    VecX w_rate, acceleration = VecX::Zero(system.velocities()), products = acceleration;

    OnTree() {
        tree.set_motion(at.s, at.w, motion, links);
        coordinates->set_motion(at.s, at.w, ws);
        w_rate = at.w.reverse();
        tree.expand(motion, links, w_rate, acceleration);
        tree.products(motion, links, products);
        acceleration += products;
    }
};

TEST(StepCoordinates, SpeedRatesComeOutOfAccelerations) {
    OnTree on;
    VecX x_rate, found;
    on.coordinates->rates(on.at.s, on.at.w, on.acceleration, x_rate, found);
    EXPECT_LT((found - on.w_rate).norm(), 1e-10 * (1 + on.acceleration.norm()));
}

// Forces that the accelerations need leave nothing; without w' those of the velocity products are left out.
TEST(StepCoordinates, ForcesBalanceAccelerations) {
    OnTree on;
    VecX f = on.acceleration, momentum = on.acceleration, rest = on.products;
    mass_times(on.system, f, f);
    mass_times(on.system, rest, rest);
    on.coordinates->momentum_residual(on.w_rate, f, momentum);
    EXPECT_LT(momentum.norm(), 1e-10 * (1 + f.norm()));
    on.coordinates->take_out_products(rest);
    EXPECT_LT(rest.norm(), 1e-10 * (1 + f.norm()));
}

} // namespace
} // namespace gudgeon
