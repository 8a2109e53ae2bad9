// Projections in the mass norm and accelerations against dense solves of the whole saddle system.
#include "solvers/consistent.hpp"

#include "tests/core/whole_models.hpp"
#include "tests/solvers/system_tools.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

struct DenseStep {
    VecX x, nu;
};

// min 1/2 x^T M x - f^T x with G x = b, over the free coordinates: [M G^T; G 0] [x; nu] = [f; b].
DenseStep dense_solve(MatX M, MatX G, const VecX& f, const VecX& b, const std::vector<int>& held = {}) {
    const Eigen::Index n = M.rows(), m = G.rows();
    for (const int k : held) { // x_k = 0
        M.row(k).setZero();
        M.col(k).setZero();
        M(k, k) = 1;
        G.col(k).setZero();
    }
    MatX K = MatX::Zero(n + m, n + m);
    K << M, G.transpose(), G, MatX::Zero(m, m);
    VecX rhs(n + m);
    rhs << f, b;
    for (const int k : held)
        rhs[k] = 0;
    const VecX x = K.fullPivLu().solve(rhs);
    return {x.head(n), x.tail(m)};
}

/// Step along T(q) from one pose to another, 6 per body (small turns, body frame).
VecX step_between(const System& system, const VecX& from, const VecX& to) {
    VecX step(system.velocities());
    for (int i = 0; i < system.moving; ++i) {
        step.segment<3>(6 * i) = to.segment<3>(7 * i) - from.segment<3>(7 * i);
        const Vec4 p = from.segment<4>(7 * i + 3);
        step.segment<3>(6 * i + 3) = 2 * l_times(p, to.segment<4>(7 * i + 3));
    }
    return step;
}

struct Mechanisms : testing::TestWithParam<std::string> {
    System system = GetParam() == "every-joint" ? compiled(every_joint()) : compiled(GetParam());
    Workspace ws = make_workspace(system);
    ConsistentSolver solver{system};
    std::mt19937 rng{9};

    /// A state with closed constraints to start from.
    State closed() {
        State state = initial_state(system);
        solver.regularise(1e-9); // the ladder starts wide open
        solver.limit_move(0.3);
        for (int i = 0; i < 20 && !solver.project_positions(0, state.q, state.u, ws); ++i) {
        }
        EXPECT_LT(solver.worst_position(), 1e-12);
        solver.regularise(0);
        solver.limit_move(1e300);
        return state;
    }
    State shaken_from(const State& closed_state, double moved) {
        State state = closed_state;
        VecX step(system.velocities());
        for (double& x : step)
            x = std::uniform_real_distribution<double>(-moved, moved)(rng);
        move(system, step, state.q);
        return state;
    }
};

