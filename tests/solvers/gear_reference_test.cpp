// Gear's method against reference solutions that share nothing with it (minimal coordinates, closed
// forms): errors below what the tolerance promises, and falling with it.
#include "core/channels.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/reference_table.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;
using testing_data::ReferenceTable;

struct Pairing {
    std::string channel, column;
    /// Error allowed per tol^(5/6), which is what an error per step of tol leaves at order 5. The factor
    /// is how much the mechanism itself blows up an error until the end.
    double growth;
};

struct Reference {
    std::string name, mechanism;
    std::map<std::string, std::string> parameters;
    std::string file;
    double end;
    std::vector<Pairing> pairs;
    double energy; // growth of the energy balance, J
};

void PrintTo(const Reference& r, std::ostream* out) { *out << r.name; }

struct Errors {
    std::vector<double> largest;
    double balance = 0, phi = 0, rate = 0;
};

Errors run(const Reference& ref, double tol) {
    const ReferenceTable table(ref.file);
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = tol;
    Simulation sim(build_mechanism(ref.mechanism, ref.parameters), options);
    std::vector<Channels> channels;
    for (const Pairing& pair : ref.pairs)
        channels.emplace_back(sim.system(), std::vector<std::string>{pair.channel});
    Errors errors{std::vector<double>(ref.pairs.size(), 0), 0, 0, 0};
    Workspace ws = make_workspace(sim.system());
    for (std::size_t i = 0; i < table.rows() && table["t"][i] <= ref.end; ++i) {
        const double t = table["t"][i];
        if (t > 0) {
            const StepOutcome outcome = sim.advance_past(t, ref.end);
            EXPECT_TRUE(outcome.ok) << outcome.message;
        }
        const Sample& sample = sim.sample_at(t);
        for (std::size_t k = 0; k < channels.size(); ++k) {
            double value = 0;
            channels[k].read(sample, {&value, 1});
            errors.largest[k] = std::max(errors.largest[k], std::abs(value - table[ref.pairs[k].column][i]));
        }
        errors.balance = std::max(errors.balance, std::abs(sample.balance));
        ws.angles = sample.state.angles;
        set_motion(sim.system(), sample.state.q, sample.state.u, ws);
        evaluate_constraints(sim.system(), t, nullptr, false, ws);
        errors.phi = std::max(errors.phi, ws.phi.cwiseAbs().maxCoeff());
        errors.rate = std::max(errors.rate, ws.rate.cwiseAbs().maxCoeff());
    }
    EXPECT_LT(sim.statistics().constraint_position_max, 1e-10);
    EXPECT_LT(sim.statistics().constraint_velocity_max, 1e-10);
    return errors;
}

class GearAgainst : public testing::TestWithParam<Reference> {};

TEST_P(GearAgainst, Reference) {
    const Reference& ref = GetParam();
    Errors before;
    for (const double tol : {1e-4, 1e-6, 1e-8}) {
        SCOPED_TRACE(testing::Message() << "tolerance " << tol);
        const Errors errors = run(ref, tol);
        const double promised = std::pow(tol, 5.0 / 6);
        for (std::size_t k = 0; k < ref.pairs.size(); ++k) {
            const std::string& channel = ref.pairs[k].channel;
            EXPECT_LT(errors.largest[k], ref.pairs[k].growth * promised) << channel;
            if (!before.largest.empty()) {
                EXPECT_LT(errors.largest[k], before.largest[k] / 8) << channel;
            }
        }
        EXPECT_LT(errors.balance, ref.energy * promised);
        if (before.balance > 0) {
            EXPECT_LT(errors.balance, before.balance / 8);
        }
        EXPECT_LT(errors.phi, 1e-12);
        EXPECT_LT(errors.rate, 1e-12);
        before = errors;
    }
}

std::vector<Reference> references() {
    const std::map<std::string, std::string> four{{"links", "4"}, {"thin", "1"}},
        sixteen{{"links", "16"}, {"thin", "1"}};
    return {
        {"SliderCrankFirstTurn",
         "slider-crank",
         {},
         "r1_slider_crank_ideal.csv",
         0.5,
         {{"slider.x", "x", 1},
          {"slider.vx", "xd", 50},
          {"slider.ax", "xdd", 2e3},
          {"crank.wx", "thetad", 800},
          {"crank.alx", "thetadd", 6e4},
          {"A.angle", "theta", 50},
          {"B.fx", "FBx", 4500},
          {"B.fy", "FBy", 4500},
          {"B.fz", "FBz", 4500},
          {"C.fx", "FCx", 4500},
          {"C.fy", "FCy", 4500},
          {"C.fz", "FCz", 4500}},
         12},
        {"SliderCrank",
         "slider-crank",
         {},
         "r1_slider_crank_ideal.csv",
         5,
         {{"slider.x", "x", 400},
          {"rod.e0", "e0", 300},
          {"rod.e1", "e1", 500},
          {"rod.e2", "e2", 1500},
          {"rod.e3", "e3", 2500}},
         100},
        {"HeavyTop",
         "heavy-top",
         {},
         "r7_slow_top_b.csv",
         2,
         {{"top.x", "cx", 30},
          {"top.y", "cy", 20},
          {"top.z", "cz", 40},
          {"top.e0", "e0", 70},
          {"top.e1", "e1", 50},
          {"top.e2", "e2", 50},
          {"top.e3", "e3", 60}},
         120},
        {"ChainOfFour",
         "chain",
         four,
         "r5_chain_N4.csv",
         1,
         {{"tip.x", "tip_x", 4},
          {"tip.z", "tip_z", 4},
          {"link4.wy", "omega_N", 80},
          {"link1.wy", "omega_1", 40}},
         200},
        {"ChainOfSixteen",
         "chain",
         sixteen,
         "r5_chain_N16.csv",
         1,
         {{"tip.x", "tip_x", 2}, {"tip.z", "tip_z", 4}, {"link1.wy", "omega_1", 25}},
         600},
        // until the first stop is reached, at 0.329 s
        {"TriplePendulum",
         "triple-pendulum",
         {},
         "r3_Z_LN.csv",
         0.329,
         {{"J1.angle", "q1", 2}, {"J2.slide", "s", 2}, {"J2.angle", "phi", 1}, {"J3.angle", "psi", 2}},
         3},
        {"SuspensionChainOfOne",
         "suspension-chain",
         {},
         "suspension_chain_N1.csv",
         5,
         {{"chassis0.z", "chassis0.z", 1}},
         1e4},
        {"SuspensionChainOfFour",
         "suspension-chain",
         {{"units", "4"}},
         "suspension_chain_N4.csv",
         5,
         {{"chassis0.z", "chassis0.z", 1},
          {"chassis1.z", "chassis1.z", 1},
          {"chassis2.z", "chassis2.z", 1},
          {"chassis3.z", "chassis3.z", 1}},
         2e4},
    };
}

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
