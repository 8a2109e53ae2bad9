#include "core/reader.hpp"
#include "core/writer.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <filesystem>

namespace gudgeon {
namespace {

// Everything the format has, each value told apart.
const char* const everything = R"({
  "gudgeon": 1, "name": "all", "gravity": [1, 2, "g"], "parameters": {"g": -3, "k": 2e4},
  "bodies": [
    {"name": "frame", "fixed": true, "position": [0, 0, 5], "orientation": [0, 0, 0, 2]},
    {"name": "a", "mass": 0.12, "inertia": [1e-4, 2e-4, 2.5e-4], "position": [0, 0.1, 0.16],
     "velocity": [0, -0.24, 0.5], "angular_velocity": [6, 7, 8], "hold": ["x", "rz"]},
    {"name": "b", "mass": "k", "inertia": [[4, 0.1, 0.2], [0.1, 5, 0.3], [0.2, 0.3, 6]], "orientation": [3, 0, 4, 0]}
  ],
  "joints": [
    {"name": "U", "kind": "universal", "bodies": ["a", "b"], "point": [1, 2, 3], "axis": [0, 0, 1], "axis2": [0.5, 1, 0]},
    {"name": "R", "kind": "revolute", "bodies": ["ground", "a"], "point": [0, 0, 0], "axis": [0, 1, 0],
     "reference": [1, 0, 0], "drives": {"angle": {"kind": "harmonic", "amplitude": 3, "frequency": 2, "phase": 0.5, "offset": -1}}},
    {"name": "C", "kind": "cylindrical", "bodies": ["frame", "b"], "frame": "body", "points": [[1, 0, 0], [0, 1, 0]],
     "axes": [[1, 0, 0], [0, 2, 0]], "references": [[0, 1, 0], [0, 0, 1]],
     "drives": {"slide": {"kind": "smooth-step", "start": 1, "end": 2, "from": 3, "to": 4},
                "angle": {"kind": "ramp", "rate": 5, "start": 6, "value": 7}}},
    {"name": "L", "kind": "distance", "bodies": ["a", "frame"], "points": [[0, 0, 0], [0, 0, 1]], "length": 1.5},
    {"name": "M", "kind": "rigid", "bodies": ["frame", "b"], "point": [0, 0, 0], "fidelity": "bushing",
     "bushing": {"stiffness": [1, 2, 3, 4, 5, "k"], "damping": [6, 5, 4, 3, 2, 1], "preload": [-1, 0, 1, 0, 0, 2],
                 "axes": "global", "tables": {"y": {"x": [-1, 1], "y": [-5, 5]}, "rz": {"x": [0, 1, 2], "y": [0, 2, "k"]}}}}
  ],
  "forces": [
    {"name": "S", "kind": "spring-damper", "bodies": ["a", "b"], "points": [[0, 0, 1], [0, 2, 0]], "stiffness": "k",
     "damping": 3, "free_length": 0.5, "actuator": {"kind": "constant", "value": 9}},
    {"name": "S2", "kind": "spring-damper", "frame": "body", "bodies": ["ground", "b"], "points": [[0, 0, 1], [0, 2, 0]],
     "table": {"x": [0, 1], "y": [0, 7]}, "preload": -8},
    {"name": "T", "kind": "torsion-spring", "joint": "C", "stiffness": 1, "damping": 2, "free_angle": 3},
    {"name": "W", "kind": "tyre", "body": "b", "point": [1, 1, 1], "frame": "body", "stiffness": 1, "damping": 2, "preload": 3,
     "reference": 4, "road": {"kind": "table", "x": [0, 1], "y": [0, 0.1]}, "profile": {"x": [0, 5], "y": [0, 0.2]}},
    {"name": "F", "kind": "force", "body": "a", "frame": "body", "point": [1, 2, 3], "vector": [4, 5, 6], "axes": "body"},
    {"name": "N", "kind": "torque", "body": "a", "vector": [7, 8, 9], "time": {"kind": "constant", "value": 2}}
  ],
  "markers": [{"name": "P", "body": "a", "point": [1, 2, 3]}, {"name": "Q", "body": "ground", "frame": "body", "point": [0, 0, 1]}],
  "end": 2.5, "every": 0.125
})";

