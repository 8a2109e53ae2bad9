// Division of beams into rigid elements, and what the model file says about them.
#include "core/beam.hpp"
#include "core/reader.hpp"
#include "core/writer.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace gudgeon {
namespace {

using namespace test;

const char* const text = R"({"gudgeon": 1, "name": "mast", "parameters": {"e": 2.1e11},
"bodies": [{"name": "load", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [1, 2, 5]}],
"joints": [{"name": "foot", "kind": "rigid", "bodies": ["ground", "mast.start"], "point": [1, 2, 3]},
           {"name": "top", "kind": "spherical", "bodies": ["mast.5", "load"], "point": [1, 2, 5]}],
"forces": [{"name": "push", "kind": "force", "body": "mast.end", "point": [1, 2, 5], "vector": [1, 0, 0]}],
"markers": [{"name": "middle", "body": "mast.3", "point": [1, 2, 4]}],
"beams": [{"name": "mast", "points": [[1, 2, 3], [1, 2, 5]], "direction": [1, 0, 1],
           "section": {"rectangle": {"width": 0.04, "height": 0.02}},
           "material": {"young": "e", "poisson": 0.3, "density": 7850, "loss": 0.01}, "elements": 4,
           "velocity": [0, 0.5, 0], "angular_velocity": [0, 0, 2]}]})";

Model expanded() {
    Model model = parse_model(text, "mast.json");
    expand_beams(model);
    return model;
}

TEST(BeamDivision, PiecesAreTheBeam) {
    const Model model = expanded();
    ASSERT_EQ(model.bodies.size(), 6u);
    ASSERT_EQ(model.joints.size(), 6u);
    const double area = 8e-4, mass = 2 * area * 7850, iy = 0.04 * 8e-6 / 12, iz = 0.02 * 64e-6 / 12;
    double sum = 0;
    Mat3 inertia = Mat3::Zero(); // about the middle, beam axes
    for (int i = 0; i < 5; ++i) {
        const Body& body = model.bodies[i + 1];
        EXPECT_EQ(body.name, "mast." + std::to_string(i + 1));
        const double length = i % 4 == 0 ? 0.25 : 0.5, middle = i == 0 ? 0.125 : i == 4 ? 1.875 : 0.5 * i;
        EXPECT_NEAR(body.mass, mass * length / 2, 1e-12);
        EXPECT_LT((body.position - Vec3(1, 2, 3 + middle)).norm(), 1e-14);
        // x up, y along X (the direction, across the beam), z along Y
        EXPECT_LT((rotation(body.orientation) * Vec3(1, 2, 3) - Vec3(2, 3, 1)).norm(), 1e-14);
        EXPECT_LT((body.velocity - (Vec3(0, 0.5, 0) + Vec3(0, 2, 0).cross(Vec3(0, 0, middle - 1)))).norm(),
                  1e-14);
        const double arm = middle - 1;
        sum += body.mass;
        inertia += body.inertia + body.mass * Mat3(Vec3(0, arm * arm, arm * arm).asDiagonal());
    }
    EXPECT_NEAR(sum, mass, 1e-12);
    const double line = 2 * 7850, slender = mass * 4 / 12;
    const Mat3 prism = Vec3(line * (iy + iz), line * iy + slender, line * iz + slender).asDiagonal();
    EXPECT_LT((inertia - prism).norm(), 1e-12 * prism.norm());
    EXPECT_EQ(model.joints[0].bodies[1], "mast.1");
    EXPECT_EQ(std::get<AppliedForce>(model.forces[0]).body, "mast.5");
}

TEST(BeamDivision, StiffnessOfAnElement) {
    const Model model = expanded();
    const double d = 0.5, area = 8e-4, shear = 2.1e11 / 2.6, k = 13.0 / 15.3;
    const double iy = 0.04 * 8e-6 / 12, iz = 0.02 * 64e-6 / 12,
                 torsion = 0.229 * 0.04 * 8e-6; // Roark, a/b = 2
    const Joint& element = model.joints[2];
    EXPECT_EQ(element.name, "mast.sde1");
    const System system = compiled(model);
    const JointRecord& record = system.joints[2];
    // h, t, b of the joint frame are y, z, x of the beam
    Mat3 frame;
    frame << Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX();
    EXPECT_LT((record.a.axes - frame).norm(), 1e-14);
    EXPECT_LT((record.b.axes - frame).norm(), 1e-14);
    const std::array<double, 6> truth{k * shear * area / d, k * shear * area / d, 2.1e11 * area / d,
                                      2.1e11 * iy / d,      2.1e11 * iz / d,      shear * torsion / d};
    const double first = pi * pi / 4 * std::sqrt(2.1e11 * iy / (7850 * area)); // (pi/l)^2 sqrt(EI/rho A)
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(element.bushing->stiffness[i] / truth[i], 1, i == 5 ? 2e-3 : 1e-12) << i;
        EXPECT_NEAR(element.bushing->damping[i] / element.bushing->stiffness[i], 0.01 / first, 1e-12) << i;
    }
}

