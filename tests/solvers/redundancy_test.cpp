// Mechanisms whose constraints repeat each other: they run, with the least reactions, and lose no row.
#include "models/mechanisms.hpp"
#include "solvers/consistent.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/system_tools.hpp"

#include <Eigen/SVD>

#include <gtest/gtest.h>

#include <cmath>

namespace gudgeon {
namespace {

using test::compiled;
using test::dense_rows;

Simulation simulation(Model model, const std::string& integrator, double tol) {
    SimulationOptions options;
    options.integrator = integrator;
    options.integration.rtol = options.integration.atol = tol;
    options.integration.step = integrator == "rk4" ? 1e-3 : 0;
    return Simulation(std::move(model), options);
}

/// Crank angle of the parallelograms: a'' = g (9 N + 3)/(8 N + 2) sin a, a(0) = 0, a'(0) = 1.
double crank_angle(int loops, double t) {
    const double k = 9.81 * (9 * loops + 3) / (8 * loops + 2);
    const int n = static_cast<int>(std::ceil(t / 1e-4));
    double a = 0, w = 1;
    const double h = n ? t / n : 0;
    for (int i = 0; i < n; ++i) {
        const double a1 = w, w1 = k * std::sin(a), a2 = w + h / 2 * w1, w2 = k * std::sin(a + h / 2 * a1),
                     a3 = w + h / 2 * w2, w3 = k * std::sin(a + h / 2 * a2), a4 = w + h * w3,
                     w4 = k * std::sin(a + h * a3);
        a += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        w += h / 6 * (w1 + 2 * w2 + 2 * w3 + w4);
    }
    return a;
}

TEST(Redundancy, ExactCrankAngleIsThatOfTheReference) {
    EXPECT_NEAR(std::sin(crank_angle(2, 1)), -0.195020302, 2e-9);
    EXPECT_NEAR(std::cos(crank_angle(2, 1)), -0.980799206, 2e-9);
    EXPECT_NEAR(std::sin(crank_angle(2, 10)), 0.328458112, 2e-8);
}

struct Passage {
    std::string integrator;
    int loops;
    double tol;
};
void PrintTo(const Passage& p, std::ostream* out) { *out << p.integrator << p.loops; }

class FlatPositions : public testing::TestWithParam<Passage> {};

// Flat twice on the way (four times where the crank has turned back by 3 s).
TEST_P(FlatPositions, ArePassedOnTheRegularBranch) {
    const Passage& p = GetParam();
    Simulation sim =
        simulation(build_mechanism("four-bar", {{"loops", std::to_string(p.loops)}}), p.integrator, p.tol);
    const int crank = sim.system().body_index("crank0"),
              last = sim.system().body_index("crank" + std::to_string(p.loops));
    // upright, the cranks blow an error up by e^(3.3 t): to 1 s by 30, to 3 s, upright again, by 900
    const double bound = (p.integrator == "radau" ? 5 : 1000) * p.tol;
    for (double t = 0.1; t < 3.05; t += 0.1) {
        const StepOutcome outcome = sim.advance_past(t, 3.05);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Sample& sample = sim.sample_at(t);
        const double a = crank_angle(p.loops, t);
        EXPECT_NEAR(sample.motion[crank].r.x(), 0.5 * std::sin(a), bound) << t;
        EXPECT_NEAR(sample.motion[crank].r.z(), 0.5 * std::cos(a), bound) << t;
        EXPECT_NEAR(sample.motion[last].r.x() - p.loops, 0.5 * std::sin(a), bound) << t;
    }
    EXPECT_LE(sim.statistics().constraint_position_max, 1e-10);
    EXPECT_LE(sim.statistics().constraint_velocity_max, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Redundancy, FlatPositions,
                         testing::Values(Passage{"gear", 1, 1e-5}, Passage{"gear", 1, 1e-9},
                                         Passage{"radau", 1, 1e-7}, Passage{"gear", 2, 1e-7},
                                         Passage{"auto", 2, 1e-7}, Passage{"gear", 10, 1e-7},
                                         Passage{"gear", 40, 1e-7}, Passage{"gear", 10, 1e-9},
                                         Passage{"radau", 2, 1e-7}, Passage{"radau", 2, 1e-9},
                                         Passage{"radau", 10, 1e-7}, Passage{"radau", 40, 1e-5}),
                         [](const auto& info) {
                             return info.param.integrator + std::to_string(info.param.loops) + "tol" +
                                    std::to_string(std::lround(-std::log10(info.param.tol)));
                         });

/// A door of 2 kg on hinges at y = -left and y = right of a horizontal axis, its mass centre at (0.3, 0, 0).
Model door(double left, double right) {
    Model model;
    model.name = "door";
    Body body;
    body.name = "leaf";
    body.mass = 2;
    body.inertia = Vec3(0.1, 0.2, 0.25).asDiagonal();
    body.position = {0.3, 0, 0};
    model.bodies.push_back(body);
    for (const double y : {-left, right}) {
        Joint hinge;
        hinge.name = y < 0 ? "left" : "right";
        hinge.kind = JointKind::revolute;
        hinge.bodies = {"ground", "leaf"};
        hinge.points = {Vec3(0, y, 0), Vec3(0, y, 0)};
        hinge.axes = {Vec3::UnitY(), Vec3::UnitY()};
        model.joints.push_back(hinge);
    }
    return model;
}

class Reactions : public testing::TestWithParam<std::string> {};

TEST_P(Reactions, OfASymmetricPairAreEqual) {
    Simulation sim = simulation(door(0.4, 0.4), GetParam(), 1e-6);
    EXPECT_EQ(sim.redundancy().dof, 1);
    EXPECT_EQ(sim.redundancy().dependent.size(), 5u);
    for (double t = 0.05; t < 0.5; t += 0.05) {
        const StepOutcome outcome = sim.advance_past(t, 0.5);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Sample& s = sim.sample_at(t);
        const double size = s.joint[0].force.norm();
        ASSERT_GT(size, 1);
        EXPECT_LT((s.joint[0].force - s.joint[1].force).norm(), 1e-10 * size);
        const Vec3 twice = s.joint[0].force + s.joint[1].force;
        EXPECT_LT((twice - 2 * (s.acceleration.head<3>() - Vec3(0, 0, -9.81))).norm(), 1e-9 * size);
    }
}

INSTANTIATE_TEST_SUITE_P(Redundancy, Reactions, testing::Values("gear", "radau", "rk4", "ida", "auto"),
                         [](const auto& info) { return info.param; });

// Of all multipliers with the same G^T lambda those with the least sum of force^2 + (moment/L)^2, by a dense
// pseudo-inverse.
TEST(Redundancy, ReactionsAreTheLeast) {
    const System system = compiled(door(0.2, 0.7));
    Workspace ws = make_workspace(system);
    ConsistentSolver solver(system);
    State state = initial_state(system);
    VecX acceleration, lambda;
    ASSERT_TRUE(solver.accelerations(0, state.q, state.u, ws, acceleration, lambda));
    EXPECT_TRUE(solver.soft());
    EXPECT_EQ(solver.deficiency(), 5);
    const MatX G = dense_rows(system, state, ws);
    VecX root(lambda.size());
    const double L = reaction_length(system);
    EXPECT_NEAR(L, std::sqrt((0.3 * 0.3 * 2 + 0.2 * 0.2 + 0.7 * 0.7) / 2), 1e-14);
    for (int r = 0; r < system.row_count(); ++r)
        root[r] = is_moment_row(system.rows[r]) ? L : 1;
    Eigen::JacobiSVD<MatX> svd(G.transpose() * root.asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(1e-10);
    const VecX least = root.asDiagonal() * svd.solve(G.transpose() * lambda);
    EXPECT_LT((lambda - least).cwiseAbs().maxCoeff(), 1e-10 * least.cwiseAbs().maxCoeff());
    EXPECT_GT(least.cwiseAbs().maxCoeff(), 1);
}

TEST(Redundancy, ContradictionsAreRefusedByName) {
    Model model = door(0.4, 0.4);
    for (const double length : {1.0, 1.1}) {
        Joint rod;
        rod.name = length == 1 ? "rod" : "longer-rod";
        rod.kind = JointKind::distance;
        rod.bodies = {"ground", "leaf"};
        rod.points = {Vec3(0.3, 0, 1), Vec3(0.3, 0, 0)};
        rod.length = length;
        model.joints.push_back(rod);
    }
    try {
        Simulation sim(model);
        FAIL() << "rods of two lengths between the same points";
    } catch (const AssemblyError& error) {
        EXPECT_NE(std::string(error.what()).find("rod' (distance)"), std::string::npos) << error.what();
    }
}

/// Multipliers of soft rows are eliminated after the bodies they act on, as others are: a ladder of loops
/// fills its factors in proportion to its length.
TEST(Redundancy, FactorsGrowWithTheLengthOfALadder) {
    const auto factor_entries = [](int loops) {
        Simulation sim =
            simulation(build_mechanism("four-bar", {{"loops", std::to_string(loops)}}), "gear", 1e-5);
        EXPECT_TRUE(sim.advance_to(0.02).ok);
        return static_cast<double>(sim.statistics().nnz_factors) / sim.system().moving;
    };
    EXPECT_LT(factor_entries(300), 1.5 * factor_entries(20));
}

TEST(Redundancy, SoftRowsLeaveTheMatrixRegular) {
    const System system = compiled("four-bar");
    Workspace ws = make_workspace(system);
    const State state = initial_state(system);
    set_motion(system, state.q, state.u, ws);
    linearise(system, 0, state.lambda.data(), ws);
    for (const Rows rows : {Rows::independent, Rows::soft}) {
        const SaddleMatrix saddle(system, rows);
        CscMatrix k{saddle.pattern(), std::vector<double>(saddle.pattern().nonzeros())};
        saddle.assemble(system, ws, 100, 0.01, k.values);
        Eigen::JacobiSVD<MatX> svd(test::dense(k));
        const double share = svd.singularValues().tail<1>()[0] / svd.singularValues()[0];
        if (rows == Rows::soft)
            EXPECT_GT(share, 1e-14);
        else
            EXPECT_LT(share, 1e-15);
    }
}

} // namespace
} // namespace gudgeon
