// The augmented Lagrangian on CHOLMOD against dense LU of the saddle-point matrix itself.
#include "solvers/augmented_solver.hpp"

#include "tests/allocation_count.hpp"
#include "tests/solvers/sparse_samples.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd solved(AugmentedSolver& solver, MatrixXd rhs) {
    solver.solve({rhs.data(), static_cast<std::size_t>(rhs.size())}, static_cast<int>(rhs.cols()));
    return rhs;
}

/// Solves by both and expects agreement relative to each unknown's own size in units of `unit`.
void expect_agreement(const MatrixXd& k, int leading, double bound, long most_iterations = 25) {
    const CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(leading);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    for (const int columns : {1, 2, 3}) {
        const MatrixXd b = samples::random_columns(static_cast<int>(k.rows()), columns, 7);
        const MatrixXd x = solved(solver, b), truth = k.fullPivLu().solve(b);
        for (int c = 0; c < columns; ++c)
            EXPECT_LT((x.col(c) - truth.col(c)).norm(), bound * truth.col(c).norm()) << c;
    }
    EXPECT_EQ(solver.counts().klu_fallbacks, 0);
    EXPECT_EQ(solver.counts().cholmod_factorisations, 1);
    EXPECT_EQ(solver.counts().cholmod_solves, 6);
    EXPECT_LE(solver.counts().cholmod_iterations, 4 * most_iterations); // 1, 2 together, 2 together and 1
}

/// Symmetric, A positive definite.
MatrixXd symmetric_saddle(int n, int m, std::uint64_t seed) {
    const MatrixXd k = samples::saddle_point(n, m, seed);
    return 0.5 * (k + k.transpose());
}

TEST(AugmentedSolver, SolvesByHand) {
    // du = (1, 2) and dlambda = 3: 2 du1 + 3 = 5, 4 du2 + 3 = 11, du1 + du2 = 3
    const MatrixXd k = (MatrixXd(3, 3) << 2, 0, 1, 0, 4, 1, 1, 1, 0).finished();
    const CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(2);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd x = solved(solver, (MatrixXd(3, 1) << 5, 11, 3).finished());
    EXPECT_NEAR(x(0), 1, 1e-10);
    EXPECT_NEAR(x(1), 2, 1e-10);
    EXPECT_NEAR(x(2), 3, 1e-9);
}

TEST(AugmentedSolver, SymmetricMatricesTakeFewPasses) {
    for (const int n : {6, 40, 200})
        expect_agreement(symmetric_saddle(n, n / 3, n), n, 1e-8, 3);
}

TEST(AugmentedSolver, WithoutConstraints) { expect_agreement(symmetric_saddle(30, 0, 1), 30, 1e-9, 2); }

TEST(AugmentedSolver, SkewPartOfTheLeadingBlockComesBack) {
    const int n = 60, m = 20;
    MatrixXd k = symmetric_saddle(n, m, 3);
    for (int i = 0; i + 1 < n; i += 3) { // gyroscopic
        k(i, i + 1) += 1.5;
        k(i + 1, i) -= 1.5;
    }
    expect_agreement(k, n, 1e-8);
}

TEST(AugmentedSolver, FrictionBesideTheReactions) {
    const int n = 60, m = 20;
    MatrixXd k = symmetric_saddle(n, m, 4);
    for (int r = 0; r < m; ++r) // K's upper block is not G^T: forces across the constrained direction
        k(r * n / m + 1, n + r) += 0.3;
    expect_agreement(k, n, 1e-8);
}

TEST(AugmentedSolver, UnitsAndMassesAreHarmless) {
    const int n = 60, m = 20;
    MatrixXd k = symmetric_saddle(n, m, 5);
    VectorXd d(n + m);
    for (int i = 0; i < n + m; ++i)
        d[i] = std::pow(10.0, i % 7 - 3); // masses from 1e-6 to 1e6
    k = (d.asDiagonal() * k * d.asDiagonal()).eval();
    const CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(n);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd b = d.asDiagonal() * samples::random_columns(n + m, 1, 9);
    const MatrixXd x = d.asDiagonal() * solved(solver, b), truth = d.asDiagonal() * k.fullPivLu().solve(b);
    EXPECT_LT((x - truth).norm(), 1e-8 * truth.norm());
    EXPECT_LE(solver.counts().cholmod_iterations, 3);
    EXPECT_EQ(solver.counts().klu_fallbacks, 0);
}

