// Explicit pairs: conditions of order, and the order seen on an equation with a known solution.
#include "solvers/explicit_pair.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace gudgeon {
namespace {

using Vec = std::vector<double>;

class ExplicitPairs : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, ExplicitPairs, testing::Values(5, 8));

/// y' = cos(t) y, y(0) = 1: y = exp(sin t)
double slope(double t, double y) { return std::cos(t) * y; }
double solution(double t) { return std::exp(std::sin(t)); }

struct Step {
    double end, error;
    Vec k;
};

/// One step with all stages, those of dense output too.
Step step(const ExplicitPair& p, double t, double y, double h) {
    Step out{0, 0, Vec(p.all_stages())};
    for (int j = 0; j < p.all_stages(); ++j) {
        double at = y;
        for (const PairTerm& term : p.a[j])
            at += h * term.weight * out.k[term.stage];
        if (j == p.stages)
            out.end = at;
        out.k[j] = slope(t + p.c[j] * h, at);
    }
    for (const PairTerm& term : p.error[0])
        out.error += h * term.weight * out.k[term.stage];
    return out;
}

double global_error(const ExplicitPair& p, int steps) {
    double y = 1;
    const double h = 2.0 / steps;
    for (int i = 0; i < steps; ++i)
        y = step(p, i * h, y, h).end;
    return std::abs(y - solution(2));
}

TEST_P(ExplicitPairs, RowsSumToTheirNodes) {
    const ExplicitPair& p = explicit_pair(GetParam());
    ASSERT_EQ(std::ssize(p.a), p.all_stages());
    ASSERT_EQ(std::ssize(p.c), p.all_stages());
    for (int j = 0; j < p.all_stages(); ++j) {
        double sum = 0;
        for (const PairTerm& term : p.a[j]) {
            EXPECT_LT(term.stage, j) << "explicit";
            sum += term.weight;
        }
        EXPECT_NEAR(sum, p.c[j], 1e-14) << j;
    }
}

TEST_P(ExplicitPairs, WeightsIntegratePowersOfTheOrder) {
    const ExplicitPair& p = explicit_pair(GetParam());
    for (int power = 0; power < p.order; ++power) {
        double sum = 0;
        for (const PairTerm& term : p.a[p.stages])
            sum += term.weight * std::pow(p.c[term.stage], power);
        EXPECT_NEAR(sum, 1.0 / (power + 1), 2e-15) << power;
    }
    for (const auto& estimate : p.error) { // zero for a constant: both formulas integrate it
        double sum = 0;
        for (const PairTerm& term : estimate)
            sum += term.weight;
        EXPECT_NEAR(sum, 0, 1e-14);
    }
}

TEST_P(ExplicitPairs, ErrorsFallWithTheOrder) {
    const ExplicitPair& p = explicit_pair(GetParam());
    const int few = p.order == 5 ? 16 : 6;
    const double order = std::log2(global_error(p, few) / global_error(p, 2 * few));
    EXPECT_NEAR(order, p.order, 0.6);
}

TEST_P(ExplicitPairs, EstimateFallsWithItsPower) {
    const ExplicitPair& p = explicit_pair(GetParam());
    const auto total = [&](double h) { // over many steps: a single estimate may pass through zero
        double sum = 0;
        for (int i = 0; i < 40; ++i)
            sum += std::abs(step(p, 0.1 * i, 1, h).error);
        return sum;
    };
    // h times the first estimate of order 8, of which the second one makes the square over itself
    const double h = p.order == 5 ? 0.1 : 0.2;
    EXPECT_NEAR(std::log2(total(h) / total(h / 2)), p.order == 5 ? 5 : 6, 0.4);
}

TEST_P(ExplicitPairs, DenseOutputMeetsBothEndsAndKeepsItsOrder) {
    const ExplicitPair& p = explicit_pair(GetParam());
    Vec w(p.all_stages());
    const auto inside = [&](double h, double x) {
        const Step s = step(p, 0, 1, h);
        p.dense_weights(x, w);
        double y = 1;
        for (int j = 0; j < p.all_stages(); ++j)
            y += h * w[j] * s.k[j];
        return y;
    };
    EXPECT_EQ(inside(0.4, 0), 1);
    EXPECT_NEAR(inside(0.4, 1), step(p, 0, 1, 0.4).end, 1e-13); // weights of some hundred cancel
    for (const double x : {0.2, 0.5, 0.77}) {
        const double h = p.order == 5 ? 0.2 : 0.4;
        const double large = std::abs(inside(h, x) - solution(x * h));
        const double small = std::abs(inside(h / 2, x) - solution(x * h / 2));
        EXPECT_GT(std::log2(large / small), p.order == 5 ? 4.5 : 7.3) << x; // one more than the order inside
        EXPECT_LT(large, p.order == 5 ? 1e-6 : 1e-8) << x;
    }
}

TEST(ExplicitPair, OtherOrdersAreRefused) { EXPECT_THROW((void)explicit_pair(6), std::invalid_argument); }

} // namespace
} // namespace gudgeon
