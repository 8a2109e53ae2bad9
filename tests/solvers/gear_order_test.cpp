// Order of Gear's method, seen in the errors of positions and velocities against exact motions.
#include "solvers/simulation.hpp"
#include "tests/solvers/exact_motions.hpp"
#include "tests/solvers/reference_table.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;
using testing_data::ReferenceTable;

struct Measured {
    double steps = 0, at_order = 0; // accepted, and how many at the highest order
    double position = 0, velocity = 0;
};

SimulationOptions tolerance(double tol, int order, Formulation formulation) {
    SimulationOptions options;
    options.integration.formulation = formulation;
    options.integration.rtol = options.integration.atol = tol;
    options.integration.max_order = order;
    return options;
}

Measured counted(const Simulation& sim, int order) {
    const Statistics& s = sim.statistics();
    return {static_cast<double>(s.steps), static_cast<double>(s.order_histogram[order]), 0, 0};
}

Measured pendulum_run(double tol, int order, Formulation formulation) {
    Simulation sim(build_mechanism("pendulum"), tolerance(tol, order, formulation));
    double position = 0, velocity = 0;
    Integrator& gear = sim.integrator();
    while (gear.state().t < 1.5) { // the largest error over all steps
        EXPECT_TRUE(gear.advance(1.5).ok);
        const PendulumTruth truth(gear.state().t);
        position = std::max(position, (gear.state().q.head<3>() - truth.r).norm());
        velocity = std::max(velocity, (gear.state().u.head<3>() - truth.v).norm());
    }
    Measured run = counted(sim, order);
    run.position = position;
    run.velocity = velocity;
    return run;
}

Measured top_run(double tol, int order, Formulation formulation) {
    static const ReferenceTable exact("r7_slow_top_b.csv");
    Simulation sim(build_mechanism("heavy-top"), tolerance(tol, order, formulation));
    double position = 0, velocity = 0;
    for (std::size_t i = 10; i <= 60; i += 5) { // between two cusps, where the tilt's rate is well defined
        if (i >= 35 && i <= 45)
            continue; // it turns round there
        EXPECT_TRUE(sim.advance_to(exact["t"][i]).ok);
        const State s = sim.state();
        const Vec3 r(exact["cx"][i], exact["cy"][i], exact["cz"][i]);
        const Vec4 p(exact["e0"][i], exact["e1"][i], exact["e2"][i], exact["e3"][i]);
        position = std::max({position, (s.q.head<3>() - r).norm(), (s.q.segment<4>(3) - p).norm()});
        const bool falling = exact["theta"][i + 1] > exact["theta"][i - 1];
        const Vec3 v = top_velocity(exact["azimuth"][i], exact["theta"][i], falling);
        velocity = std::max(velocity, (s.u.head<3>() - v).norm());
    }
    Measured run = counted(sim, order);
    run.position = position;
    run.velocity = velocity;
    return run;
}

/// Slope of log error over log steps, by least squares.
double slope(const std::vector<Measured>& runs, double Measured::*error) {
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const Measured& run : runs) {
        const double a = std::log(run.steps), b = std::log(run.*error);
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    const auto n = static_cast<double>(runs.size());
    return (n * xy - x * y) / (n * xx - x * x);
}

// The error per step is held, so steps grow as tol^(-1/(k+1)) and errors fall as tol^(k/(k+1)).
class GearOrder : public testing::TestWithParam<std::tuple<int, Formulation>> {
  protected:
    void expect_order(Measured (*once)(double, int, Formulation), double tightest) {
        const auto [k, formulation] = GetParam();
        std::vector<Measured> runs;
        for (double tol = 1e-5; tol > 0.9 * tightest; tol /= std::sqrt(10))
            runs.push_back(once(tol, k, formulation));
        EXPECT_NEAR(slope(runs, &Measured::position), -k, 0.2 + 0.06 * k);
        EXPECT_NEAR(slope(runs, &Measured::velocity), -k, 0.2 + 0.06 * k);
        // it is this order that was seen
        EXPECT_GT(runs.back().at_order, 0.8 * runs.back().steps);
        for (const Measured& run : runs)
            EXPECT_GT(run.at_order, 0.5 * run.steps);
    }
    /// Orders 1 and 2 need very many steps for little.
    double tightest() const {
        const int k = std::get<0>(GetParam());
        return k == 1 ? 1e-6 : k == 2 ? 1e-8 : 1e-9;
    }
};

TEST_P(GearOrder, Pendulum) { expect_order(pendulum_run, tightest()); }
TEST_P(GearOrder, HeavyTop) { expect_order(top_run, tightest()); }

INSTANTIATE_TEST_SUITE_P(Slow, GearOrder,
                         testing::Combine(testing::Range(1, 6),
                                          testing::Values(Formulation::saddle_point, Formulation::tree)));

TEST(Elliptic, FunctionsAgreeWithTheirDefinition) {
    for (const double k : {0.0, 0.3, 0.7, 0.95})
        for (const double phi : {0.0, 0.4, 1.2, 2.5}) {
            const Jacobi j = jacobi(std::ellint_1(k, phi), k);
            EXPECT_NEAR(j.sn, std::sin(phi), 1e-13);
            EXPECT_NEAR(j.cn, std::cos(phi), 1e-13);
        }
    // simple pendulum from rest, to ten digits
    EXPECT_LT((PendulumTruth(1).r - Vec3(0.9862917511, 0, -0.1650108531)).norm(), 1e-10);
    EXPECT_LT((PendulumTruth(10).r - Vec3(-0.2750874626, 0, -0.9614192051)).norm(), 1e-10);
}

} // namespace
} // namespace gudgeon
