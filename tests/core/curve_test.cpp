#include "core/curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

// The progressive spring of a wheel suspension (force against shortening), odd for lengthening.
Table progressive() {
    return {{-0.06, -0.04, -0.02, 0, 0.02, 0.04, 0.06, 0.08, 0.1},
            {-17818.165, -8991.945, -3629.923, 0, 3629.923, 8991.945, 17818.165, 31840.681, 52791.592}};
}

double simpson(const Spline& f, double a, double b, int n) {
    const double h = (b - a) / n;
    double sum = f(a).value + f(b).value;
    for (int i = 1; i < n; ++i)
        sum += (i % 2 ? 4 : 2) * f(a + i * h).value;
    return sum * h / 3;
}

TEST(Spline, TwoPointsAreALine) {
    const Spline f({{1, 3}, {2, 6}}, Spline::Ends::linear); // y = 2 x
    for (const double x : {-5.0, 0.0, 1.0, 2.2, 3.0, 10.0}) {
        EXPECT_NEAR(f(x).value, 2 * x, 1e-14);
        EXPECT_DOUBLE_EQ(f(x).slope, 2);
        EXPECT_NEAR(f(x).integral, x * x, 1e-13);
        EXPECT_EQ(f.curvature(x), 0);
    }
}

TEST(Spline, HandValues) {
    // Secants 1 and 3; three-point slopes 0, 2, 4 make the parabola x^2 and lie inside the circle.
    const Spline f({{0, 1, 2}, {0, 1, 4}}, Spline::Ends::linear);
    for (const double x : {0.0, 0.25, 0.5, 1.0, 1.7, 2.0}) {
        EXPECT_NEAR(f(x).value, x * x, 1e-15 + 1e-15 * x);
        EXPECT_NEAR(f(x).slope, 2 * x, 1e-14);
        EXPECT_NEAR(f(x).integral, x * x * x / 3, 1e-14);
        EXPECT_NEAR(f.curvature(x), x < 2 ? 2 : 0, 1e-13);
    }
    EXPECT_NEAR(f(3).value, 8, 1e-14); // continues with slope 4
    EXPECT_NEAR(f(3).slope, 4, 1e-14);
    EXPECT_NEAR(f(3).integral, 8.0 / 3 + 6, 1e-14);
    EXPECT_NEAR(f(-2).value, 0, 1e-15); // and with slope 0 on the left
}

TEST(Spline, SlopesAreLimitedToTheCircle) {
    // Secants 1 and 10: three-point slopes -3.5 (wrong sign, so 0), 5.5, 14.5. First interval:
    // (alpha, beta) = (0, 5.5), scaled to 3. Second: (0.3, 1.45), inside.
    const Spline f({{0, 1, 2}, {0, 1, 11}}, Spline::Ends::linear);
    EXPECT_NEAR(f(0).slope, 0, 1e-15);
    EXPECT_NEAR(f(1).slope, 3, 1e-14);
    EXPECT_NEAR(f(2).slope, 14.5, 1e-13);
    EXPECT_NEAR(f(0.5).value, 0.5 * (0 + 1) + (0 - 3.0) / 8, 1e-15);
}

TEST(Spline, ExtremesStayAtThePoints) {
    const Spline f({{0, 1, 2, 3, 5}, {0, 3, 3, -1, -1}}, Spline::Ends::linear);
    for (double x = 0; x <= 5; x += 0.01) {
        EXPECT_LE(f(x).value, 3 + 1e-14);
        EXPECT_GE(f(x).value, -1 - 1e-14);
    }
    EXPECT_EQ(f(1.5).value, 3);
    EXPECT_EQ(f(4).value, -1);
}

TEST(Spline, IsMonotoneWhereThePointsAre) {
    const Spline f({{0, 1, 1.1, 4, 4.01, 9}, {0, 0.1, 7, 7.1, 30, 30.5}}, Spline::Ends::linear);
    for (double x = -1; x <= 10; x += 0.001)
        ASSERT_GE(f(x).slope, -1e-12) << x;
}

