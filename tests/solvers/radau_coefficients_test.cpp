// Coefficients of Radau IIA against the conditions that define them.
#include "solvers/radau_coefficients.hpp"

#include <Eigen/LU>

#include <gtest/gtest.h>

#include <cmath>

namespace gudgeon {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const RadauCoefficients& k = radau_coefficients();

Vector3d nodes_to(int power) {
    return {std::pow(k.c[0], power), std::pow(k.c[1], power), std::pow(k.c[2], power)};
}

// B(5): the last row integrates polynomials to degree 4, C(3): every row to degree 2.
TEST(RadauCoefficients, QuadratureConditions) {
    for (int power = 1; power <= 5; ++power)
        EXPECT_NEAR(k.A.row(2).dot(nodes_to(power - 1)), 1.0 / power, 1e-14) << power;
    EXPECT_GT(std::abs(k.A.row(2).dot(nodes_to(5)) - 1.0 / 6), 1e-4); // not of order 6
    for (int power = 1; power <= 3; ++power)
        EXPECT_LT((k.A * nodes_to(power - 1) - nodes_to(power) / power).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_EQ(k.c[2], 1); // stiffly accurate: the last stage is the step
}

TEST(RadauCoefficients, NodesAreRootsOfTheRadauPolynomial) {
    for (const double c : k.c) // d^2/dx^2 x^2 (x - 1)^3
        EXPECT_NEAR(20 * c * c * c - 36 * c * c + 18 * c - 2, 0, 1e-14);
}

TEST(RadauCoefficients, EigenvaluesSplitTheInverse) {
    EXPECT_LT((k.A * k.A_inverse - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
    const double re = k.eigenvalue.real(), im = k.eigenvalue.imag();
    Matrix3d lambda;
    lambda << k.real_eigenvalue, 0, 0, 0, re, -im, 0, im, re;
    EXPECT_LT((k.T * lambda * k.T_inverse - k.A_inverse).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LT((k.T * k.T_inverse - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
    // roots of s^3 - 9 s^2 + 36 s - 60, to 15 digits
    EXPECT_NEAR(k.real_eigenvalue, 3.637834252744496, 1e-13);
    EXPECT_NEAR(re, 2.681082873627752, 1e-13);
    EXPECT_NEAR(im, 3.050430199247411, 1e-13);
}

/// y1 / y0 of y' = lambda y with z = h lambda: the last stage.
std::complex<double> stability(std::complex<double> z) {
    const Eigen::Matrix3cd system = Eigen::Matrix3cd::Identity() - z * k.A.cast<std::complex<double>>();
    const Eigen::Vector3cd stage = system.inverse() * Eigen::Vector3cd::Ones();
    return stage[2];
}

TEST(RadauCoefficients, StabilityFunctionIsTheSubdiagonalPade) {
    for (const std::complex<double> z : {std::complex<double>(-0.3, 0), {0.1, 0.4}, {-3, 5}, {0, 20}}) {
        const std::complex<double> pade = (1.0 + 2.0 * z / 5.0 + z * z / 20.0) /
                                          (1.0 - 3.0 * z / 5.0 + 3.0 * z * z / 20.0 - z * z * z / 60.0);
        EXPECT_LT(std::abs(stability(z) - pade), 1e-13) << z;
    }
    for (const double y : {0.1, 1.0, 3.0, 10.0, 100.0, 1e4}) // A-stable
        EXPECT_LE(std::abs(stability({0, y})), 1 + 1e-14) << y;
    // R(infinity) = 1 - b^T A^-1 1
    EXPECT_LT(std::abs(1 - k.A.row(2) * k.A_inverse * Vector3d::Ones()), 1e-14);
    EXPECT_LT(std::abs(stability({-1e8, 0})), 1e-7);
    EXPECT_LT(std::abs(stability({0, 1e8})), 1e-7);
}

// err = (gamma/h - J)^-1 (f(y0) + sum e_i Z_i / h) (Hairer & Wanner 1996, IV.8.19) is the difference from
// a formula of order 3, hence of order h^4; the second pass takes f(y0 + err) and is bounded at infinity.
TEST(RadauCoefficients, ErrorEstimateIsOfOrderFour) {
    const auto estimate = [](double z, bool again) { // y' = lambda y, y0 = 1, h = 1, lambda = z
        const Matrix3d system = Matrix3d::Identity() - z * k.A;
        const Vector3d increments = system.inverse() * Vector3d::Ones() - Vector3d::Ones();
        const Vector3d weights(k.error_weights[0], k.error_weights[1], k.error_weights[2]);
        const double first = (z + weights.dot(increments)) / (k.real_eigenvalue - z);
        return again ? (z * (1 + first) + weights.dot(increments)) / (k.real_eigenvalue - z) : first;
    };
    for (const bool again : {false, true}) {
        const double coarse = estimate(-0.02, again), fine = estimate(-0.01, again);
        EXPECT_NEAR(std::log2(coarse / fine), 4, 0.1) << again;
        EXPECT_GT(std::abs(fine), 1e-12);
    }
    EXPECT_NEAR(std::abs(estimate(-1e8, false)), 1, 1e-6);
    EXPECT_LT(std::abs(estimate(-1e8, true)), 1e-6);
}

// For u' with known values at the stages: conditions on the weights alone.
TEST(RadauCoefficients, EmbeddedFormulaMeetsTheConditionsOfOrderThree) {
    // sum b^_i f_i + gamma^ f_0 with gamma^ = 1 / real eigenvalue, where h f = A^-1 Z at the stages;
    // b - b^ scaled by the eigenvalue acts on f as the weights on Z / h
    const Eigen::RowVector3d weights(k.error_weights[0], k.error_weights[1], k.error_weights[2]);
    const Eigen::RowVector3d on_slopes = weights * k.A;
    EXPECT_NEAR(on_slopes.sum() + 1, 0, 1e-13); // with f_0
    EXPECT_NEAR(on_slopes.dot(nodes_to(1)), 0, 1e-13);
    EXPECT_NEAR(on_slopes.dot(nodes_to(2)), 0, 1e-13);
    EXPECT_GT(std::abs(on_slopes.dot(nodes_to(3))), 1e-3);
}

} // namespace
} // namespace gudgeon
