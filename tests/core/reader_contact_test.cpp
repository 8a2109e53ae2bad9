// Imperfect joints, friction and onset: from text to the model and back.
#include "core/joint_motions.hpp"
#include "core/reader.hpp"
#include "core/writer.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace gudgeon {
namespace {

// Every key of the imperfect joints, each value told apart.
const char* const worn = R"({
  "gudgeon": 1, "name": "worn", "parameters": {"c": 1e-4, "n": 5, "mu": 0.25},
  "bodies": [
    {"name": "a", "mass": 1, "inertia": [1, 1, 1]}, {"name": "b", "mass": 1, "inertia": [1, 1, 1]}],
  "joints": [
    {"name": "R", "kind": "revolute", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0],
     "fidelity": "clearance", "bearing": "b",
     "clearance": {"radial": "c", "axial": 2e-4, "radius": 0.01, "length": 0.04, "journal_length": 0.05, "strips": "n",
       "law": {"kind": "lankarani-nikravesh", "stiffness": 5e6, "exponent": 1.4, "restitution": 0.75},
       "axial_law": {"kind": "flores", "stiffness": 6e6, "restitution": 0.5},
       "friction": {"kind": "lugre", "mu_k": "mu", "mu_s": 0.5, "speed": 1e-3, "exponent": 1.5, "sigma0": 1e5,
                    "sigma1": 316, "sigma2": 0.4, "radius": 0.012}}},
    {"name": "C", "kind": "cylindrical", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0],
     "fidelity": {"radial": "clearance", "misalignment": "bushing"},
     "bushing": {"stiffness": [0, 0, 0, 7, 8, 0]},
     "clearance": {"radial": 5e-5, "profile": [0.01, 0.011, "c"], "length": 0.04,
       "law": {"kind": "blend", "stiffness": 1e6, "damping": 20, "thickness": 1e-3, "width": 2e-3, "blend": "smooth",
               "hard": {"kind": "hertz", "materials": [{"young": 2e11, "poisson": 0.3}, {"young": 1e11, "poisson": 0.2}]}}},
     "stops": {"slide": {"lower": -0.1, "upper": "c", "law": {"kind": "kelvin-voigt", "stiffness": 1e5, "restitution": 0.01, "speed": 0.1},
                         "friction": {"kind": "dahl", "mu_k": 0.3, "sigma0": 3e5, "radius": 0.04}},
               "angle": {"upper": 12.5, "law": {"kind": "tabulated", "table": {"x": [0, 0.1], "y": [0, 3]}, "damping": 4}}},
     "friction": [{"kind": "coulomb", "mu_k": 0.1, "speed": 2e-3, "coordinate": "slide", "normal_force": 30},
                  {"kind": "dahl", "mu_k": 0.2, "sigma0": 2e5, "coordinate": "angle", "normal_force": 40, "radius": 0.02}]},
    {"name": "T", "kind": "translation", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0],
     "fidelity": {"radial": "perfect", "misalignment": "free", "rotation": "clearance"},
     "clearance": {"rotation": 0.02, "law": {"kind": "linear", "stiffness": 11},
                   "rotation_law": {"kind": "hunt-crossley", "stiffness": 12}}},
    {"name": "S", "kind": "translation", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0],
     "fidelity": "clearance",
     "clearance": {"model": "slot", "radial": 1e-4, "section": [0.02, 0.03], "length": 0.1, "law": {"kind": "linear", "stiffness": 11}},
     "friction": {"kind": "coulomb-smooth", "mu_k": 0.3, "speed": 0.01, "normal_force": 9}},
    {"name": "B", "kind": "spherical", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0],
     "stops": {"swing": {"upper": 0.7, "law": {"kind": "linear", "stiffness": 11}}}},
    {"name": "U", "kind": "universal", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0], "axis2": [0, 1, 0],
     "fidelity": "clearance",
     "clearance": {"radial": 1e-4, "misalignment": 0.03, "radius": 0.02,
                   "law": {"kind": "hertz", "material": {"young": 2e11, "poisson": 0.3}},
                   "rotation_law": {"kind": "linear", "stiffness": 13}}},
    {"name": "P", "kind": "revolute", "bodies": ["a", "b"], "point": [0, 0, 0], "axis": [1, 0, 0],
     "clearance": {"model": "planar", "radial": 1e-4, "length": 0.04,
                   "law": {"kind": "cylinder", "material": {"young": 2e11, "poisson": 0.3}, "restitution": 0.9}}}
  ],
  "forces": [
    {"name": "F", "kind": "friction", "bodies": ["ground", "b"], "point": [1, 2, 3], "axis": [0, 2, 0],
     "friction": {"kind": "dahl", "mu_k": 0.2, "sigma0": 2e5, "normal_force": "n"}},
    {"name": "G", "kind": "friction", "bodies": ["a", "b"], "frame": "body", "points": [[1, 0, 0], [0, 1, 0]], "axis": [0, 0, 1],
     "friction": {"kind": "coulomb", "mu_k": 0.2, "speed": 1e-3, "normal_force": 6}}],
  "onset": {"energy": 1e-7}
})";