const Model& all() {
    static const Model model = parse_model(everything, "all.json");
    return model;
}

TEST(Reader, TopLevelAndParameters) {
    EXPECT_EQ(all().name, "all");
    EXPECT_EQ(all().source, "all.json");
    EXPECT_EQ(all().gravity, Vec3(1, 2, -3));
    EXPECT_EQ(all().parameters, (std::map<std::string, double>{{"g", -3}, {"k", 2e4}}));
    EXPECT_EQ(all().end, 2.5);
    EXPECT_EQ(all().every, 0.125);
    const Model changed = parse_model(everything, "all.json", {{"k", 7}});
    EXPECT_EQ(changed.bodies[2].mass, 7);
    EXPECT_EQ(changed.parameters.at("k"), 7);
}

TEST(Reader, Defaults) {
    const Model m =
        parse_model(R"({"gudgeon": 1, "bodies": [{"name": "b", "mass": 1, "inertia": [1, 2, 3]}]})", "m");
    EXPECT_EQ(m.name, "model");
    EXPECT_EQ(m.gravity, Vec3(0, 0, -9.81));
    EXPECT_FALSE(m.end || m.every);
    EXPECT_EQ(m.bodies[0].position, Vec3::Zero());
    EXPECT_EQ(m.bodies[0].orientation, Vec4(1, 0, 0, 0));
    EXPECT_EQ(m.bodies[0].velocity, Vec3::Zero());
    EXPECT_EQ(m.bodies[0].angular_velocity, Vec3::Zero());
    EXPECT_FALSE(m.bodies[0].fixed);
}

TEST(Reader, Bodies) {
    const auto& bodies = all().bodies;
    EXPECT_TRUE(bodies[0].fixed);
    EXPECT_EQ(bodies[0].orientation, Vec4(0, 0, 0, 1));
    EXPECT_EQ(bodies[1].mass, 0.12);
    EXPECT_EQ(bodies[1].inertia, Mat3(Vec3(1e-4, 2e-4, 2.5e-4).asDiagonal()));
    EXPECT_EQ(bodies[1].position, Vec3(0, 0.1, 0.16));
    EXPECT_EQ(bodies[1].velocity, Vec3(0, -0.24, 0.5));
    EXPECT_EQ(bodies[1].angular_velocity, Vec3(6, 7, 8));
    EXPECT_EQ(bodies[1].hold, (std::vector<std::string>{"x", "rz"}));
    EXPECT_EQ(bodies[2].mass, 2e4);
    EXPECT_EQ(bodies[2].inertia(1, 2), 0.3);
    EXPECT_TRUE(bodies[2].orientation.isApprox(Vec4(0.6, 0, 0.8, 0), 1e-15));
}

TEST(Reader, Joints) {
    const auto& joints = all().joints;
    EXPECT_EQ(joints[0].kind, JointKind::universal);
    EXPECT_EQ(joints[0].bodies, (std::array<std::string, 2>{"a", "b"}));
    EXPECT_EQ(joints[0].points[0], Vec3(1, 2, 3));
    EXPECT_EQ(joints[0].points[1], Vec3(1, 2, 3));
    EXPECT_EQ((*joints[0].axes)[0], Vec3(0, 0, 1));
    EXPECT_EQ((*joints[0].axes)[1], Vec3(0.5, 1, 0));
    EXPECT_EQ((*joints[1].references)[1], Vec3(1, 0, 0));
    const auto& harmonic = std::get<HarmonicFunction>(joints[1].drives.at("angle"));
    EXPECT_EQ(harmonic.amplitude, 3);
    EXPECT_EQ(harmonic.frequency, 2);
    EXPECT_EQ(harmonic.phase, 0.5);
    EXPECT_EQ(harmonic.offset, -1);
    EXPECT_TRUE(joints[2].body_frame);
    EXPECT_EQ(joints[2].points[1], Vec3(0, 1, 0));
    EXPECT_EQ((*joints[2].axes)[1], Vec3(0, 2, 0));
    EXPECT_EQ((*joints[2].references)[1], Vec3(0, 0, 1));
    const auto& step = std::get<SmoothStepFunction>(joints[2].drives.at("slide"));
    EXPECT_EQ(step.start, 1);
    EXPECT_EQ(step.end, 2);
    EXPECT_EQ(step.from, 3);
    EXPECT_EQ(step.to, 4);
    const auto& ramp = std::get<RampFunction>(joints[2].drives.at("angle"));
    EXPECT_EQ(ramp.rate, 5);
    EXPECT_EQ(ramp.start, 6);
    EXPECT_EQ(ramp.value, 7);
    EXPECT_EQ(joints[3].length, 1.5);
    EXPECT_EQ(joints[3].fidelity, Fidelity::perfect);
}

