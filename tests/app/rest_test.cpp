// `gudgeon statics`, `gudgeon modes`, `--start equilibrium`.
#include "tests/app/command_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;
namespace fs = std::filesystem;

class CommandLineRest : public testing::Test {
  protected:
    CommandLineRest() { fs::remove_all(folder_); }
    ~CommandLineRest() override { fs::remove_all(folder_); }
    nlohmann::json json(const char* name) const { return nlohmann::json::parse(text_of(folder_ / name)); }
    fs::path folder_ = fs::temp_directory_path() / ("gudgeon-rest-" + std::to_string(getpid()));
};

TEST_F(CommandLineRest, StaticsWritesPoseReactionsAndAModelThatStartsThere) {
    const Outcome first = command({"statics", "suspension-chain", "--out", folder_.string()});
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_NE(first.out.find("everything turns about z"), std::string::npos) << first.out;
    const auto result = json("statics.json");
    EXPECT_LT(result["relative_residual"].get<double>(), 1e-9);
    EXPECT_EQ(result["neutral"].size(), 3u);
    // both tyres carry the whole unit
    double mass = 0;
    const auto model = json("equilibrium.json");
    for (const auto& body : model["bodies"])
        mass += body["mass"].get<double>();
    double carried = 0;
    for (const auto& [name, force] : result["forces"].items())
        if (name.starts_with("tyre"))
            carried += force["force"][2].get<double>();
    EXPECT_NEAR(carried / (mass * 9.81), 1, 1e-9);

    const Outcome second = command({"run", (folder_ / "equilibrium.json").string(), "--start", "equilibrium",
                                    "--end", "0.01", "--quiet", "--out", folder_.string()});
    ASSERT_EQ(second.code, 0) << second.err;
    EXPECT_EQ(summary_in(folder_)["equilibrium"]["steps"], 0);
    EXPECT_EQ(summary_in(folder_)["settings"]["used"]["start"], "equilibrium");
}

TEST_F(CommandLineRest, ModesWritesFrequenciesAndShapes) {
    const Outcome outcome =
        command({"modes", "pendulum", "--start", "equilibrium", "--out", folder_.string()});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto result = json("modes.json");
    EXPECT_EQ(result["neutral"], 1);
    EXPECT_NEAR(result["modes"][1]["omega"].get<double>(), std::sqrt(9.81), 1e-9);
    EXPECT_NEAR(std::abs(result["modes"][1]["shape"]["bob"]["translation"]["re"][0].get<double>()), 1, 1e-12);
    EXPECT_NE(text_of(folder_ / "modes.csv").find("2,vibration,"), std::string::npos);
}

TEST_F(CommandLineRest, ModesTellOfAStateThatIsNoEquilibrium) {
    const auto falling = command({"modes", "pendulum", "--out", folder_.string()});
    EXPECT_NE(falling.out.find("'bob' accelerates by 9.81 m/s2"), std::string::npos) << falling.out;
    const auto hanging = command({"modes", "pendulum", "--start", "equilibrium", "--out", folder_.string()});
    EXPECT_EQ(hanging.out.find("no equilibrium"), std::string::npos) << hanging.out;
}

TEST_F(CommandLineRest, UnstableModesAreMarked) {
    const Outcome outcome = command({"modes", "four-bar", "--out", folder_.string()});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("GROWS"), std::string::npos) << outcome.out;
}

TEST_F(CommandLineRest, FreeFallStopsWithTheNameOfWhatFalls) {
    fs::create_directories(folder_);
    const fs::path file = folder_ / "fall.json";
    std::ofstream(file)
        << R"({"gudgeon": 1, "bodies": [{"name": "stone", "mass": 1, "inertia": [1, 1, 1]}]})";
    for (const std::vector<std::string>& args : {std::vector<std::string>{"statics", file.string()},
                                                 {"run", file.string(), "--start", "equilibrium"},
                                                 {"modes", file.string(), "--start", "equilibrium"}}) {
        std::vector<std::string> all = args;
        all.insert(all.end(), {"--out", (folder_ / "out").string()});
        const Outcome outcome = command(all);
        EXPECT_EQ(outcome.code, 4);
        EXPECT_NE(outcome.err.find(file.string() + ": no equilibrium"), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find("'stone' (9.81 m/s2"), std::string::npos) << outcome.err;
    }
}

TEST_F(CommandLineRest, BadInputIsNamed) {
    const Outcome start = command({"modes", "pendulum", "--start", "anywhere"});
    EXPECT_EQ(start.code, 2);
    EXPECT_NE(start.err.find("--start: unknown word 'anywhere'"), std::string::npos) << start.err;
    const Outcome count = command({"modes", "pendulum", "--count", "0"});
    EXPECT_EQ(count.code, 2);
    EXPECT_NE(count.err.find("--count: '0' is not allowed; allowed: whole numbers"), std::string::npos)
        << count.err;
    fs::create_directories(folder_);
    const fs::path file = folder_ / "bad.json";
    std::ofstream(file) << R"({"gudgeon": 1, "bodies": [{"name": "a", "mass": 1, "inertia": [1, 1, 1]}],
      "joints": [{"name": "j", "kind": "revolute", "bodies": ["ground", "a"], "point": [0, 0, 0], "axis": [0, 1, 0],
                  "start_angles": {"slide": 3}}]})";
    const Outcome angles = command({"statics", file.string()});
    EXPECT_EQ(angles.code, 2);
    EXPECT_NE(angles.err.find("/joints/0/start_angles/slide: the joint has no angle 'slide'"),
              std::string::npos)
        << angles.err;
}

} // namespace
} // namespace gudgeon
