#include "core/time_function.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gudgeon {
namespace {

constexpr double pi = 3.14159265358979323846;

void expect_derivatives(const TimeFunction& f, double t) {
    const double h = 1e-5;
    const TimeValue before = evaluate(f, t - h), now = evaluate(f, t), after = evaluate(f, t + h);
    EXPECT_NEAR(now.rate, (after.value - before.value) / (2 * h), 1e-6 * (1 + std::abs(now.rate))) << t;
    EXPECT_NEAR(now.acceleration, (after.rate - before.rate) / (2 * h),
                1e-6 * (1 + std::abs(now.acceleration)))
        << t;
}

TEST(TimeFunction, Constant) {
    const TimeValue v = evaluate(ConstantFunction{3.5}, 7);
    EXPECT_EQ(v.value, 3.5);
    EXPECT_EQ(v.rate, 0);
    EXPECT_EQ(v.acceleration, 0);
    EXPECT_EQ(evaluate(TimeFunction{}, 1).value, 1); // a function not given otherwise is the factor 1
}

TEST(TimeFunction, Harmonic) {
    const HarmonicFunction f{3, 0.5, pi / 6, 10};
    const TimeValue v = evaluate(f, 0); // sin 30 deg = 1/2
    EXPECT_NEAR(v.value, 11.5, 1e-14);
    EXPECT_NEAR(v.rate, 3 * pi * std::sqrt(3) / 2, 1e-14);
    EXPECT_NEAR(v.acceleration, -1.5 * pi * pi, 1e-13);
    for (const double t : {-1.0, 0.3, 2.0})
        expect_derivatives(f, t);
}

TEST(TimeFunction, SmoothStep) {
    const SmoothStepFunction f{1, 3, 5, 9};
    for (const double t : {-1.0, 1.0}) {
        EXPECT_EQ(evaluate(f, t).value, 5);
        EXPECT_EQ(evaluate(f, t).rate, 0);
        EXPECT_EQ(evaluate(f, t).acceleration, 0);
    }
    EXPECT_EQ(evaluate(f, 3).value, 9);
    EXPECT_EQ(evaluate(f, 30).rate, 0);
    const TimeValue middle = evaluate(f, 2); // half way; 30/16 of the mean rate; inflection
    EXPECT_DOUBLE_EQ(middle.value, 7);
    EXPECT_DOUBLE_EQ(middle.rate, 30.0 / 16 * 2);
    EXPECT_NEAR(middle.acceleration, 0, 1e-14);
    const TimeValue quarter = evaluate(f, 1.5); // s = 1/4: 10/64 - 15/256 + 6/1024 = 106/1024
    EXPECT_DOUBLE_EQ(quarter.value, 5 + 4 * 106.0 / 1024);
    EXPECT_DOUBLE_EQ(quarter.acceleration, 60 * 0.25 * 0.75 * 0.5);
    for (const double t : {1.1, 1.9, 2.7})
        expect_derivatives(f, t);
    // C2 at both ends.
    EXPECT_NEAR(evaluate(f, 1 + 1e-7).acceleration, 0, 1e-5);
    EXPECT_NEAR(evaluate(f, 3 - 1e-7).acceleration, 0, 1e-5);
}

TEST(TimeFunction, Ramp) {
    const RampFunction f{2, -3, 1};
    EXPECT_EQ(evaluate(f, 0).value, 2);
    EXPECT_EQ(evaluate(f, 0).rate, 0);
    EXPECT_EQ(evaluate(f, 1).rate, -3); // the drive moves from its start on
    EXPECT_EQ(evaluate(f, 3).value, -4);
    EXPECT_EQ(evaluate(f, 3).acceleration, 0);
}

TEST(TimeFunction, TableIsConstantBeyondItsEnds) {
    const TableFunction f(Table{{0, 1, 2, 4}, {0, 2, 3, 1}});
    EXPECT_EQ(evaluate(f, -1).value, 0);
    EXPECT_EQ(evaluate(f, 9).value, 1);
    EXPECT_EQ(evaluate(f, 9).rate, 0);
    EXPECT_EQ(evaluate(f, 2).value, 3);
    EXPECT_EQ(evaluate(f, 2).rate, 0); // the largest value is at its point
    for (const double t : {-0.5, 0.4, 1.3, 3.1, 5.0})
        expect_derivatives(f, t);
}

TEST(TimeFunction, TableThatIsNoCurveIsKeptForTheRefusal) {
    const TableFunction f(Table{{1, 0}, {0, 1}});
    EXPECT_EQ(f.table().x.size(), 2u);
    EXPECT_TRUE(f.spline().empty());
}

} // namespace
} // namespace gudgeon