TEST(Reader, Bushing) {
    const Joint& joint = all().joints[4];
    EXPECT_EQ(joint.fidelity, Fidelity::bushing);
    EXPECT_FALSE(joint.axes);
    const Bushing& b = *joint.bushing;
    EXPECT_EQ(b.stiffness, (std::array<double, 6>{1, 2, 3, 4, 5, 2e4}));
    EXPECT_EQ(b.damping, (std::array<double, 6>{6, 5, 4, 3, 2, 1}));
    EXPECT_EQ(b.preload, (std::array<double, 6>{-1, 0, 1, 0, 0, 2}));
    EXPECT_TRUE(b.global_axes);
    EXPECT_TRUE(b.tables[0].empty());
    EXPECT_EQ(b.tables[1].y, (std::vector<double>{-5, 5}));
    EXPECT_EQ(b.tables[5].y, (std::vector<double>{0, 2, 2e4}));
}

TEST(Reader, ForcesAndMarkers) {
    const auto& s = std::get<SpringDamper>(all().forces[0]);
    EXPECT_EQ(s.points[1], Vec3(0, 2, 0));
    EXPECT_EQ(s.stiffness, 2e4);
    EXPECT_EQ(s.damping, 3);
    EXPECT_EQ(s.free_length, 0.5);
    EXPECT_EQ(std::get<ConstantFunction>(*s.actuator).value, 9);
    const auto& s2 = std::get<SpringDamper>(all().forces[1]);
    EXPECT_TRUE(s2.body_frame);
    EXPECT_EQ(s2.preload, -8);
    EXPECT_EQ(s2.table.y[1], 7);
    const auto& t = std::get<TorsionSpring>(all().forces[2]);
    EXPECT_EQ(t.joint, "C");
    EXPECT_EQ(t.coordinate, "angle");
    EXPECT_EQ(t.free_angle, 3);
    const auto& w = std::get<Tyre>(all().forces[3]);
    EXPECT_TRUE(w.body_frame);
    EXPECT_EQ(w.preload, 3);
    EXPECT_EQ(w.reference, 4);
    EXPECT_EQ(std::get<TableFunction>(*w.road).table().y[1], 0.1);
    EXPECT_EQ(w.profile.x[1], 5);
    const auto& f = std::get<AppliedForce>(all().forces[4]);
    EXPECT_TRUE(f.follows && f.body_frame && !f.torque && !f.time);
    EXPECT_EQ(f.point, Vec3(1, 2, 3));
    EXPECT_EQ(f.vector, Vec3(4, 5, 6));
    const auto& n = std::get<AppliedForce>(all().forces[5]);
    EXPECT_TRUE(n.torque && !n.follows);
    EXPECT_EQ(n.vector, Vec3(7, 8, 9));
    EXPECT_EQ(all().markers[0].point, Vec3(1, 2, 3));
    EXPECT_TRUE(all().markers[1].body_frame);
}

TEST(Reader, Files) {
    EXPECT_THROW(read_model("/nowhere/model.json"), FileError);
    EXPECT_THROW(read_model(std::filesystem::temp_directory_path()), FileError);
    const Model m = read_model(GUDGEON_SOURCE_DIR "/models/examples/rubber-mount.json", {{"lateral", 1}});
    EXPECT_EQ(m.joints[0].bushing->stiffness[0], 1);
}

TEST(Reader, MessageNamesFilePlaceProblemAndWhatIsAllowed) {
    try {
        parse_model(R"({"gudgeon": 1, "bodies": [{"name": "b", "mass": -2, "inertia": [1, 1, 1]}]})",
                    "m.json");
        FAIL();
    } catch (const ModelError& error) {
        EXPECT_STREQ(error.what(), "m.json: /bodies/0/mass: -2 is not positive; allowed: more than 0");
    }
}

