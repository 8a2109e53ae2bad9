#include "solvers/klu_solver.hpp"

#include "solvers/dense_solver.hpp"
#include "solvers/equilibration.hpp"
#include "solvers/saddle_ordering.hpp"
#include "tests/solvers/sparse_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace gudgeon {
namespace {

using Eigen::MatrixXd;
using samples::backward_error;

MatrixXd solve(LinearSolver& solver, MatrixXd b) {
    solver.solve({b.data(), static_cast<std::size_t>(b.size())}, static_cast<int>(b.cols()));
    return b;
}

double relative_difference(const MatrixXd& x, const MatrixXd& y) { return (x - y).norm() / y.norm(); }

TEST(KluSolver, SolvesByHand) {
    // 2 x + l = 4, x = 1: the multiplier has a zero diagonal and is numbered first.
    const CscMatrix k = samples::sparse((MatrixXd(2, 2) << 0, 1, 1, 2).finished());
    KluSolver solver;
    solver.analyse(k.pattern);
    ASSERT_TRUE(solver.factor(k.values).ok());
    const MatrixXd x = solve(solver, (MatrixXd(2, 1) << 1, 4).finished());
    EXPECT_DOUBLE_EQ(x(0), 2);
    EXPECT_DOUBLE_EQ(x(1), 1);
}

TEST(KluSolver, AgreesWithDenseLu) {
    for (const int n : {1, 4, 17, 60, 240}) {
        const int m = n / 2;
        const MatrixXd k = samples::saddle_point(n, m, 11 + n);
        const CscMatrix a = samples::sparse(k);
        const MatrixXd b = samples::random_columns(n + m, 2, 5);
        KluSolver klu;
        DenseSolver oracle;
        klu.analyse(a.pattern);
        oracle.analyse(a.pattern);
        ASSERT_TRUE(klu.factor(a.values).ok()) << n;
        ASSERT_TRUE(oracle.factor(a.values).ok()) << n;
        const MatrixXd x = solve(klu, b);
        EXPECT_LT(relative_difference(x, solve(oracle, b)), 1e-12) << n;
        EXPECT_LT(backward_error(k, x, b), 1e-15) << n;
    }
}

TEST(KluSolver, BadScalingCostsNoAccuracy) {
    for (const double orders : {6.0, 12.0, 24.0}) {
        const MatrixXd k = samples::badly_scaled(samples::saddle_point(80, 35, 3), orders, 9);
        const CscMatrix a = samples::sparse(k);
        const MatrixXd b = k * samples::random_columns(115, 2, 7);
        KluSolver solver;
        solver.analyse(a.pattern);
        ASSERT_TRUE(solver.factor(a.values).ok()) << orders;
        EXPECT_LT(backward_error(k, solve(solver, b), b), 1e-13) << orders;
    }
}

TEST(KluSolver, UnitsByPowersOfTwoChangeNoBit) {
    const MatrixXd k = samples::saddle_point(40, 15, 21);
    const MatrixXd b = samples::random_columns(55, 1, 2);
    MatrixXd x[2];
    for (const double unit : {1.0, 1048576.0}) {
        const CscMatrix a = samples::sparse(unit * k);
        KluSolver solver;
        solver.analyse(a.pattern);
        ASSERT_TRUE(solver.factor(a.values).ok());
        x[unit > 1] = solve(solver, unit * b);
    }
    EXPECT_EQ((x[0] - x[1]).norm(), 0);
}

TEST(KluSolver, RefactorisationEqualsNewFactorisation) {
    const MatrixXd k0 = samples::saddle_point(150, 60, 1);
    KluSolver kept;
    CscMatrix a = samples::sparse(k0);
    kept.analyse(a.pattern);
    ASSERT_TRUE(kept.factor(a.values).ok());
    samples::Random random(8);
    for (int step = 0; step < 20; ++step) {
        for (double& v : a.values)
            v *= 1 + 0.05 * random.uniform();
        KluSolver fresh;
        fresh.analyse(a.pattern);
        ASSERT_TRUE(kept.factor(a.values).ok());
        ASSERT_TRUE(fresh.factor(a.values).ok());
        const MatrixXd b = samples::random_columns(210, 1, 40 + step);
        const MatrixXd x = solve(kept, b);
        EXPECT_LT(relative_difference(x, solve(fresh, b)), 1e-13);
        EXPECT_LT(backward_error(samples::dense(a), x, b), 4e-15);
    }
    EXPECT_EQ(kept.counts().factorisations, 1);
    EXPECT_EQ(kept.counts().refactorisations, 20);
}

TEST(KluSolver, ChoosesNewPivotsWhenTheOldOnesFail) {
    // First each diagonal entry is the pivot, then it is nearly or exactly zero.
    const auto matrix = [](double diagonal) {
        MatrixXd k = MatrixXd::Identity(4, 4) * diagonal;
        k(0, 1) = k(1, 0) = k(2, 3) = k(3, 2) = 0.5;
        return k;
    };
    const CscPattern pattern = samples::sparse(matrix(1)).pattern;
    const auto values = [&](const MatrixXd& k) {
        std::vector<double> out;
        for (int j = 0; j < 4; ++j)
            for (int p = pattern.col_start[j]; p < pattern.col_start[j + 1]; ++p)
                out.push_back(k(pattern.row[p], j));
        return out;
    };
    for (const double diagonal : {1e-14, 0.0}) {
        KluSolver solver;
        solver.analyse(pattern);
        ASSERT_TRUE(solver.factor(values(matrix(1))).ok());
        ASSERT_TRUE(solver.factor(values(matrix(diagonal))).ok());
        EXPECT_EQ(solver.counts().factorisations, 2);
        EXPECT_EQ(solver.counts().refactorisations, 0);
        const MatrixXd b = samples::random_columns(4, 1, 3);
        EXPECT_LT(backward_error(matrix(diagonal), solve(solver, b), b), 1e-15);
    }
}

TEST(KluSolver, RefinementReachesRoundOff) {
    const MatrixXd k = samples::badly_scaled(samples::saddle_point(200, 90, 17), 8, 4);
    const CscMatrix a = samples::sparse(k);
    const MatrixXd b = samples::random_columns(290, 1, 1);
    // A tiny pivot tolerance makes the factors poor on purpose.
    KluSolver refined(KluOptions{.pivot_tolerance = 1e-8});
    KluSolver plain(KluOptions{.pivot_tolerance = 1e-8, .refinements = 0});
    for (KluSolver* solver : {&refined, &plain}) {
        solver->analyse(a.pattern);
        ASSERT_TRUE(solver->factor(a.values).ok());
    }
    EXPECT_LT(backward_error(k, solve(refined, b), b), 2e-15);
    solve(plain, b);
    EXPECT_EQ(plain.counts().refinements, 0);
    EXPECT_EQ(refined.counts().solves, 1);
}

TEST(KluSolver, ColumnsAreSolvedTogetherAsAlone) {
    const MatrixXd k = samples::saddle_point(50, 20, 6);
    const CscMatrix a = samples::sparse(k);
    KluSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd b = samples::random_columns(70, 5, 12);
    const MatrixXd together = solve(solver, b);
    for (int c = 0; c < 5; ++c)
        EXPECT_LT(relative_difference(together.col(c), solve(solver, b.col(c))), 1e-13);
    EXPECT_EQ(solver.counts().solves, 10);
}

TEST(KluSolver, FlagsRepeatedConstraints) {
    for (const int seed : {1, 2, 3, 4, 5}) {
        MatrixXd k = samples::saddle_point(60, 25, seed);
        const int n = 60;
        const Eigen::RowVectorXd sum = 0.7 * k.row(n + 3) - 0.4 * k.row(n + 4) + 0.1 * k.row(n + 9);
        k.row(n + 5) = sum;
        k.col(n + 5) = sum.transpose();
        if (seed % 2 == 0)
            k = samples::badly_scaled(k, 8, seed);
        const CscMatrix a = samples::sparse(k);
        for (const bool dense : {false, true}) {
            std::unique_ptr<LinearSolver> solver;
            if (dense)
                solver = std::make_unique<DenseSolver>();
            else
                solver = std::make_unique<KluSolver>();
            solver->analyse(a.pattern);
            const FactorStatus status = solver->factor(a.values);
            EXPECT_EQ(status.kind, FactorStatus::Kind::singular) << seed << solver->name();
            EXPECT_GE(status.column, 0);
            EXPECT_LT(status.column, 85);
            std::vector<double> b(85, 1.0);
            EXPECT_THROW(solver->solve(b), std::logic_error);
        }
    }
}

TEST(KluSolver, StiffIsNotSingular) {
    // Two unit masses joined by a spring of 1e10: the second pivot is 2e-10 of its column.
    const double stiffness = 1e10;
    MatrixXd k(2, 2);
    k << 1 + stiffness, -stiffness, -stiffness, 1 + stiffness;
    const CscMatrix a = samples::sparse(k);
    KluSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd x = solve(solver, MatrixXd::Ones(2, 1)); // rigid motion: the spring does not stretch
    EXPECT_NEAR(x(0), 1, 1e-6);
    EXPECT_NEAR(x(1), 1, 1e-6);
}

TEST(KluSolver, NamesAnEmptyColumn) {
    MatrixXd k = samples::saddle_point(12, 4, 2);
    k.row(7).setZero();
    k.col(7).setZero();
    k(7, 7) = 1;
    CscMatrix a = samples::sparse(k);
    a.values[a.pattern.col_start[7]] = 0;
    KluSolver solver;
    solver.analyse(a.pattern);
    const FactorStatus status = solver.factor(a.values);
    EXPECT_EQ(status.kind, FactorStatus::Kind::singular);
    EXPECT_EQ(status.column, 7);
    a.values[a.pattern.col_start[7]] = 1;
    EXPECT_TRUE(solver.factor(a.values).ok()); // and goes on after it
}

TEST(KluSolver, FlagsNonFiniteInput) {
    CscMatrix a = samples::sparse(samples::saddle_point(12, 4, 2));
    KluSolver solver;
    solver.analyse(a.pattern);
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        CscMatrix broken = a;
        broken.values[a.pattern.col_start[9]] = bad;
        const FactorStatus status = solver.factor(broken.values);
        EXPECT_EQ(status.kind, FactorStatus::Kind::non_finite);
        EXPECT_EQ(status.column, 9);
        EXPECT_TRUE(solver.factor(a.values).ok());
    }
}