const Model& model() {
    static const Model m = parse_model(worn, "worn.json");
    return m;
}

const Joint& joint(const std::string& name) {
    for (const Joint& j : model().joints)
        if (j.name == name)
            return j;
    throw std::out_of_range(name);
}

TEST(ReaderContact, FidelityOfMotions) {
    EXPECT_EQ(joint("R").fidelity, Fidelity::clearance);
    EXPECT_FALSE(is_mixed(joint("R")));
    EXPECT_EQ(joint("R").holds(Motion::axial), Fidelity::clearance);
    const Joint& c = joint("C");
    EXPECT_TRUE(is_mixed(c));
    EXPECT_EQ(c.fidelity, Fidelity::perfect);
    EXPECT_EQ(c.holds(Motion::radial), Fidelity::clearance);
    EXPECT_EQ(c.holds(Motion::misalignment), Fidelity::bushing);
    const Joint& t = joint("T");
    EXPECT_EQ(t.motions[0], Fidelity::perfect);
    EXPECT_FALSE(t.motions[1]);
    EXPECT_EQ(t.holds(Motion::misalignment), Fidelity::free);
    EXPECT_EQ(t.holds(Motion::rotation), Fidelity::clearance);
    EXPECT_TRUE(is_wholly_perfect(joint("P")));
    EXPECT_FALSE(is_wholly_perfect(c));
}

TEST(ReaderContact, Clearance) {
    const Clearance& r = *joint("R").clearance;
    EXPECT_EQ(r.model, "strips");
    EXPECT_EQ(r.radial, 1e-4);
    EXPECT_EQ(r.axial, 2e-4);
    EXPECT_EQ(r.radius, 0.01);
    EXPECT_EQ(r.length, 0.04);
    EXPECT_EQ(r.journal_length, 0.05);
    EXPECT_EQ(r.strips, 5);
    EXPECT_TRUE(r.bearing_on_b);
    EXPECT_FALSE(r.rotation || r.misalignment || r.section || r.rotation_law);
    EXPECT_EQ(r.axial_law->stiffness, 6e6);
    const Clearance& c = *joint("C").clearance;
    EXPECT_EQ(c.profile, (std::vector<double>{0.01, 0.011, 1e-4}));
    EXPECT_EQ(c.strips, 3);
    EXPECT_FALSE(c.bearing_on_b);
    EXPECT_EQ(joint("T").clearance->rotation, 0.02);
    EXPECT_EQ(joint("T").clearance->rotation_law->kind, "hunt-crossley");
    EXPECT_EQ(joint("S").clearance->model, "slot");
    EXPECT_EQ(*joint("S").clearance->section, (std::array<double, 2>{0.02, 0.03}));
    EXPECT_EQ(joint("U").clearance->misalignment, 0.03);
    EXPECT_EQ(joint("P").clearance->strips, 8);
}

TEST(ReaderContact, NormalLaws) {
    const ContactLaw& ln = joint("R").clearance->law;
    EXPECT_EQ(ln.kind, "lankarani-nikravesh");
    EXPECT_EQ(ln.stiffness, 5e6);
    EXPECT_EQ(ln.exponent, 1.4);
    EXPECT_EQ(ln.restitution, 0.75);
    EXPECT_FALSE(ln.speed || ln.damping || ln.materials || ln.thickness || ln.width);
    const ContactLaw& blend = joint("C").clearance->law;
    EXPECT_EQ(blend.damping, 20);
    EXPECT_EQ(blend.thickness, 1e-3);
    EXPECT_EQ(blend.width, 2e-3);
    EXPECT_TRUE(blend.smooth);
    ASSERT_EQ(blend.hard.size(), 1u);
    const auto& sides = *blend.hard[0].materials;
    EXPECT_EQ(sides[0].young, 2e11);
    EXPECT_EQ(sides[1].young, 1e11);
    EXPECT_EQ(sides[1].poisson, 0.2);
    const auto& both = *joint("U").clearance->law.materials;
    EXPECT_EQ(both[0].young, 2e11);
    EXPECT_EQ(both[1].poisson, 0.3);
}