TEST(Reader, CutJoints) {
    Model model = all();
    EXPECT_FALSE(model.joints[0].cut);
    model.joints[0].cut = true;
    const auto json = to_json(model);
    EXPECT_EQ(json["joints"][0]["cut"], true);
    EXPECT_FALSE(json["joints"][1].contains("cut"));
    const Model back = parse_model(write_model(model), "written");
    EXPECT_TRUE(back.joints[0].cut);
    EXPECT_FALSE(back.joints[1].cut);
}

// The written text is compared: two models write the same text only if every double is the same.
void expect_round_trip(const Model& model) {
    const std::string text = write_model(model);
    EXPECT_EQ(write_model(parse_model(text, "written")), text);
}

TEST(Writer, RoundTrip) {
    expect_round_trip(all());
    for (const char* name : {"double-pendulum", "mast", "rubber-mount", "slider-crank", "worn-hinge"})
        expect_round_trip(read_model(std::string(GUDGEON_SOURCE_DIR "/models/examples/") + name + ".json"));
}

TEST(Writer, ParametersAreResolved) {
    const auto json = to_json(all());
    EXPECT_EQ(json["bodies"][2]["mass"], 2e4);
    EXPECT_EQ(json["gravity"], nlohmann::ordered_json({1, 2, -3}));
    EXPECT_EQ(json["parameters"]["k"], 2e4);
    EXPECT_EQ(json["joints"][0]["axis2"], nlohmann::ordered_json({0.5, 1, 0}));
    EXPECT_EQ(json["joints"][2]["frame"], "body");
    EXPECT_FALSE(json["joints"][0].contains("frame"));
}

TEST(Writer, DoublesComeBackBitForBit) {
    Model m;
    Body body;
    body.name = "b";
    body.mass = 0.1 + 0.2;
    body.inertia = Vec3(1.0 / 3, 1.0 / 3, 5e-324).cwiseMax(1e-300).asDiagonal();
    body.position = {5e-324, -0.0, 1.7976931348623157e308};
    body.velocity = {1e23, 9007199254740993.0, 1.0 / 49};
    std::uint64_t seed = 1;
    const auto next = [&] { // a spread of orientations; normalising twice must not change a bit
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        return static_cast<double>(seed >> 11) / 9007199254740992.0 - 0.5;
    };
    for (int i = 0; i < 500; ++i) {
        body.name = "b" + std::to_string(i);
        body.orientation = Vec4(next(), next(), next(), next()).normalized();
        m.bodies.push_back(body);
    }
    const Model back = parse_model(write_model(m), "written");
    for (std::size_t i = 0; i < m.bodies.size(); ++i) {
        EXPECT_EQ(back.bodies[i].orientation, m.bodies[i].orientation);
        EXPECT_EQ(back.bodies[i].mass, body.mass);
        EXPECT_EQ(back.bodies[i].inertia, body.inertia);
        EXPECT_EQ(back.bodies[i].position, body.position);
        EXPECT_TRUE(std::signbit(back.bodies[i].position[1]));
        EXPECT_EQ(back.bodies[i].velocity, body.velocity);
    }
}

// Objects with few keys and with many are searched differently.
TEST(Reader, RefusesARepeatedKeyAmongAnyNumber) {
    for (const int count : {1, 15, 16, 17, 40})
        for (const int again : {0, count / 2, count - 1}) {
            std::string keys;
            for (int k = 0; k < count; ++k)
                keys += "\"p" + std::to_string(k) + "\": 1, ";
            const auto text = [&](const std::string& last) {
                return R"({"gudgeon": 1, "parameters": {)" + keys + "\"" + last +
                       R"(": 2}, "bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1]}]})";
            };
            EXPECT_EQ(parse_model(text("q"), "m.json").parameters.size(), count + 1u);
            const std::string repeated = "p" + std::to_string(again);
            try {
                parse_model(text(repeated), "m.json");
                ADD_FAILURE() << count << ", " << again;
            } catch (const ModelError& error) {
                EXPECT_EQ(error.pointer(), "/parameters/" + repeated);
            }
        }
}

} // namespace
} // namespace gudgeon
