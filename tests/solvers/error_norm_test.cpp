// The weighted norm by hand values.
#include "solvers/error_norm.hpp"

#include "models/builders.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gudgeon {
namespace {

using namespace test;

System stones(int n) {
    Model model;
    for (int i = 0; i < n; ++i)
        model.bodies.push_back(make_body("stone" + std::to_string(i), 1, {1, 1, 1}, {3.0 * i, 0, 0}));
    return compiled(model);
}

TEST(ErrorNorm, IsTheRootMeanSquareOfOneBody) {
    const System system = stones(1);
    ErrorNorm norm(system, 1e-3, 1e-4);
    VecX q(7), u(6), q2, u2;
    q << 2, 0, 0, 1, 0, 0, 0;
    u << -5, 0, 0, 0, 0, 9;
    norm.set_scale(q, u);
    q2 = q;
    u2 = u;
    q2[0] += 2.1e-3;     // weight 1 / (1e-3 * 2 + 1e-4): 1
    q2[1] -= 2e-4;       // 2
    u2[0] += 3 * 5.1e-3; // 3
    u2[5] -= 4 * 9.1e-3; // 4
    const double expected = std::sqrt((1.0 + 4 + 9 + 16) / 13);
    EXPECT_NEAR(norm.difference(q, q2, u, u2, 1).norm, expected, 1e-12);
    EXPECT_NEAR(norm.difference(q, q2, u, u2, -0.5).norm, expected / 2, 1e-12);
    EXPECT_NEAR(norm.rates(q2 - q, u2 - u).norm, expected, 1e-12);
}

TEST(ErrorNorm, IncrementCountsTurnsLikeEulerParameters) {
    const System system = stones(1);
    ErrorNorm norm(system, 1e-3, 1e-4);
    const State s = initial_state(system);
    norm.set_scale(s.q, s.u);
    Vec6 step = Vec6::Zero(), du = Vec6::Zero();
    step[4] = 2 * 1.1e-3; // e1..e3 change by half the turn
    EXPECT_NEAR(norm.increment(step.data(), du.data()).norm, std::sqrt(1.0 / 13), 1e-12);
}

TEST(ErrorNorm, WorstBodyCountsHoweverManyThereAre) {
    for (const int n : {2, 50}) {
        const System system = stones(n);
        ErrorNorm norm(system, 0, 1);
        const VecX q = VecX::Zero(system.positions()), u = VecX::Zero(system.velocities());
        norm.set_scale(q, u);
        VecX q2 = q;
        q2[7] = 5;
        q2[0] = 3;
        const ErrorNorm::Value worst = norm.difference(q, q2, u, u, 1);
        EXPECT_EQ(worst.body, 1);
        EXPECT_NEAR(worst.norm, 5 / std::sqrt(13), 1e-14);
    }
}

TEST(ErrorNorm, NanIsSeenWhereverItStands) {
    const System system = stones(3);
    ErrorNorm norm(system, 1e-3, 1e-3);
    for (int body = 0; body < 3; ++body) {
        VecX q = VecX::Ones(system.positions()), u = VecX::Ones(system.velocities());
        VecX bad = u;
        bad[6 * body + 2] = std::numeric_limits<double>::quiet_NaN();
        const ErrorNorm::Value difference = norm.difference(q, q, u, bad, 1), rates = norm.rates(q, bad),
                               increment = norm.increment(u.data(), bad.data());
        for (const ErrorNorm::Value& value : {difference, rates, increment}) {
            EXPECT_TRUE(std::isnan(value.norm)) << "body " << body;
            EXPECT_EQ(value.body, body);
        }
    }
}

} // namespace
} // namespace gudgeon