TEST(ReaderContact, StopsAndFriction) {
    const auto& stops = joint("C").stops;
    ASSERT_EQ(stops.size(), 2u);
    EXPECT_EQ(stops.at("slide").lower, -0.1);
    EXPECT_EQ(stops.at("slide").upper, 1e-4);
    EXPECT_EQ(stops.at("slide").law.speed, 0.1);
    EXPECT_EQ(stops.at("slide").friction->sigma0, 3e5);
    EXPECT_EQ(stops.at("slide").friction->radius, 0.04);
    EXPECT_FALSE(stops.at("angle").friction);
    EXPECT_FALSE(joint("B").stops.at("swing").lower);
    EXPECT_EQ(joint("B").stops.at("swing").upper, 0.7);
    EXPECT_EQ(joint("R").clearance->friction->radius, 0.012);
    EXPECT_FALSE(stops.at("angle").lower);
    EXPECT_EQ(stops.at("angle").upper, 12.5);
    EXPECT_EQ(stops.at("angle").law.table.y[1], 3);
    const Friction& lugre = *joint("R").clearance->friction;
    EXPECT_EQ(lugre.kind, "lugre");
    EXPECT_EQ(lugre.kinetic, 0.25);
    EXPECT_EQ(lugre.statics, 0.5);
    EXPECT_EQ(lugre.speed, 1e-3);
    EXPECT_EQ(lugre.exponent, 1.5);
    EXPECT_EQ(lugre.sigma0, 1e5);
    EXPECT_EQ(lugre.sigma1, 316);
    EXPECT_EQ(lugre.sigma2, 0.4);
    const auto& two = joint("C").friction;
    ASSERT_EQ(two.size(), 2u);
    EXPECT_EQ(two[0].coordinate, "slide");
    EXPECT_EQ(two[0].normal_force, 30);
    EXPECT_EQ(two[0].exponent, 2);
    EXPECT_EQ(two[1].radius, 0.02);
    ASSERT_EQ(joint("S").friction.size(), 1u);
    EXPECT_FALSE(joint("S").friction[0].coordinate);
}

TEST(ReaderContact, FrictionForcesAndOnset) {
    const auto& f = std::get<FrictionForce>(model().forces[0]);
    EXPECT_EQ(f.bodies, (std::array<std::string, 2>{"ground", "b"}));
    EXPECT_EQ(f.points[0], Vec3(1, 2, 3));
    EXPECT_EQ(f.points[1], Vec3(1, 2, 3));
    EXPECT_EQ(f.axis, Vec3(0, 2, 0));
    EXPECT_EQ(f.friction.normal_force, 5);
    const auto& g = std::get<FrictionForce>(model().forces[1]);
    EXPECT_TRUE(g.body_frame);
    EXPECT_EQ(g.points[1], Vec3(0, 1, 0));
    EXPECT_EQ(model().onset.energy, 1e-7);
    EXPECT_FALSE(model().onset.depth || model().onset.force);
}

TEST(WriterContact, GivesBackWhatWasRead) {
    const auto written = to_json(model());
    // The file itself with its parameters resolved: nothing is lost, nothing is added.
    nlohmann::json expected = nlohmann::json::parse(worn);
    for (const char* list : {"joints", "forces"})
        for (std::size_t i = 0; i < expected[list].size(); ++i) {
            auto item = expected[list][i];
            const std::string name = item["name"];
            if (name == "R") {
                item["clearance"]["radial"] = 1e-4;
                item["clearance"]["strips"] = 5;
                item["clearance"]["friction"]["mu_k"] = 0.25;
            } else if (name == "C") {
                item["clearance"]["profile"][2] = 1e-4;
                item["stops"]["slide"]["upper"] = 1e-4;
                item.erase("bushing");
            } else if (name == "F") {
                item["friction"]["normal_force"] = 5;
            }
            nlohmann::json found = nlohmann::json::parse(written[list][i].dump());
            if (name == "C")
                found.erase("bushing"); // written with all its defaults
            EXPECT_EQ(found, item) << found.dump(1);
        }
    EXPECT_EQ(written["onset"], nlohmann::ordered_json({{"energy", 1e-7}}));
    const std::string text = write_model(model());
    EXPECT_EQ(write_model(parse_model(text, "written")), text);
}

TEST(WriterContact, MixedJointsOverAnotherFidelity) {
    // What is not listed in a file is perfect, so every motion that is held is written.
    Model m = model();
    Joint& j = m.joints[0];
    j.bushing = Bushing{};
    j.fidelity = Fidelity::bushing;
    j.motions[0] = Fidelity::clearance;
    j.clearance->axial.reset();
    j.clearance->axial_law.reset();
    j.clearance->friction->radius.reset(); // no end faces left
    const Model back = parse_model(write_model(m), "written");
    EXPECT_EQ(back.joints[0].holds(Motion::radial), Fidelity::clearance);
    EXPECT_EQ(back.joints[0].holds(Motion::axial), Fidelity::bushing);
    EXPECT_EQ(back.joints[0].holds(Motion::misalignment), Fidelity::bushing);
    EXPECT_FALSE(back.joints[0].motions[3]);
}

} // namespace
} // namespace gudgeon
