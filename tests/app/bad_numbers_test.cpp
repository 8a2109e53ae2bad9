// Forces and drives beyond all numbers through the command line: exit 4 with element, time and state.
#include "tests/app/command_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

class BadNumbersOfRuns : public CommandTest {
  protected:
    Outcome run(const std::string& model, const std::string& integrator) {
        return command({"run", write("bad.json", model), "--integrator", integrator, "--step", "0.01",
                        "--quiet", "--out", path("out")});
    }
};

void expect_words(const std::string& message, const std::vector<std::string>& words) {
    for (const std::string& word : words)
        EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' in: " << message;
}

TEST_F(BadNumbersOfRuns, ForceThatOverflowsOnTheWay) {
    for (const char* integrator : {"auto", "gear", "radau", "ida", "rk4"}) {
        const Outcome outcome = run(R"({"gudgeon": 1, "name": "push", "gravity": [0, 0, 0],
          "bodies": [{"name": "cart", "mass": 1, "inertia": [1, 1, 1], "position": [0, 2, 0]}],
          "forces": [{"name": "shove", "kind": "force", "body": "cart", "vector": [1e300, 0, 0], "point": [0, 2, 0],
                      "time": {"kind": "smooth-step", "start": 0.5, "end": 0.6, "from": 0, "to": 1e300}}]})",
                                    integrator);
        EXPECT_EQ(outcome.code, 4) << integrator << outcome.err;
        expect_words(outcome.err, {"bad.json", "'shove'", "t = 0.5", "body 'cart' at (0, 2, 0) m"});
        const auto summary = summary_in(folder_ / "out");
        EXPECT_EQ(summary["status"], "failed");
        EXPECT_NEAR(summary["reached"].get<double>(), 0.5, 0.011);
        for (const auto& row : read_csv(folder_ / "out/trajectory.csv").rows)
            for (const double value : row)
                EXPECT_TRUE(std::isfinite(value));
    }
}

TEST_F(BadNumbersOfRuns, DriveThatOverflowsAtTheStart) {
    for (const char* integrator : {"auto", "gear", "radau", "ida", "rk4"}) {
        const Outcome outcome = run(R"({"gudgeon": 1, "name": "over",
          "bodies": [{"name": "cart", "mass": 1, "inertia": [1, 1, 1]}],
          "joints": [{"name": "rail", "kind": "translation", "bodies": ["ground", "cart"], "point": [0, 0, 0],
                      "axis": [1, 0, 0],
                      "drives": {"slide": {"kind": "harmonic", "amplitude": 1e-300, "frequency": 1e200}}}]})",
                                    integrator);
        EXPECT_EQ(outcome.code, 4) << integrator << outcome.err;
        expect_words(outcome.err,
                     {"bad.json", "joint 'rail' (driven displacement)", "t = 0 s", "body 'cart'"});
    }
}

} // namespace
} // namespace gudgeon
