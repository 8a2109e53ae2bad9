#include "solvers/dense_solver.hpp"

#include "tests/solvers/sparse_samples.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gudgeon {
namespace {

using Eigen::MatrixXd;

TEST(DenseSolver, SolvesByHand) {
    // x + 2 y = 5, 3 x + 4 y = 11 has x = 1, y = 2.
    const CscMatrix a = samples::sparse((MatrixXd(2, 2) << 1, 2, 3, 4).finished());
    DenseSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    std::vector<double> b{5, 11, 1, 3};
    solver.solve(b, 2);
    EXPECT_NEAR(b[0], 1, 1e-14);
    EXPECT_NEAR(b[1], 2, 1e-14);
    EXPECT_NEAR(b[2], 1, 1e-14);
    EXPECT_NEAR(b[3], 0, 1e-14);
}

TEST(DenseSolver, BackwardErrorAtRoundOff) {
    const MatrixXd k = samples::badly_scaled(samples::saddle_point(30, 10, 4), 12, 2);
    const CscMatrix a = samples::sparse(k);
    DenseSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd b = k * samples::random_columns(40, 1, 1);
    MatrixXd x = b;
    solver.solve({x.data(), 40});
    EXPECT_LT(samples::backward_error(k, x, b), 1e-13);
}

TEST(DenseSolver, FlagsSingularAndNonFinite) {
    CscMatrix a = samples::sparse((MatrixXd(2, 2) << 1, 2, 2, 4).finished());
    DenseSolver solver;
    solver.analyse(a.pattern);
    EXPECT_EQ(solver.factor(a.values).kind, FactorStatus::Kind::singular);
    a.values[2] = std::numeric_limits<double>::quiet_NaN();
    const FactorStatus status = solver.factor(a.values);
    EXPECT_EQ(status.kind, FactorStatus::Kind::non_finite);
    EXPECT_EQ(status.column, 1);
}

} // namespace
} // namespace gudgeon