// Two unit masses on a line, joined by a spring of 1e12, the first one held: (m a0 + k / a0) per unit.
TEST(AugmentedSolver, StiffSpringsBesideConstraints) {
    const double m = 1, a0 = 100, s = 1e12 / a0;
    MatrixXd k = MatrixXd::Zero(4, 4);
    k.topLeftCorner(3, 3) << m * a0 + s, -s, 0, -s, m * a0 + s, 0, 0, 0, m * a0;
    k(3, 1) = k(1, 3) = 1; // the second and third move together
    k(3, 2) = k(2, 3) = -1;
    const CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(3);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd x = solved(solver, (MatrixXd(4, 1) << 300, 0, 0, 0).finished());
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(x(i), 1, 1e-5); // 300 N on 3 kg; the spring keeps six digits in double precision
    EXPECT_NEAR(x(3), 100, 1e-3);
    EXPECT_EQ(solver.counts().klu_fallbacks, 0);
}

TEST(AugmentedSolver, RepeatedRowsGiveTheLeastNorm) {
    const int n = 30, m = 12;
    MatrixXd k = symmetric_saddle(n, m, 6);
    for (int r = 8; r < m; ++r) { // four rows repeat others
        k.row(n + r) = k.row(n + r - 8);
        k.col(n + r) = k.col(n + r - 8);
    }
    MatrixXd b = samples::random_columns(n + m, 1, 3);
    for (int r = 8; r < m; ++r)
        b(n + r) = b(n + r - 8);
    const CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(n);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    const MatrixXd x = solved(solver, b);
    EXPECT_EQ(solver.counts().klu_fallbacks, 0);
    EXPECT_LT((k * x - b).norm(), 1e-8 * b.norm());
    for (int r = 8; r < m; ++r) // equal rows carry equal shares
        EXPECT_NEAR(x(n + r), x(n + r - 8), 1e-8 * x.norm());
}

TEST(AugmentedSolver, SoftRowsAreSolvedAsTheyAre) {
    const int n = 30, m = 10;
    for (const double soft : {1e-12, 1e-6, 1e-2, 1.0}) {
        SCOPED_TRACE(soft);
        MatrixXd k = symmetric_saddle(n, m, 8);
        for (int r = 0; r < m; ++r)
            k(n + r, n + r) = -soft;
        expect_agreement(k, n, 1e-8, 4);
    }
}

TEST(AugmentedSolver, IndefiniteMatricesGoToKlu) {
    const int n = 20, m = 5;
    MatrixXd k = symmetric_saddle(n, m, 9);
    k(n - 1, n - 1) = -40; // a negative stiffness that no constraint holds
    const CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(n);
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    EXPECT_FALSE(solver.factored_by_cholmod());
    EXPECT_EQ(solver.counts().klu_fallbacks, 1);
    const MatrixXd b = samples::random_columns(n + m, 2, 1);
    EXPECT_LT((solved(solver, b) - k.fullPivLu().solve(b)).norm(), 1e-10);
}

TEST(AugmentedSolver, SlowPassesGoToKluAndComeBack) {
    const int n = 40, m = 10;
    MatrixXd skew = symmetric_saddle(n, m, 10);
    for (int i = 0; i + 1 < n; ++i) { // skew parts of all sizes, up to 1e4 times the symmetric part
        const double size = std::pow(10.0, 4.0 * i / n);
        skew(i, i + 1) += size;
        skew(i + 1, i) -= size;
    }
    const MatrixXd plain = symmetric_saddle(n, m, 10);
    CscMatrix a = samples::sparse(skew);
    AugmentedSolver solver(n);
    solver.analyse(a.pattern);
    const MatrixXd b = samples::random_columns(n + m, 2, 1);
    ASSERT_TRUE(solver.factor(a.values).ok());
    EXPECT_LT(samples::backward_error(skew, solved(solver, b), b), 1e-12);
    EXPECT_EQ(solver.counts().klu_fallbacks, 1);
    for (int j = 0; j < n + m; ++j) // the same pattern without the skew part
        for (int p = a.pattern.col_start[j]; p < a.pattern.col_start[j + 1]; ++p)
            a.values[p] = plain(a.pattern.row[p], j);
    for (int i = 0; i < 4; ++i) {
        ASSERT_TRUE(solver.factor(a.values).ok());
        EXPECT_LT((solved(solver, b) - plain.fullPivLu().solve(b)).norm(), 1e-8);
    }
    EXPECT_TRUE(solver.factored_by_cholmod());
}