TEST_P(Mechanisms, VelocitiesChangeLeastInTheMassNorm) {
    State state = closed();
    for (double& x : state.u)
        x = std::uniform_real_distribution<double>(-2, 2)(rng);
    set_motion(system, state.q, state.u, ws);
    evaluate_constraints(system, 0, nullptr, true, ws);
    const MatX G = dense(rows_as_matrix(system, ws));
    const VecX rate = ws.rate;
    const DenseStep least = dense_solve(dense_mass(system), G, VecX::Zero(system.velocities()), rate);
    VecX u = state.u;
    ASSERT_TRUE(solver.project_velocities(0, state.q, u, ws));
    EXPECT_LT(error(state.u - u, least.x), 1e-11);
    EXPECT_LT(ws.rate.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((rate - G * (state.u - u)).cwiseAbs().maxCoeff(), 1e-12);
    // it is the least: no other velocity that satisfies the rows is nearer
    const VecX change = state.u - u, other = G.fullPivLu().kernel().col(0);
    EXPECT_LT(std::abs(change.dot(dense_mass(system) * other)), 1e-10 * change.norm() * other.norm());
}

// Closing is nonlinear: the difference to one linear step is of second order in the gap.
TEST_P(Mechanisms, PositionsChangeLeastInTheMassNorm) {
    const State start = closed();
    double differences[2];
    for (const int k : {0, 1}) {
        rng.seed(4);
        const State open = shaken_from(start, k == 0 ? 2e-3 : 1e-3);
        const MatX G = dense_rows(system, open, ws);
        const VecX phi = ws.phi;
        const DenseStep least = dense_solve(dense_mass(system), G, VecX::Zero(system.velocities()), phi);
        VecX q = open.q;
        ASSERT_TRUE(solver.project_positions(0, q, open.u, ws));
        EXPECT_LT(ws.phi.cwiseAbs().maxCoeff(), 1e-13 * (1 + q.cwiseAbs().maxCoeff()));
        const VecX change = step_between(system, open.q, q);
        EXPECT_GT(change.norm(), 1e-4);
        differences[k] = (change + least.x).norm();
        EXPECT_LT(differences[k], 0.03 * change.norm());
    }
    EXPECT_NEAR(differences[0] / differences[1], 4, 0.5);
}

// Coordinates of a body, at most two, that the rows leave free: without them G keeps its rank.
std::vector<int> free_to_hold(MatX G, int body) {
    std::vector<int> held;
    for (const int k : {4, 2, 3, 0, 5, 1}) {
        const VecX column = G.col(6 * body + k);
        G.col(6 * body + k).setZero();
        Eigen::FullPivLU<MatX> lu;
        lu.setThreshold(1e-2);
        if (held.size() < 2 && lu.compute(G).rank() == G.rows())
            held.push_back(6 * body + k);
        else
            G.col(6 * body + k) = column;
    }
    return held;
}

TEST_P(Mechanisms, HeldCoordinatesStay) {
    const State start = closed();
    const State open = shaken_from(start, 1e-4);
    const MatX G = dense_rows(system, open, ws);
    const VecX phi = ws.phi, zero = VecX::Zero(system.velocities());
    const int body = 1;
    const std::vector<int> held = free_to_hold(G, body);
    ASSERT_FALSE(held.empty());
    std::vector<unsigned> bits(system.moving, 0u);
    for (const int k : held)
        bits[body] |= 1u << (k - 6 * body) | 1u << (6 + k - 6 * body);
    solver.hold(bits);

    VecX q = open.q;
    ASSERT_TRUE(solver.project_positions(0, q, open.u, ws));
    const VecX change = step_between(system, open.q, q);
    for (const int k : held) { // turns about the axes of the start: zero to second order
        EXPECT_LT(std::abs(change[k]), k % 6 < 3 ? 1e-16 : 1e-6) << k;
    }
    const DenseStep least = dense_solve(dense_mass(system), G, zero, phi, held);
    EXPECT_GT(change.norm(), 1e-5);
    EXPECT_LT((change + least.x).norm(), 0.02 * change.norm());

    VecX u = open.u;
    for (double& x : u)
        x += std::uniform_real_distribution<double>(-1, 1)(rng);
    State at_end = open;
    at_end.q = q;
    at_end.u = u;
    const MatX G_end = dense_rows(system, at_end, ws);
    const DenseStep least_u = dense_solve(dense_mass(system), G_end, zero, ws.rate, held);
    VecX projected = u;
    ASSERT_TRUE(solver.project_velocities(0, q, projected, ws));
    EXPECT_LT(error(u - projected, least_u.x), 1e-9);
    for (const int k : held)
        EXPECT_EQ(projected[k], u[k]) << k;
}

TEST_P(Mechanisms, AccelerationsSolveTheSaddleSystem) {
    State state = closed();
    for (double& x : state.u)
        x = std::uniform_real_distribution<double>(-2, 2)(rng);
    ASSERT_TRUE(solver.project_velocities(0, state.q, state.u, ws));
    VecX acceleration, lambda, gamma(system.row_count());
    solver.hold(std::vector<unsigned>(system.moving, 0xfffu)); // of no meaning here
    ASSERT_TRUE(solver.accelerations(0, state.q, state.u, ws, acceleration, lambda));
    const MatX G = dense_rows(system, state, ws);
    evaluate_forces(system, 0, ws);
    for (const auto& batch : system.constraints)
        batch->acceleration_rhs(evaluation(system, ws, 0), gamma.data());
    const DenseStep truth = dense_solve(dense_mass(system), G, ws.f, gamma);
    EXPECT_LT(error(acceleration, truth.x), 1e-11);
    EXPECT_LT(error(lambda, truth.nu), 1e-11);
    EXPECT_LT(error(G * acceleration, gamma), 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Consistent, Mechanisms,
                         testing::Values("slider-crank", "chain", "triple-pendulum", "suspension-chain",
                                         "every-joint"),
                         [](const auto& info) {
                             std::string name = info.param;
                             std::erase(name, '-');
                             return name;
                         });

TEST(ConsistentSolver, RowsThatRepeatEachOtherCloseToo) {
    const System system = compiled("four-bar");
    Workspace ws = make_workspace(system);
    ConsistentSolver solver(system);
    State state = initial_state(system);
    VecX acceleration, lambda, u = state.u, q = state.q;
    u[0] += 0.1;
    q[0] += 1e-3;
    ASSERT_TRUE(solver.project_velocities(0, state.q, u, ws)); // soft from here on
    EXPECT_TRUE(solver.soft());
    EXPECT_LT(ws.rate.cwiseAbs().maxCoeff(), 1e-11);
    ASSERT_TRUE(solver.project_positions(0, q, state.u, ws));
    EXPECT_LT(ws.phi.cwiseAbs().maxCoeff(), 1e-12);
    ASSERT_TRUE(solver.accelerations(0, state.q, state.u, ws, acceleration, lambda));
    EXPECT_EQ(solver.deficiency(), 3);
    // upright at 1 rad/s: the couplers' centre is drawn down by w^2 l
    EXPECT_NEAR(acceleration[6 * system.body_index("coupler1") + 2], -1, 1e-10);
}

// A chain of 1e-6 ... 1e6 kg outwards turns about its light end, stretched out. Its rows are independent
// although N has pivots of round-off's size beside its largest: joints pull what lies beyond them on its
// circle.
TEST(ConsistentSolver, MassesOverTwelveOrders) {
    Model model = build_mechanism("chain", {{"links", "13"}});
    model.gravity = Vec3::Zero();
    double mass = 1e-6;
    for (Body& body : model.bodies) {
        body.mass *= mass;
        body.inertia *= mass;
        mass *= 10;
        body.angular_velocity = {0, 2, 0};
        body.velocity = body.angular_velocity.cross(body.position);
    }
    const System system = compiled(model);
    Workspace ws = make_workspace(system);
    ConsistentSolver solver(system);
    const State state = initial_state(system);
    VecX acceleration, lambda, pushed = VecX::Zero(system.velocities());
    ASSERT_TRUE(solver.accelerations(0, state.q, state.u, ws, acceleration, lambda));
    EXPECT_FALSE(solver.soft());
    add_transposed_rows(system, ws, lambda, -1.0, pushed);
    for (int i = 0; i < 13; ++i) {
        const double inwards = -4 * (i + 0.5);
        EXPECT_NEAR(acceleration[6 * i], inwards, 1e-11 * std::abs(inwards)) << i;
        EXPECT_NEAR(pushed[6 * i], model.bodies[i].mass * inwards, 1e-8) << i; // differences of 5e7 N
    }
}

TEST(ConsistentSolver, NothingToCloseWithoutRows) {
    Model model;
    model.bodies = {make_body("stone", 2, {1, 1, 1}, {0, 0, 3})};
    const System system = compiled(model);
    Workspace ws = make_workspace(system);
    ConsistentSolver solver(system);
    State state = initial_state(system);
    VecX acceleration, lambda;
    EXPECT_TRUE(solver.project_positions(0, state.q, state.u, ws));
    EXPECT_TRUE(solver.project_velocities(0, state.q, state.u, ws));
    ASSERT_TRUE(solver.accelerations(0, state.q, state.u, ws, acceleration, lambda));
    EXPECT_EQ(lambda.size(), 0);
    EXPECT_EQ(acceleration, (Vec6() << 0, 0, -9.81, 0, 0, 0).finished());
}

} // namespace
} // namespace gudgeon