TEST(Spline, PassesThroughThePointsAndIsSmooth) {
    const Table table = progressive();
    const Spline f(table, Spline::Ends::linear);
    for (std::size_t i = 0; i < table.x.size(); ++i) {
        EXPECT_NEAR(f(table.x[i]).value, table.y[i], 1e-9);
        EXPECT_NEAR(f(table.x[i] - 1e-12).slope, f(table.x[i] + 1e-12).slope, 1e-2);
    }
}

TEST(Spline, DerivativesAgreeWithDifferences) {
    const Spline f(progressive(), Spline::Ends::linear);
    const double h = 1e-6;                           // slopes are about 1e5 to 1e6, curvatures 1e7 to 1e8
    for (double x = -0.0795; x < 0.13; x += 0.003) { // never within h of a point
        EXPECT_NEAR(f(x).slope, (f(x + h).value - f(x - h).value) / (2 * h), 1) << x;
        EXPECT_NEAR(f.curvature(x), (f(x + h).slope - f(x - h).slope) / (2 * h), 100) << x;
        EXPECT_NEAR(f(x).value, (f(x + h).integral - f(x - h).integral) / (2 * h), 1e-3) << x;
    }
}

TEST(Spline, IntegralFromZeroAgreesWithQuadrature) {
    const Spline f(progressive(), Spline::Ends::linear);
    EXPECT_EQ(f(0).integral, 0);
    // Simpson's rule is exact for a cubic as long as the points are on its nodes.
    EXPECT_NEAR(f(0.1).integral, simpson(f, 0, 0.1, 20), 1e-9);
    EXPECT_NEAR(f(-0.06).integral, simpson(f, 0, -0.06, 12), 1e-9);
    EXPECT_GT(f(-0.06).integral, 0); // stored energy
    EXPECT_NEAR(f(0.15).integral, simpson(f, 0, 0.1, 20) + simpson(f, 0.1, 0.15, 2), 1e-9);
}

TEST(Spline, IntegralFromZeroOutsideTheTable) {
    const Spline right({{2, 3}, {4, 6}}, Spline::Ends::linear); // y = 2 x continues down to 0
    EXPECT_NEAR(right(3).integral, 9, 1e-14);
    const Spline left({{-3, -2}, {5, 5}}, Spline::Ends::linear);
    EXPECT_NEAR(left(-4).integral, -20, 1e-14);
    EXPECT_NEAR(left(1).integral, 5, 1e-14);
}

TEST(Spline, ConstantEnds) {
    const Spline f({{1, 2}, {3, 7}}, Spline::Ends::constant);
    EXPECT_EQ(f(0).value, 3);
    EXPECT_EQ(f(9).value, 7);
    EXPECT_EQ(f(9).slope, 0);
    EXPECT_EQ(f(1).slope, 0); // reached with zero slope: no jump
    EXPECT_NEAR(f(2 - 1e-9).slope, 0, 1e-6);
    EXPECT_DOUBLE_EQ(f(1.5).value, 5); // 3 + 4 (3 s^2 - 2 s^3)
    EXPECT_DOUBLE_EQ(f(1.25).value, 3 + 4 * (3 * 0.0625 - 2 * 0.015625));
    EXPECT_DOUBLE_EQ(f(3).integral, 3 + 5 + 7);
}

TEST(Spline, WhatIsNoCurve) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto where = [](const Table& table) { return find_problem(table).value_or(TableProblem{}).where; };
    EXPECT_EQ(where({{0}, {0}}), "/x");
    EXPECT_EQ(where({{0, 1}, {0}}), "/y");
    EXPECT_EQ(where({{0, 1, 1}, {0, 1, 2}}), "/x/2");
    EXPECT_EQ(where({{0, nan}, {0, 1}}), "/x/1");
    EXPECT_EQ(where({{0, 1}, {nan, 1}}), "/y/0");
    EXPECT_FALSE(find_problem({{0, 1}, {5, 5}}));
    EXPECT_THROW(Spline({{1, 0}, {0, 1}}, Spline::Ends::linear), std::invalid_argument);
    EXPECT_EQ(Spline()(3).value, 0);
}

} // namespace
} // namespace gudgeon
