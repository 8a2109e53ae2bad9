// Singular positions: found by name, passed on the regular branch, refused where no motion is singled out.
#include "bench/hard_cases/singular_models.hpp"
#include "models/mechanisms.hpp"
#include "solvers/simulation.hpp"
#include "solvers/singular_position.hpp"
#include "solvers/stage_matrix.hpp"
#include "tests/solvers/system_tools.hpp"

#include <Eigen/SVD>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace gudgeon {
namespace {

using test::compiled;
using test::dense_rows;

SimulationOptions with(const std::string& integrator, double tol, double step = 0) {
    SimulationOptions options;
    options.integrator = integrator;
    options.integration.rtol = options.integration.atol = tol;
    options.integration.step = step;
    return options;
}

struct Way {
    std::string integrator;
    int loops;
    double tol, step;
};
void PrintTo(const Way& w, std::ostream* out) {
    *out << w.integrator << w.loops << " " << w.tol << " " << w.step;
}

class RegularBranch : public testing::TestWithParam<Way> {};

// However coarse the motion, the cranks stay parallel: at flat positions the other branches begin.
TEST_P(RegularBranch, IsKeptAtEveryToleranceAndStep) {
    const Way& way = GetParam();
    Simulation sim(build_mechanism("four-bar", {{"loops", std::to_string(way.loops)}}),
                   with(way.integrator, way.tol, way.step));
    int flat = 0;
    double last = 1;
    for (double t = 0.05; t < 5; t += 0.05) {
        const StepOutcome outcome = sim.advance_past(t, 5.05);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Sample& sample = sim.sample_at(t);
        const Vec3 arm = sample.motion[sim.system().body_index("crank0")].r;
        flat += arm.z() * last < 0;
        last = arm.z();
        for (int k = 1; k <= way.loops; ++k) {
            const Vec3& r = sample.motion[sim.system().body_index("crank" + std::to_string(k))].r;
            EXPECT_LT((r - Vec3(k, 0, 0) - arm).norm(), 1e-7) << t;
        }
    }
    EXPECT_GE(flat, 4);
}

std::vector<Way> regular_ways() {
    std::vector<Way> out;
    for (const char* integrator : {"gear", "radau"}) {
        for (const double tol : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11})
            out.push_back({integrator, 2, tol, 0});
        for (const double step : {0.002, 0.0071, 0.03, 0.1})
            out.push_back({integrator, 3, 1e-6, step});
        out.push_back({integrator, 10, 1e-8, 0});
    }
    return out;
}

INSTANTIATE_TEST_SUITE_P(SingularPositions, RegularBranch, testing::ValuesIn(regular_ways()));

TEST(SingularPositions, WeakestRowsAreTheLeastSingularVectors) {
    const System system = compiled(build_mechanism("four-bar", {}));
    Workspace ws = make_workspace(system);
    const State state = initial_state(system);
    WeakestRows weakest(system);
    ASSERT_TRUE(weakest.find(0, state.q, state.u, ws));
    const MatX G = dense_rows(system, state, ws);
    MatX scaled = G;
    for (int i = 0; i < system.moving; ++i) {
        scaled.middleCols<3>(6 * i) /= std::sqrt(system.mass[i]);
        scaled.middleCols<3>(6 * i + 3) *= system.inverse_inertia[i].llt().matrixL();
    }
    const Eigen::JacobiSVD<MatX> svd(scaled);
    double least = 1e300;
    for (const double s : svd.singularValues())
        if (s > 1e-9)
            least = std::min(least, s);
    EXPECT_NEAR(weakest.sigma(), least, 1e-3 * least);
    EXPECT_NEAR(weakest.along(0, state.q, state.u, ws), weakest.sigma(), 1e-12);
}