TEST(AugmentedSolver, SingularAndBadMatricesAreToldByKind) {
    MatrixXd k = symmetric_saddle(6, 2, 11);
    k.row(2).setZero();
    k.col(2).setZero();
    k(2, 2) = -1e-300; // keeps its place in the pattern
    CscMatrix a = samples::sparse(k);
    AugmentedSolver solver(6);
    solver.analyse(a.pattern);
    a.values.back() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(solver.factor(a.values).kind, FactorStatus::Kind::non_finite);
    std::vector<double> x(8, 1.0);
    EXPECT_THROW(solver.solve(x), std::logic_error);
    EXPECT_THROW(AugmentedSolver(9).analyse(a.pattern), std::invalid_argument);
}

TEST(AugmentedSolver, RefactorsWithoutMemory) {
    if (!GUDGEON_COUNTS_ALLOCATIONS)
        GTEST_SKIP() << "allocations are not counted in this build";
    const int n = 60, m = 20;
    CscMatrix a = samples::sparse(symmetric_saddle(n, m, 12));
    AugmentedSolver solver(n);
    solver.analyse(a.pattern);
    MatrixXd b = samples::random_columns(n + m, 2, 1);
    const auto once = [&] {
        EXPECT_TRUE(solver.factor(a.values).ok());
        solver.solve({b.data(), static_cast<std::size_t>(b.size())}, 2);
        solver.solve({b.data(), static_cast<std::size_t>(n + m)}, 1);
    };
    once();
    for (double& value : a.values)
        value *= 1.001;
    EXPECT_EQ(test::count_allocations(once), 0);
}

/// K(s) = [s M + C + S/s, G^T; G, 0], its parts as from a mechanism.
struct Family {
    MatrixXd m, c, s, g;
    explicit Family(int n, int rows, double stiffness) {
        const MatrixXd k = symmetric_saddle(n, rows, 21);
        m = k.topLeftCorner(n, n);
        g = k.bottomLeftCorner(rows, n);
        s = stiffness * symmetric_saddle(n, 0, 22);
        c = 0.1 * std::sqrt(stiffness) * symmetric_saddle(n, 0, 23);
    }
    template <class Scalar> Eigen::Matrix<Scalar, -1, -1> at(Scalar z) const {
        const Eigen::Index n = m.rows(), r = g.rows();
        Eigen::Matrix<Scalar, -1, -1> k = Eigen::Matrix<Scalar, -1, -1>::Zero(n + r, n + r);
        k.topLeftCorner(n, n) = z * m.cast<Scalar>() + c.cast<Scalar>() + (Scalar(1) / z) * s.cast<Scalar>();
        k.topRightCorner(n, r) = g.transpose().cast<Scalar>();
        k.bottomLeftCorner(r, n) = g.cast<Scalar>();
        return k;
    }
};

TEST(AugmentedPairSolver, ComplexSystemsByTheRealFactor) {
    const int n = 60, rows = 20;
    const double sigma = 3.6378342527444957;
    const Complex s(2.6810828736277521, 3.0504301992474105);
    long before = 0;
    for (const double stiffness : {0.0, 1e-3, 1.0, 10.0, 1e6}) {
        SCOPED_TRACE(stiffness);
        const Family family(n, rows, stiffness);
        const CscMatrix real = samples::sparse(family.at(sigma));
        const MatrixXcd k = family.at(s);
        std::vector<Complex> values;
        for (int j = 0; j < n + rows; ++j)
            for (int p = real.pattern.col_start[j]; p < real.pattern.col_start[j + 1]; ++p)
                values.push_back(k(real.pattern.row[p], j));
        AugmentedSolver solver(n);
        AugmentedPairSolver pair(solver);
        solver.analyse(real.pattern);
        pair.analyse(real.pattern);
        ASSERT_TRUE(solver.factor(real.values).ok());
        ASSERT_TRUE(pair.factor(values, s / sigma).ok());
        const MatrixXcd b = samples::random_columns(n + rows, 2, 1).cast<Complex>() +
                            Complex(0, 1) * samples::random_columns(n + rows, 2, 2).cast<Complex>();
        MatrixXcd x = b;
        pair.solve({x.data(), static_cast<std::size_t>(x.size())}, 2);
        EXPECT_LT((x - k.fullPivLu().solve(b)).norm(), 1e-8 * x.norm());
        EXPECT_EQ(pair.counts().klu_fallbacks, 0);
        EXPECT_GT(pair.counts().cholmod_iterations, before ? 1 : 0);
        EXPECT_LE(pair.counts().cholmod_iterations, stiffness == 0 ? 6 : 50);
        before = pair.counts().cholmod_iterations;
    }
}

} // namespace
} // namespace gudgeon
