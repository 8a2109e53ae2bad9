// How soon Gear's method is back at its step after a contact begins. Counted are the accepted steps after the
// one in which it begins, until one is at least half as long as the longest of the next hundred, or of those
// before the next start or end of a contact. So the step is held against what the same method reaches in the
// same contact: flights before it may be far longer, and no method should step so inside.
#include "models/mechanisms.hpp"
#include "solvers/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {
namespace {

constexpr std::size_t most_looked_at = 100;
constexpr double back = 0.5;

struct Log {
    std::vector<StepRecord> steps;              // accepted
    std::vector<double> starts, starts_or_ends; // s, ascending, each once
};

Log log_of(const std::string& mechanism, const std::map<std::string, std::string>& parameters, double end,
           double tolerance) {
    Log log;
    SimulationOptions options;
    options.integrator = "gear";
    options.integration.rtol = options.integration.atol = tolerance;
    options.on_contact = [&log](const ContactEvent& event) {
        if (event.kind == ContactEvent::Kind::start)
            log.starts.push_back(event.t);
        if (event.kind == ContactEvent::Kind::start || event.kind == ContactEvent::Kind::end)
            log.starts_or_ends.push_back(event.t);
    };
    Simulation sim(build_mechanism(mechanism, parameters), options);
    sim.integrator().on_step = [&log](const StepRecord& step) {
        if (step.reason == StepReason::none)
            log.steps.push_back(step);
    };
    const StepOutcome outcome = sim.advance_to(end);
    EXPECT_TRUE(outcome.ok) << outcome.message;
    for (std::vector<double>* times : {&log.starts, &log.starts_or_ends}) {
        std::ranges::sort(*times);
        times->erase(std::ranges::unique(*times).begin(), times->end());
    }
    return log;
}

/// Of each start that a whole step follows before the next event.
std::vector<double> steps_until_back(const Log& log) {
    std::vector<double> counts;
    for (const double start : log.starts) {
        const auto begin = std::ranges::lower_bound(log.steps, start, {}, &StepRecord::t) + 1;
        const auto next = std::ranges::upper_bound(log.starts_or_ends, start + 1e-12);
        const double until = next == log.starts_or_ends.end() ? INFINITY : *next;
        double longest = 0;
        auto end = begin;
        for (; end < log.steps.end() && end < begin + most_looked_at && end->t <= until; ++end)
            longest = std::max(longest, end->h);
        const auto found =
            std::find_if(begin, end, [&](const StepRecord& step) { return step.h >= back * longest; });
        if (found != end)
            counts.push_back(static_cast<double>(found - begin) + 1);
    }
    return counts;
}

double median(std::vector<double> values) {
    std::ranges::sort(values);
    const std::size_t n = values.size();
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

struct Case {
    std::string name, mechanism;
    std::map<std::string, std::string> parameters;
    double end;     // s
    double allowed; // median over all tolerances
};

class Recovery : public testing::TestWithParam<Case> {};

TEST_P(Recovery, TakesFewSteps) {
    const Case& c = GetParam();
    std::vector<double> all;
    for (const double tolerance : {1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7}) {
        const std::vector<double> counts =
            steps_until_back(log_of(c.mechanism, c.parameters, c.end, tolerance));
        all.insert(all.end(), counts.begin(), counts.end());
    }
    ASSERT_GE(all.size(), 7u);
    EXPECT_LE(median(all), c.allowed);
    RecordProperty("median", std::to_string(median(all)));
}

// Where a bearing touches strip after strip, one more is a small kink in the force: the step is hardly lost.
INSTANTIATE_TEST_SUITE_P(
    Gear, Recovery,
    testing::Values(Case{"BallInSocket", "slider-crank", {{"joint", "spherical"}}, 1, 30},
                    Case{"Stops", "triple-pendulum", {}, 4, 30},
                    Case{"Bouncing", "bouncing-journal", {}, 1, 30},
                    Case{"BouncingOnSteel", "bouncing-journal", {{"law", "cylinder"}}, 1, 30},
                    Case{"Tilted", "tilted-journal", {}, 0.2, 3},
                    Case{"TiltedElastic", "tilted-journal", {{"restitution", "1"}}, 0.2, 3},
                    Case{"WornCrankBearing", "slider-crank", {{"joint", "revolute"}}, 0.5, 8}),
    [](const auto& info) { return info.param.name; });

} // namespace
} // namespace gudgeon