TEST(BeamDivision, SectionsOfBooks) {
    const double d = 0.03;
    const SectionProperties round = section_properties(RoundSection{d}, 0.3);
    EXPECT_NEAR(round.area, pi * d * d / 4, 1e-18);
    EXPECT_NEAR(round.iy, pi * std::pow(d, 4) / 64, 1e-21);
    EXPECT_NEAR(round.torsion, pi * std::pow(d, 4) / 32, 1e-21);
    EXPECT_NEAR(round.shear[0], 6 * 1.3 / 8.8, 1e-14);
    const SectionProperties tube = section_properties(TubeSection{0.05, d}, 0.3);
    EXPECT_NEAR(tube.iz, pi * (std::pow(0.05, 4) - std::pow(d, 4)) / 64, 1e-20);
    // a thin tube has half of its area
    EXPECT_NEAR(section_properties(TubeSection{1, 1 - 1e-9}, 0).shear[0], 0.5, 1e-8);
    // Timoshenko & Goodier: square 0.1406 a^4, thin strip a b^3/3
    EXPECT_NEAR(section_properties(RectangleSection{1, 1}, 0.3).torsion, 0.140577, 1e-6);
    EXPECT_NEAR(section_properties(RectangleSection{1e-3, 1}, 0.3).torsion * 3e9, 1 - 0.63e-3, 1e-5);
}

TEST(BeamDivision, FileKeepsTheBeamAsItWasWritten) {
    const Model model = parse_model(text, "mast.json");
    const std::string written = write_model(model);
    EXPECT_EQ(write_model(parse_model(written, "again.json")), written);
    const nlohmann::json beam = nlohmann::json::parse(written)["beams"][0];
    EXPECT_EQ(beam["section"]["rectangle"]["width"], 0.04);
    EXPECT_EQ(beam["elements"], 4);
    // compiled, the pieces are not written as bodies
    const nlohmann::json compiled_one = nlohmann::json::parse(write_model(compiled(model).model));
    EXPECT_EQ(compiled_one["bodies"].size(), 1u);
    EXPECT_EQ(compiled_one["joints"].size(), 2u);
    EXPECT_EQ(compiled_one["beams"][0], beam);
}

TEST(BeamDivision, PosesOfThePiecesAreKept) {
    Model model = expanded();
    model.bodies[2].start_position = Vec3(1.1, 2.2, 3.3);
    model.bodies[2].start_orientation = Vec4(0.6, 0, 0.8, 0);
    const System again = compiled(parse_model(write_model(model), "again.json"));
    const int i = again.body_index("mast.2");
    EXPECT_EQ(again.start[i].r, Vec3(1.1, 2.2, 3.3));
    EXPECT_EQ(again.start[i].p, Vec4(0.6, 0, 0.8, 0));
    EXPECT_EQ(again.start[again.body_index("mast.5")].r, model.bodies[5].position);
}

TEST(BeamDivision, WithoutStretchOnlyRotationsAreFree) {
    nlohmann::json document = nlohmann::json::parse(text);
    document["beams"][0]["stretch"] = false;
    const System stiff = compiled(parse_model(document.dump(), "stiff.json")), whole = compiled(expanded());
    EXPECT_EQ(stiff.row_count(), whole.row_count() + 4 * 3);
}

TEST(BeamDivision, ABeamAloneIsAModel) {
    nlohmann::json document = nlohmann::json::parse(text);
    for (const char* key : {"bodies", "joints", "forces", "markers"})
        document.erase(key);
    EXPECT_EQ(compiled(parse_model(document.dump(), "alone.json")).moving, 5);
}

} // namespace
} // namespace gudgeon