TEST(KluSolver, TakesAGivenOrdering) {
    const MatrixXd k = samples::saddle_point(30, 12, 5);
    const CscMatrix a = samples::sparse(k);
    KluSolver solver;
    std::vector<int> perm(42);
    std::iota(perm.rbegin(), perm.rend(), 0);
    solver.set_ordering(perm);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd b = samples::random_columns(42, 1, 3);
    EXPECT_LT(backward_error(k, solve(solver, b), b), 1e-15);
    perm[0] = perm[1];
    solver.set_ordering(perm);
    EXPECT_THROW(solver.analyse(a.pattern), std::invalid_argument);
}

TEST(KluSolver, RefusesMisuse) {
    KluSolver solver;
    std::vector<double> b(2, 1.0);
    EXPECT_THROW(solver.factor(b), std::logic_error);
    EXPECT_THROW(solver.solve(b), std::logic_error);
    EXPECT_THROW(solver.analyse({2, 3, {0, 0, 0, 0}, {}}), std::invalid_argument);
    EXPECT_THROW(solver.analyse({2, 2, {0, 2, 2}, {1, 0}}), std::invalid_argument);
    EXPECT_THROW(solver.analyse({2, 2, {0, 1, 2}, {0, 2}}), std::invalid_argument);
    solver.analyse({2, 2, {0, 1, 2}, {0, 1}});
    EXPECT_THROW(solver.factor(std::vector<double>(3, 1.0)), std::invalid_argument);
    ASSERT_TRUE(solver.factor(b).ok());
    b.push_back(1);
    EXPECT_THROW(solver.solve(b), std::invalid_argument);
}

