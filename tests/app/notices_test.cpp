// What a start is told to the user: contacts that begin deep, clearances of zero; and records of joints
// whose contacts lie in several batches.
#include "app/command_tools.hpp"

namespace gudgeon {
namespace {

using nlohmann::json;
using test::command;
using test::summary_in;

class Notices : public test::CommandTest {
  protected:
    /// An arm on a hinge with play and a stop at `lower`, beginning at the angle 0.
    std::string hinge(double play, double lower) {
        json model = json::parse(R"({"gudgeon": 1, "end": 0.1, "every": 0.01, "gravity": [0, 0, 0],
            "bodies": [{"name": "arm", "mass": 1, "inertia": [1e-3, 0.02, 0.02], "position": [0.2, 0, 0]}],
            "joints": [{"name": "hinge", "kind": "revolute", "bodies": ["ground", "arm"], "point": [0, 0, 0],
                "axis": [0, 1, 0], "fidelity": "clearance",
                "clearance": {"radial": 1e-4, "axial": 1e-4, "radius": 0.01, "length": 0.03,
                              "law": {"kind": "hertz", "stiffness": 1e8}},
                "stops": {"angle": {"law": {"kind": "linear", "stiffness": 100}}}}]})");
        model["joints"][0]["clearance"]["radial"] = play;
        model["joints"][0]["stops"]["angle"]["lower"] = lower;
        return write("hinge.json", model.dump());
    }
};

TEST_F(Notices, NothingToSay) {
    const std::string model = hinge(1e-4, -1);
    EXPECT_EQ(command({"check", model}).out.find("notice"), std::string::npos);
    ASSERT_EQ(command({"run", model, "--out", path("o")}).code, 0);
    EXPECT_TRUE(summary_in(folder_ / "o")["notices"].empty());
}

TEST_F(Notices, DeepStart) {
    const std::string model = hinge(1e-4, 0.02); // 0.02 rad deep: 2 N m, 0.02 J
    const std::string words =
        "joint 'hinge' starts 0.02 rad deep in contact (stop), with 0.02 J stored and a "
        "force of 2";
    EXPECT_NE(command({"check", model}).out.find(words), std::string::npos);
    const test::Outcome run = command({"run", model, "--out", path("o")});
    EXPECT_NE(run.out.find(words), std::string::npos) << run.out;
    EXPECT_NE(summary_in(folder_ / "o")["notices"][0].get<std::string>().find(words), std::string::npos);
}

TEST_F(Notices, ZeroClearance) {
    const test::Outcome outcome = command({"check", hinge(0, -1)});
    EXPECT_NE(outcome.out.find("joint 'hinge' has a clearance of zero"), std::string::npos) << outcome.out;
}

// The stop throws the arm back at once: radial contacts follow. Never more than the whole time in contact,
// and rotations apart from displacements.
TEST_F(Notices, ContactsOfOneJointInSeveralBatches) {
    ASSERT_EQ(command({"run", hinge(1e-4, 0.02), "--out", path("o")}).code, 0);
    const json contact = summary_in(folder_ / "o")["contacts"]["hinge"];
    EXPECT_LE(contact["share"].get<double>(), 1);
    EXPECT_NEAR(contact["deepest_angle"].get<double>(), 0.02, 1e-6);
    EXPECT_NEAR(contact["peak_moment"].get<double>(), 2, 1e-3);
    EXPECT_LT(contact["deepest"].get<double>(), 1e-3); // m
}

} // namespace
} // namespace gudgeon
