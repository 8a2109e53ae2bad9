#include "solvers/cholmod_solver.hpp"

#include "tests/solvers/sparse_samples.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using Eigen::MatrixXd;

MatrixXd random_rows(int m, int n, int per_row, int seed) {
    samples::Random random(seed);
    MatrixXd b = MatrixXd::Zero(m, n);
    for (int i = 0; i < m; ++i) {
        b(i, i * n / m) = 1 + random.uniform() * 0.3;
        for (int k = 0; k < per_row; ++k)
            b(i, random.below(n)) = random.uniform();
    }
    return b;
}

MatrixXd solve(NormalSolver& solver, MatrixXd rhs) {
    solver.solve({rhs.data(), static_cast<std::size_t>(rhs.size())});
    return rhs;
}

TEST(NormalSolver, SolvesByHand) {
    // B = [3 4 0; 0 0 2]: B B^T = diag(25, 4).
    const CscMatrix b = samples::sparse((MatrixXd(2, 3) << 3, 4, 0, 0, 0, 2).finished());
    NormalSolver solver;
    solver.analyse(b.pattern);
    ASSERT_TRUE(solver.factor(b.values).ok());
    std::vector<double> x{50, 12};
    solver.solve(x);
    EXPECT_DOUBLE_EQ(x[0], 2);
    EXPECT_DOUBLE_EQ(x[1], 3);
    ASSERT_TRUE(solver.factor(b.values, 5).ok()); // diag(30, 9)
    x = {60, 27};
    solver.solve(x);
    EXPECT_DOUBLE_EQ(x[0], 2);
    EXPECT_DOUBLE_EQ(x[1], 3);
}

TEST(NormalSolver, AgreesWithDense) {
    for (const int m : {1, 5, 40, 150}) {
        const MatrixXd b = random_rows(m, 2 * m, 3, m);
        CscMatrix a = samples::sparse(b);
        NormalSolver solver;
        solver.analyse(a.pattern);
        samples::Random random(m);
        for (int step = 0; step < 3; ++step) {
            ASSERT_TRUE(solver.factor(a.values).ok()) << m;
            const MatrixXd d = samples::dense(a);
            const MatrixXd normal = d * d.transpose();
            const MatrixXd rhs = normal * samples::random_columns(m, 1, step);
            const MatrixXd exact = normal.fullPivLu().solve(rhs);
            EXPECT_LT((solve(solver, rhs) - exact).norm(), 1e-11 * exact.norm()) << m;
            for (double& v : a.values)
                v *= 1 + 0.1 * random.uniform();
        }
        EXPECT_EQ(solver.counts().factorisations, 1);
        EXPECT_EQ(solver.counts().refactorisations, 2);
        EXPECT_EQ(solver.counts().solves, 3);
    }
}

// Three columns of a body have the same rows, as its rotations have, and so have some of the next body.
TEST(NormalSolver, ColumnsWithTheSameRowsAgreeWithDense) {
    samples::Random random(3);
    constexpr int bodies = 12, rows = 2 * (bodies - 1);
    MatrixXd b = MatrixXd::Zero(rows, 4 * bodies);
    for (int r = 0; r < rows; ++r)
        for (const int body : {r / 2, r / 2 + 1})
            for (int k = r % 2; k < 4; ++k) // the first column of a body lacks the odd rows
                b(r, 4 * body + k) = random.uniform() + 1;
    const CscMatrix a = samples::sparse(b);
    NormalSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd normal = b * b.transpose();
    const MatrixXd exact = samples::random_columns(rows, 1, 1);
    EXPECT_LT((solve(solver, normal * exact) - exact).norm(), 1e-11 * exact.norm());
}

TEST(NormalSolver, BadlyScaledRows) {
    MatrixXd b = random_rows(60, 130, 3, 4);
    samples::Random random(3);
    for (int i = 0; i < 60; ++i)
        b.row(i) *= std::pow(10.0, 6 * random.uniform());
    const CscMatrix a = samples::sparse(b);
    NormalSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd normal = b * b.transpose();
    const MatrixXd rhs = normal * samples::random_columns(60, 1, 8);
    EXPECT_LT(samples::backward_error(normal, solve(solver, rhs), rhs), 1e-13);
}

TEST(NormalSolver, FlagsARepeatedRow) {
    for (const int seed : {1, 2, 3, 4}) {
        MatrixXd b = random_rows(40, 90, 3, seed);
        b.row(17) = 0.5 * b.row(3) - 2 * b.row(30);
        if (seed % 2 == 0)
            b.row(17) *= 1e6;
        const CscMatrix a = samples::sparse(b);
        NormalSolver solver;
        solver.analyse(a.pattern);
        const FactorStatus status = solver.factor(a.values);
        EXPECT_EQ(status.kind, FactorStatus::Kind::singular);
        EXPECT_TRUE(status.column == 3 || status.column == 17 || status.column == 30) << status.column;
        std::vector<double> rhs(40, 1.0);
        EXPECT_THROW(solver.solve(rhs), std::logic_error);
        EXPECT_TRUE(solver.factor(a.values, seed % 2 ? 1e-4 : 1e4).ok()); // beta makes it definite
    }
}

TEST(NormalSolver, FlagsAZeroRow) {
    CscMatrix a = samples::sparse(MatrixXd::Identity(3, 4));
    a.values[1] = 0;
    NormalSolver solver;
    solver.analyse(a.pattern);
    const FactorStatus status = solver.factor(a.values);
    EXPECT_EQ(status.kind, FactorStatus::Kind::singular);
    EXPECT_EQ(status.column, 1);
}

TEST(NormalSolver, FlagsNonFiniteInput) {
    CscMatrix a = samples::sparse(MatrixXd::Identity(3, 4));
    a.values[2] = std::numeric_limits<double>::infinity();
    NormalSolver solver;
    solver.analyse(a.pattern);
    const FactorStatus status = solver.factor(a.values);
    EXPECT_EQ(status.kind, FactorStatus::Kind::non_finite);
    EXPECT_EQ(status.column, 2);
    EXPECT_EQ(solver.factor(std::vector<double>(3, 1.0), NAN).kind, FactorStatus::Kind::non_finite);
}

TEST(NormalSolver, NoRows) {
    NormalSolver solver;
    solver.analyse({0, 3, {0, 0, 0, 0}, {}});
    EXPECT_TRUE(solver.factor({}).ok());
    solver.solve({});
}

} // namespace
} // namespace gudgeon