TEST(KluSolver, EmptySystem) {
    KluSolver solver;
    solver.analyse({0, 0, {0}, {}});
    EXPECT_TRUE(solver.factor({}).ok());
    solver.solve({});
}

TEST(Equilibration, LightBodyBetweenStiffConstraintsKeepsItsPivot) {
    // Diagonal 1e-8 against coefficients of one: scaled to order one on both.
    const CscMatrix a = samples::sparse((MatrixXd(2, 2) << 1e-8, 1, 1, 0).finished());
    Equilibration e;
    e.analyse(a.pattern);
    e.compute(a.values);
    const double diagonal = e.row()[0] * 1e-8 * e.col()[0], off = e.row()[1] * e.col()[0];
    EXPECT_GE(diagonal, 0.25);
    EXPECT_LE(diagonal, 4);
    EXPECT_GE(off, 0.5);
    EXPECT_LE(off, 2);
    EXPECT_EQ(e.row(), e.col());
    int exponent = 0;
    EXPECT_EQ(std::frexp(e.row()[0], &exponent), 0.5); // a power of two
}

TEST(SaddleOrdering, PutsEveryMultiplierAfterAnUnknownItConstrains) {
    const int n = 90, m = 40;
    const CscMatrix a = samples::sparse(samples::saddle_point(n, m, 13));
    const std::vector<int> perm = saddle_ordering(a.pattern);
    std::vector<int> sorted = perm, expected(n + m);
    std::sort(sorted.begin(), sorted.end());
    std::iota(expected.begin(), expected.end(), 0);
    ASSERT_EQ(sorted, expected);
    const MatrixXd k = samples::dense(a);
    for (int i = 0; i < n + m; ++i)
        if (perm[i] >= n) {
            ASSERT_GT(i, 0);
            EXPECT_NE(k(perm[i], perm[i - 1]), 0);
        }
}

} // namespace
} // namespace gudgeon
