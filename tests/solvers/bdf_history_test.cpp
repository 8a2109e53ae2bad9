// Weights of multistep polynomials on variable grids, and the ring of past points.
#include "solvers/bdf_history.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace gudgeon {
namespace {

// Newest first, steps between 0.03 and 0.3, as a step control leaves them.
const std::vector<double> grid{1.7, 1.58, 1.55, 1.3, 1.21, 0.91, 0.8, 0.62};

double power(double t, int n) { return std::pow(t - 1.2, n); }
double power_rate(double t, int n) { return n == 0 ? 0 : n * std::pow(t - 1.2, n - 1); }
double power_integral(double t, int n) { return std::pow(t - 1.2, n + 1) / (n + 1); }

template <class F> double weighted(const double* w, std::size_t n, F f) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
        sum += w[i] * f(grid[i]);
    return sum;
}

TEST(BdfHistory, InterpolationIsExactForPolynomials) {
    for (std::size_t n = 1; n <= 7; ++n)
        for (const double t : {1.85, 1.7, 1.44, 0.95}) {
            std::array<double, 8> w{};
            interpolation_weights(std::span(grid).first(n), t, w.data());
            for (int degree = 0; degree < static_cast<int>(n); ++degree)
                EXPECT_NEAR(weighted(w.data(), n, [&](double x) { return power(x, degree); }),
                            power(t, degree), 1e-12)
                    << n << " points, degree " << degree << ", t = " << t;
        }
}

TEST(BdfHistory, InterpolationMissesTheNextPower) {
    std::array<double, 8> w{};
    interpolation_weights(std::span(grid).first(3), 1.85, w.data());
    // the error of the cubic is the product of the distances to the points
    EXPECT_NEAR(power(1.85, 3) - weighted(w.data(), 3, [](double x) { return power(x, 3); }),
                (1.85 - 1.7) * (1.85 - 1.58) * (1.85 - 1.55), 1e-14);
}

TEST(BdfHistory, DifferentiationIsExactForPolynomials) {
    const double t = 1.82;
    for (std::size_t k = 1; k <= 6; ++k) {
        std::array<double, 8> a{};
        const double a0 = bdf_weights(std::span(grid).first(k), t, a.data());
        for (int degree = 0; degree <= static_cast<int>(k); ++degree)
            EXPECT_NEAR(a0 * power(t, degree) +
                            weighted(a.data(), k, [&](double x) { return power(x, degree); }),
                        power_rate(t, degree), 1e-10)
                << "order " << k << ", degree " << degree;
    }
}

TEST(BdfHistory, DifferentiationOnAnEvenGridHasTheTextbookWeights) {
    const double h = 0.01;
    const std::vector<double> past{0, -h, -2 * h, -3 * h, -4 * h};
    const std::vector<std::vector<double>> textbook{{1, -1},
                                                    {3.0 / 2, -2, 1.0 / 2},
                                                    {11.0 / 6, -3, 3.0 / 2, -1.0 / 3},
                                                    {25.0 / 12, -4, 3, -4.0 / 3, 1.0 / 4},
                                                    {137.0 / 60, -5, 5, -10.0 / 3, 5.0 / 4, -1.0 / 5}};
    for (std::size_t k = 1; k <= 5; ++k) {
        std::array<double, 8> a{};
        EXPECT_NEAR(h * bdf_weights(std::span(past).first(k), h, a.data()), textbook[k - 1][0], 1e-12);
        for (std::size_t i = 0; i < k; ++i)
            EXPECT_NEAR(h * a[i], textbook[k - 1][i + 1], 1e-12) << "order " << k;
    }
}

TEST(BdfHistory, IntegrationIsExactForPolynomials) {
    for (std::size_t n = 1; n <= 8; ++n)
        for (const auto& [from, to] : {std::pair(1.58, 1.7), {1.64, 1.7}, {1.7, 1.58}, {0.7, 1.6}}) {
            std::array<double, 8> w{};
            integration_weights(std::span(grid).first(n), from, to, w.data());
            for (int degree = 0; degree < static_cast<int>(n); ++degree)
                EXPECT_NEAR(weighted(w.data(), n, [&](double x) { return power(x, degree); }),
                            power_integral(to, degree) - power_integral(from, degree), 1e-11)
                    << n << " points, degree " << degree;
        }
}

// Point k holds q = k, u = -k, lambda = 10 k at t = k^2.
void push_points(BdfHistory& history, int from, int to) {
    for (int k = from; k <= to; ++k) {
        history.next_q().setConstant(k);
        history.next_u().setConstant(-k);
        history.next_lambda().setConstant(10 * k);
        history.push(k * k);
    }
}

TEST(BdfHistory, RingKeepsTheNewestPoints) {
    BdfHistory history;
    history.reserve(7, 6, 2);
    EXPECT_EQ(history.points(), 0);
    push_points(history, 1, 3);
    EXPECT_EQ(history.points(), 3);
    push_points(history, 4, 21); // several times round
    ASSERT_EQ(history.points(), BdfHistory::capacity - 1);
    history.next_q().setConstant(99); // the point being computed is none of them
    history.next_u().setConstant(99);
    const std::span<const double> times = history.times(history.points());
    for (int i = 0; i < history.points(); ++i) {
        EXPECT_EQ(history.time(i), (21 - i) * (21 - i));
        EXPECT_EQ(times[i], history.time(i));
        EXPECT_EQ(history.q(i), VecX::Constant(7, 21 - i));
        EXPECT_EQ(history.u(i), VecX::Constant(6, i - 21));
    }
    history.clear();
    EXPECT_EQ(history.points(), 0);
    push_points(history, 5, 5);
    EXPECT_EQ(history.points(), 1);
    EXPECT_EQ(history.time(0), 25);
}

TEST(BdfHistory, CombinesAnyNumberOfPoints) {
    BdfHistory history;
    history.reserve(7, 6, 2);
    push_points(history, 1, 9);
    const std::array<double, 7> w{0.5, -2, 3, 0.25, -1, 4, 7};
    VecX q(7), u(6), lambda(2);
    double sum = 0;
    for (int n = 1; n <= 7; ++n) {
        sum += w[n - 1] * (10 - n); // newest first: 9, 8, ...
        history.combine(n, w.data(), q, u);
        history.combine_lambda(n, w.data(), lambda);
        EXPECT_EQ(q, VecX::Constant(7, sum));
        EXPECT_EQ(u, VecX::Constant(6, -sum));
        EXPECT_EQ(lambda, VecX::Constant(2, 10 * sum));
    }
}

} // namespace
} // namespace gudgeon
