// Complex sparse LU against dense LU.
#include "solvers/complex_klu_solver.hpp"

#include "tests/solvers/sparse_samples.hpp"

#include <Eigen/LU>

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

/// [A + i B, G^T; G, 0]: the imaginary part in the upper left block alone, as for a complex step.
MatrixXcd saddle_point(int n, int m, std::uint64_t seed) {
    MatrixXcd k = samples::saddle_point(n, m, seed).cast<Complex>();
    const MatrixXd imaginary = samples::saddle_point(n, m, seed + 1000);
    for (int i = 0; i < n; ++i)
        for (int j = std::max(0, i - 2); j < std::min(n, i + 3); ++j)
            k(i, j) += Complex(0, 0.7 * imaginary(i, j));
    return k;
}

/// Diagonal drawn over the given number of orders of magnitude.
MatrixXcd units(int n, double orders, std::uint64_t seed) {
    return samples::badly_scaled(MatrixXd::Identity(n, n), orders / 2, seed).cast<Complex>();
}

struct Sparse {
    CscPattern pattern;
    std::vector<Complex> values;
};

Sparse sparse(const MatrixXcd& k) {
    Sparse out{samples::sparse(k.cwiseAbs()).pattern, {}};
    for (int j = 0; j < k.cols(); ++j)
        for (int p = out.pattern.col_start[j]; p < out.pattern.col_start[j + 1]; ++p)
            out.values.push_back(k(out.pattern.row[p], j));
    return out;
}

MatrixXcd columns(int n, int count, std::uint64_t seed) {
    return samples::random_columns(n, count, seed).cast<Complex>() +
           Complex(0, 1) * samples::random_columns(n, count, seed + 1).cast<Complex>();
}

MatrixXcd solve(ComplexKluSolver& solver, MatrixXcd b) {
    solver.solve({b.data(), static_cast<std::size_t>(b.size())}, static_cast<int>(b.cols()));
    return b;
}

double backward_error(const MatrixXcd& a, const MatrixXcd& x, const MatrixXcd& b) {
    const Eigen::ArrayXXd residual = (b - a * x).array().abs();
    const Eigen::ArrayXXd size = (a.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs()).array();
    return (residual / (size + 1e-300)).maxCoeff();
}

TEST(ComplexKluSolver, SolvesByHand) {
    // 2i x + l = 4, x = 1 + i: the multiplier has a zero diagonal and is numbered first
    const Sparse k = sparse((MatrixXcd(2, 2) << 0, 1, 1, Complex(0, 2)).finished());
    ComplexKluSolver solver;
    solver.analyse(k.pattern);
    ASSERT_TRUE(solver.factor(k.values).ok());
    const MatrixXcd x = solve(solver, (MatrixXcd(2, 1) << Complex(1, 1), 4).finished());
    EXPECT_LT(std::abs(x(1) - Complex(1, 1)), 1e-15);
    EXPECT_LT(std::abs(x(0) - Complex(6, -2)), 1e-14);
}

TEST(ComplexKluSolver, AgreesWithDenseLu) {
    for (const int n : {1, 4, 17, 60, 240}) {
        const int m = n / 2;
        const MatrixXcd k = saddle_point(n, m, 11 + n);
        const Sparse a = sparse(k);
        ComplexKluSolver solver;
        solver.analyse(a.pattern);
        ASSERT_TRUE(solver.factor(a.values).ok()) << n;
        for (const int count : {1, 2}) {
            const MatrixXcd b = columns(n + m, count, 5), truth = k.partialPivLu().solve(b);
            const MatrixXcd x = solve(solver, b);
            EXPECT_LT((x - truth).norm(), 1e-11 * truth.norm()) << n;
            EXPECT_LT(backward_error(k, x, b), 1e-12) << n; // without refinement
        }
        EXPECT_EQ(solver.counts().solves, 3);
        EXPECT_EQ(solver.counts().factorisations, 1);
        EXPECT_GE(solver.factor_nonzeros(), n + m);
    }
}

// Unknowns and equations in odd units: the answer in good units keeps its accuracy.
TEST(ComplexKluSolver, BadScalingCostsNoAccuracy) {
    for (const double orders : {6.0, 12.0, 24.0}) {
        const MatrixXcd good = saddle_point(80, 35, 3), d = units(115, orders, 9), k = d * good * d;
        const Eigen::ArrayXd diagonal = k.cwiseAbs().diagonal().head(80);
        ASSERT_GT(diagonal.maxCoeff() / diagonal.minCoeff(), std::pow(10, 0.9 * orders));
        const Sparse a = sparse(k);
        const MatrixXcd b = columns(115, 2, 7), truth = good.partialPivLu().solve(b);
        ComplexKluSolver solver;
        solver.analyse(a.pattern);
        ASSERT_TRUE(solver.factor(a.values).ok()) << orders;
        EXPECT_LT((d * solve(solver, d * b) - truth).norm(), 1e-11 * truth.norm()) << orders;
    }
}

