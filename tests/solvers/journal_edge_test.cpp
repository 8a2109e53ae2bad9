// A journal that leaves its bearing and meets it again: sliding in and out makes no energy.
#include "core/reader.hpp"
#include "solvers/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace gudgeon {
namespace {

// On a spring along the axis, with some drift and tilt, so that it comes back askew against the wall.
const char* const leaving = R"({
  "gudgeon": 1, "name": "leaving", "gravity": [0, 0, 0],
  "bodies": [{"name": "j", "mass": 1, "inertia": [2e-4, 4e-3, 4e-3], "velocity": [2, 0.02, 0.01],
              "angular_velocity": [0, 0.05, 0.1]}],
  "joints": [{"name": "B", "kind": "cylindrical", "bodies": ["ground", "j"], "point": [0, 0, 0],
              "axis": [1, 0, 0], "fidelity": "clearance",
              "clearance": {"radial": 1e-4, "radius": 0.01, "length": 0.04, "journal_length": 0.04, "strips": 8,
                            "law": {"kind": "lankarani-nikravesh", "stiffness": 1e9, "restitution": 0.75}}}],
  "forces": [{"name": "s", "kind": "spring-damper", "bodies": ["ground", "j"], "frame": "body",
              "points": [[-1, 0, 0], [0, 0, 0]], "stiffness": 900, "free_length": 1}]
})";

class JournalEdge : public testing::TestWithParam<const char*> {};

TEST_P(JournalEdge, OutAndBackAskewMakesNoEnergy) {
    SimulationOptions options;
    options.integrator = GetParam();
    options.integration.rtol = options.integration.atol = 1e-7;
    Simulation sim(parse_model(leaving, "leaving"), options);
    const double start = sim.sample().energies.mechanical();
    double furthest = 0, highest = 0, lost = 0;
    for (int k = 1; k <= 200; ++k) {
        ASSERT_TRUE(sim.advance_to(0.002 * k).ok);
        const Sample& s = sim.sample();
        furthest = std::max(furthest, s.motion[0].r.x());
        highest = std::max(highest, s.energies.mechanical());
        lost = s.state.dissipated();
        EXPECT_NEAR(s.balance, 0, 1e-3 * start);
    }
    EXPECT_GT(furthest, 0.05); // wholly out of the bearing of 0.04 m
    EXPECT_LT(highest, (1 + 1e-3) * start);
    EXPECT_GT(lost, 0);
    EXPECT_GT(sim.state().history[0].impacts, 8);
}

INSTANTIATE_TEST_SUITE_P(Every, JournalEdge, testing::Values("radau", "gear", "ida"),
                         [](const auto& info) { return std::string(info.param); });

} // namespace
} // namespace gudgeon
