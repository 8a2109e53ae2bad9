// Gear's method against reference solutions that share nothing with it (minimal coordinates, closed
// forms): errors below what the tolerance promises, and falling with it.
#include "tests/solvers/reference_runs.hpp"

namespace gudgeon {
namespace {

using namespace test;

class GearAgainst : public testing::TestWithParam<Reference> {};

TEST_P(GearAgainst, Reference) { expect_agreement(GetParam(), "gear"); }

INSTANTIATE_TEST_SUITE_P(Slow, GearAgainst, testing::ValuesIn(references()),
                         [](const auto& info) { return info.param.name; });

TEST(Gear, SliderCrankReactionsAtOneSecond) {
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = 1e-10;
    Simulation sim(build_mechanism("slider-crank"), options);
    ASSERT_TRUE(sim.advance_to(1).ok);
    const Sample& sample = sim.sample();
    const System& system = sim.system();
    const Vec3 b(5.805941825, -6.344368678, -0.623087265); // crank on rod
    EXPECT_LT((sample.joint[system.joint_index("B")].force - b).norm(), 1e-4);
    const int slider = system.body_index("slider");
    EXPECT_NEAR(sample.state.q[7 * slider], 0.20789584070644, 1e-7);
    EXPECT_NEAR(sample.state.u[6 * slider], -0.485246439949, 1e-6);
}

TEST(Gear, PendulumAfterTenSeconds) {
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = 1e-8;
    Simulation sim(build_mechanism("pendulum"), options);
    ASSERT_TRUE(sim.advance_to(10).ok);
    const Vec3 r = sim.state().q.head<3>();
    EXPECT_NEAR(r.x(), -0.2750874626, 2e-5);
    EXPECT_NEAR(r.y(), 0, 1e-12);
    EXPECT_NEAR(r.z(), -0.9614192051, 2e-5);
    // the tension: twice the weight for the curvature, once for its direction
    const double weight = -9.81 * r.z();
    EXPECT_NEAR(-sim.sample().joint[sim.system().joint_index("rod")].force.dot(r), 3 * weight, 1e-3);
}

} // namespace
} // namespace gudgeon