TEST(ComplexKluSolver, NewValuesGoThroughTheOldPivots) {
    const int n = 60, m = 25;
    ComplexKluSolver solver;
    solver.analyse(sparse(saddle_point(n, m, 30)).pattern);
    const MatrixXcd pattern = saddle_point(n, m, 30);
    for (int round = 0; round < 5; ++round) {
        MatrixXcd k = pattern;
        for (int i = 0; i < n; ++i)
            k(i, i) *= Complex(1 + 0.3 * round, 0.5 * round);
        const Sparse a = sparse(k);
        ASSERT_TRUE(solver.factor(a.values).ok()) << round;
        EXPECT_EQ(solver.counts().factorisations, 1);
        EXPECT_EQ(solver.counts().refactorisations, round);
        const MatrixXcd b = columns(n + m, 2, 40 + round), x = solve(solver, b);
        ComplexKluSolver anew;
        anew.analyse(a.pattern);
        ASSERT_TRUE(anew.factor(a.values).ok());
        const MatrixXcd y = solve(anew, b);
        EXPECT_EQ(anew.counts().factorisations, 1);
        EXPECT_LT((x - y).norm(), 1e-11 * y.norm()) << round;
        EXPECT_LT(backward_error(k, x, b), 1e-12) << round;
    }
}

TEST(ComplexKluSolver, UselessPivotsAreChosenAnew) {
    // the pivot on the diagonal fades away, first real, then imaginary
    const auto matrix = [](Complex first) {
        return (MatrixXcd(3, 3) << first, 1, 0.5, 1, Complex(2, 1), 0.25, 0.5, 0.25, Complex(0, 3))
            .finished();
    };
    ComplexKluSolver solver;
    solver.analyse(sparse(matrix(4)).pattern);
    for (const Complex first : {Complex(4, 0), Complex(1e-18, 0), Complex(0, 5), Complex(0, 1e-18)}) {
        const MatrixXcd k = matrix(first), b = columns(3, 2, 3);
        ASSERT_TRUE(solver.factor(sparse(k).values).ok());
        EXPECT_LT(backward_error(k, solve(solver, b), b), 1e-13) << first;
    }
    EXPECT_GT(solver.counts().factorisations, 1);
}

TEST(ComplexKluSolver, SingularMatrixIsToldAndForgotten) {
    const MatrixXcd good = saddle_point(20, 8, 5);
    MatrixXcd bad = good; // two constraint rows alike, a multiple apart by i
    const Sparse a = sparse(MatrixXcd::Ones(28, 28));
    const auto values = [](const MatrixXcd& k) {
        return std::vector<Complex>(k.data(), k.data() + k.size());
    };
    bad.row(27) = Complex(0, 1) * bad.row(26);
    bad.col(27) = Complex(0, 1) * bad.col(26);
    ComplexKluSolver solver;
    solver.analyse(a.pattern);
    const MatrixXcd b = columns(28, 2, 3);
    for (int round = 0; round < 2; ++round) { // as the first matrix and after a good one
        MatrixXcd zero_column = good;
        zero_column.col(3).setZero();
        EXPECT_EQ(solver.factor(values(zero_column)).kind, FactorStatus::Kind::singular);
        MatrixXcd x = b;
        EXPECT_THROW(solver.solve({x.data(), 56}, 2), std::logic_error);
        const FactorStatus status = solver.factor(values(bad));
        if (status.ok()) { // round-off may leave a pivot: then the solution shows it
            EXPECT_GT(solve(solver, b).cwiseAbs().maxCoeff(), 1e10);
        }
        ASSERT_TRUE(solver.factor(values(good)).ok());
        EXPECT_LT(backward_error(good, solve(solver, b), b), 1e-12);
    }
}

TEST(ComplexKluSolver, NumbersThatAreNoneAreTold) {
    const Sparse a = sparse(saddle_point(10, 4, 5));
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    ComplexKluSolver solver;
    solver.analyse(a.pattern);
    for (const Complex bad : {Complex(nan, 0), Complex(0, nan), Complex(inf, 0), Complex(1, -inf)}) {
        std::vector<Complex> values = a.values;
        values[values.size() / 2] = bad;
        EXPECT_EQ(solver.factor(values).kind, FactorStatus::Kind::non_finite);
        std::vector<Complex> x(14, 1);
        EXPECT_THROW(solver.solve(x, 1), std::logic_error);
    }
    ASSERT_TRUE(solver.factor(a.values).ok());
}

TEST(ComplexKluSolver, MisuseIsRefused) {
    const Sparse a = sparse(saddle_point(10, 4, 5));
    ComplexKluSolver solver;
    solver.analyse(a.pattern);
    std::vector<Complex> x(14, 1), few(a.values.begin(), a.values.end() - 1);
    EXPECT_THROW(solver.solve(x, 1), std::logic_error);
    EXPECT_THROW(solver.factor(few), std::invalid_argument);
    ASSERT_TRUE(solver.factor(a.values).ok());
    EXPECT_THROW(solver.solve(x, 2), std::invalid_argument);
    CscPattern wide = a.pattern;
    ++wide.cols;
    EXPECT_THROW(solver.analyse(wide), std::invalid_argument);
    solver.analyse(a.pattern);
    EXPECT_THROW(solver.solve(x, 1), std::logic_error); // the factors are gone
    ComplexKluSolver empty;
    CscPattern none;
    none.col_start = {0};
    empty.analyse(none);
    EXPECT_TRUE(empty.factor({}).ok());
    EXPECT_NO_THROW(empty.solve({}, 2));
}

} // namespace
} // namespace gudgeon