// w^T G v changes its sign where the bars pass the flat position.
TEST(SingularPositions, TheWeakestRowsChangeTheirSign) {
    const System system = compiled(hard::flat_chain({1, 1}));
    Workspace ws = make_workspace(system);
    const State flat = initial_state(system);
    const auto turned_by = [&](double angle) { // every crank about its foot, the coupler along
        VecX q = flat.q;
        for (int i = 0; i < system.moving; ++i) {
            const bool crank = system.body_names[i].starts_with("crank");
            const double arm = crank ? 0.5 : 1;
            q.segment<3>(7 * i) += arm * Vec3(std::cos(angle) - 1, 0, -std::sin(angle));
            if (crank)
                q.segment<4>(7 * i + 3) << std::cos(angle / 2), 0, std::sin(angle / 2), 0;
        }
        return q;
    };
    WeakestRows weakest(system);
    ASSERT_TRUE(weakest.find(0, turned_by(-0.1), flat.u, ws));
    EXPECT_LT(ws.phi.cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_NEAR(weakest.along(0, turned_by(0.1), flat.u, ws), -weakest.sigma(), 0.05 * weakest.sigma());
    EXPECT_NEAR(weakest.along(0, flat.q, flat.u, ws), 0, 0.05 * weakest.sigma());
    const std::string names = names_of_rows(system, weakest.rows());
    EXPECT_NE(names.find("(displacement along x)"), std::string::npos) << names;
    EXPECT_EQ(names.find("along y"), std::string::npos) << names;
}

// A crank at rest beside one that turns is on neither branch; three cranks from rest are driven apart.
TEST(SingularPositions, StartsOnNoBranchAreRefusedByName) {
    const auto refusal = [](const std::vector<double>& rates) -> std::string {
        try {
            Simulation sim(hard::flat_chain(rates));
            return {};
        } catch (const AssemblyError& error) {
            return error.what();
        }
    };
    EXPECT_EQ(refusal({1, 1}), "");
    EXPECT_EQ(refusal({2, 2, 2}), "");
    EXPECT_EQ(refusal({0, 0}), "");
    const std::string unlike = refusal({1, 0});
    EXPECT_NE(unlike.find("velocities along none"), std::string::npos) << unlike;
    EXPECT_NE(unlike.find("'A0' (displacement along x)"), std::string::npos) << unlike;
    const std::string at_rest = refusal({0, 0, 0});
    EXPECT_NE(at_rest.find("at rest in a singular position"), std::string::npos) << at_rest;
}

// Independent rows: found on the way, when the sweeps fail.
TEST(SingularPositions, AheadMakeRowsSoft) {
    for (const double step : {0.0, 0.004}) {
        Simulation sim(hard::equal_bars(0, 6, true), with("radau", 1e-9, step));
        EXPECT_TRUE(sim.redundancy().dependent.empty());
        const StepOutcome outcome = sim.advance_to(4);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        EXPECT_GT(sim.statistics().softened_at, 0.5) << step;
        EXPECT_LT(std::abs(sim.sample().balance), 1e-6);
    }
}

// A driven crank whose rod, half as long, is upright at 30 degrees: no method goes on, whichever stopped
// last.
TEST(SingularPositions, WhereMechanismsLockAreNamed) {
    Model model;
    model.bodies = {make_body("crank", 1, {1e-4, 0.08, 0.08}, {0.5, 0, 0}),
                    make_body("rod", 1, {1e-4, 0.02, 0.02}, {1.25, 0, 0}),
                    make_body("slider", 1, {0.01, 0.01, 0.01}, {1.5, 0, 0})};
    const auto revolute = [&](const char* name, const char* a, const char* b, double x) {
        Joint joint = make_joint(name, JointKind::revolute, a, b, {x, 0, 0});
        joint.axes = {Vec3::UnitY(), Vec3::UnitY()};
        model.joints.push_back(joint);
    };
    revolute("A", "ground", "crank", 0);
    revolute("B", "crank", "rod", 1);
    revolute("C", "rod", "slider", 1.5);
    Joint guide = make_joint("D", JointKind::translation, "ground", "slider", {1.5, 0, 0});
    guide.axes = {Vec3::UnitX(), Vec3::UnitX()};
    model.joints.push_back(guide);
    model.joints[0].drives["angle"] = RampFunction{0, 1, 0};
    for (const char* integrator : {"gear", "radau", "auto"}) {
        Simulation sim(model, with(integrator, 1e-6));
        const StepOutcome outcome = sim.advance_to(1);
        ASSERT_FALSE(outcome.ok) << integrator;
        EXPECT_NEAR(sim.integrator().state().t, std::numbers::pi / 6, 1e-6);
        EXPECT_NE(outcome.message.find("next to a singular position"), std::string::npos) << outcome.message;
        EXPECT_NE(outcome.message.find("'D' (displacement along"), std::string::npos) << outcome.message;
    }
}

// rk4 has no error test: a stage next to the gimbal position is a kick of the first shaft, which turns
// evenly.
TEST(SingularPositions, KicksOfFixedStepsStopTheRun) {
    int stopped = 0;
    for (const double step : {0.0015, 0.002, 0.003, 0.005, 0.01}) {
        Simulation sim(hard::square_shafts(0.5, 2), with("rk4", 1e-6, step));
        const StepOutcome outcome = sim.advance_to(8);
        const Sample& sample = sim.sample();
        EXPECT_NEAR(sample.state.u[3], 2, 1e-3) << step;
        EXPECT_LT((sample.motion[1].A - Mat3::Identity()).norm(), 1e-3) << step;
        if (outcome.ok)
            continue;
        ++stopped;
        EXPECT_EQ(outcome.reason, StepReason::singular);
        EXPECT_NE(outcome.message.find("velocities jump"), std::string::npos) << outcome.message;
        EXPECT_NE(outcome.message.find("'out'"), std::string::npos) << outcome.message;
    }
    EXPECT_GE(stopped, 1);
    EXPECT_LT(stopped, 5);
}

// The blocks as stated in the header, by products with G, R, C, S and M.
TEST(StageMatrix, SolvesItsEquations) {
    const System system = compiled(hard::equal_bars(0.4, 3, true));
    const Eigen::Index n = system.velocities(), m = system.row_count();
    constexpr int stages = 2;
    StageMatrix matrix(system, stages);
    Eigen::Matrix2d a, h;
    a << 3, -1, 2, 5;
    h << 0.2, -0.1, 0.3, 0.4;
    matrix.couple(a, h);
    std::array<Workspace, stages> at{make_workspace(system), make_workspace(system)};
    const State state = initial_state(system);
    const auto number = [](Eigen::Index k) { return std::sin(1.0 + 1.7 * static_cast<double>(k)); };
    const auto numbers = [&](Eigen::Index size, int shift) {
        return VecX(VecX::NullaryExpr(size, [&](Eigen::Index k) { return number(k + shift); }));
    };
    std::vector<Mat3> P(stages * stages * system.moving), V(P.size());
    for (int i = 0; i < stages; ++i) {
        VecX q = state.q;
        move(system, 0.1 * numbers(n, 10 * i), q);
        set_motion(system, q, numbers(n, 5 + i), at[i]);
        linearise(system, 0, numbers(m, i).data(), at[i]);
        evaluate_rate_rows(system, 0, at[i]);
        matrix.set_stage(i, at[i]);
        for (int j = 0; j < stages; ++j)
            for (int b = 0; b < system.moving; ++b) {
                const int k = (i * stages + j) * system.moving + b;
                P[k] = Mat3::NullaryExpr([&](int r, int c) { return number(r + 3 * c + k); });
                P[k] += 3 * Mat3::Identity() * (i == j);
                V[k] = Mat3::NullaryExpr([&](int r, int c) { return number(7 + r + 3 * c + k); });
                matrix.pose_turn(i, j, b) = P[k];
                matrix.rate_turn(i, j, b) = V[k];
            }
    }
    ASSERT_TRUE(matrix.factor().ok());
    for (int i = 0; i < stages; ++i) {
        matrix.velocities(i) = numbers(n, 20 + i);
        matrix.poses(i) = numbers(n, 30 + i);
        matrix.multipliers(i) = numbers(m, 40 + i);
        matrix.position_multipliers(i) = numbers(m, 50 + i);
    }
    matrix.solve();
    for (int i = 0; i < stages; ++i) {
        const Workspace& ws = at[i];
        const VecX v = matrix.velocities(i), p = matrix.poses(i), l = matrix.multipliers(i),
                   mu = matrix.position_multipliers(i);
        VecX momentum = VecX::Zero(n), poses = VecX::Zero(n), part(n), rows(m);
        for (int j = 0; j < stages; ++j) {
            const VecX vj = matrix.velocities(j), pj = matrix.poses(j);
            momentum += a(i, j) * vj;
            for (int b = 0; b < system.moving; ++b) {
                const int k = (i * stages + j) * system.moving + b;
                poses.segment<3>(6 * b) += (i == j) * pj.segment<3>(6 * b) - h(i, j) * vj.segment<3>(6 * b);
                poses.segment<3>(6 * b + 3) +=
                    P[k] * pj.segment<3>(6 * b + 3) - V[k] * vj.segment<3>(6 * b + 3);
            }
        }
        mass_times(system, momentum, momentum);
        mass_times(system, poses, poses);
        blocks_times(system, ws.lin.C, v, part);
        momentum += part;
        blocks_times(system, ws.lin.S, p, part);
        momentum += part;
        add_transposed_rows(system, ws, l, 1, momentum);
        add_transposed_rows(system, ws, mu, -1, poses);
        EXPECT_LT((momentum - numbers(n, 20 + i)).cwiseAbs().maxCoeff(), 1e-7);
        EXPECT_LT((poses - numbers(n, 30 + i)).cwiseAbs().maxCoeff(), 1e-7);
        rows_times(system, ws, v, rows);
        VecX velocity = rows;
        rate_rows_times(system, ws, p, rows);
        velocity += rows;
        EXPECT_LT((velocity - numbers(m, 40 + i)).cwiseAbs().maxCoeff(), 1e-6);
        rows_times(system, ws, p, rows);
        EXPECT_LT((rows - numbers(m, 50 + i)).cwiseAbs().maxCoeff(), 1e-6);
    }
}

} // namespace
} // namespace gudgeon
