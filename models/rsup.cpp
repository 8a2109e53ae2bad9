// Spatial linkage of revolute, spherical, universal and prismatic joints (Augustynek & Urbas 2018, 3-5).
#include "core/beam.hpp"
#include "models/builders.hpp"

#include <utility>

namespace gudgeon {

namespace {

// AU 5: the slider stands at 0.25 m, the coupler is turned by -pi/3 about the crank's x axis, the crank by
// pi/2.
constexpr double slide = 0.25, crank_length = 0.08;              // m
const double coupler_length = 2 * slide / std::sqrt(3.0);        // from -pi/3
const double guide_height = crank_length - coupler_length / 2;   // of the slider below the crank's axis
constexpr double torque = 10, rise = 2, speed = 9;               // N m, s, rad/s: AU 5
constexpr double bearing_radius = 0.005, journal_radius = 0.004; // m, AU Table 1
constexpr double bearing_length = 0.02;                          // m

Beam coupler_beam() {
    Beam beam;
    beam.name = "coupler";
    beam.points = {Vec3(0, 0, crank_length), Vec3(slide, 0, guide_height)};
    beam.direction = Vec3::UnitY();
    beam.section = RoundSection{0.01};
    beam.material = {2.1e11, 0.3, 7850, 0.02, {}};
    beam.elements = 4; // five rigid elements
    return beam;
}

/// The beam as one rigid body.
Body rigid_coupler(const Beam& beam) {
    const SectionProperties s = section_properties(beam.section, beam.material.poisson);
    const double line = beam.material.density * coupler_length, mass = line * s.area;
    const double slender = mass * coupler_length * coupler_length / 12;
    Body body =
        make_body(beam.name, mass, {line * (s.iy + s.iz), line * s.iy + slender, line * s.iz + slender},
                  (beam.points[0] + beam.points[1]) / 2);
    body.orientation = euler_parameters(beam_axes(beam));
    return body;
}

Friction bristles() { // AU Table 1
    Friction friction;
    friction.kind = "lugre";
    friction.statics = 0.2;
    friction.kinetic = 0.1;
    friction.speed = 0.0175;
    friction.sigma0 = 600;
    friction.sigma1 = std::sqrt(600.0);
    return friction;
}

/// The cut joint of AU: planar, axes parallel and no axial play; spatial, axes may skew, both ends touch.
void loosen(Joint& joint, const ParameterValues& values) {
    const std::string& word = values.word("joint");
    if (word == "perfect")
        return;
    joint.motions[static_cast<std::size_t>(Motion::radial)] = Fidelity::clearance;
    Clearance play;
    play.model = word == "spatial" ? "two-end" : "planar";
    play.radial = bearing_radius - journal_radius;
    play.radius = bearing_radius;
    play.law = lankarani_nikravesh(values.number("stiffness"), values.number("restitution"));
    if (word == "spatial") {
        joint.motions[static_cast<std::size_t>(Motion::misalignment)] = Fidelity::clearance;
        play.length = bearing_length;
    }
    if (values.integer("friction") == 1)
        play.friction = bristles();
    joint.clearance = play;
}

/// Driving torque, and a resistance proportional to the speed that balances it at 9 rad/s.
void drive(Model& model) {
    AppliedForce driving;
    driving.name = "driving";
    driving.body = "crank";
    driving.torque = true;
    driving.vector = Vec3::UnitX();
    driving.time = SmoothStepFunction{0, rise, 0, torque};
    TorsionSpring resistance;
    resistance.name = "resistance";
    resistance.joint = "R";
    resistance.damping = torque / speed;
    model.forces = {driving, resistance};
}

Model build_rsup(const ParameterValues& values) {
    Model model;
    const Vec3 pin(0, 0, crank_length), end(slide, 0, guide_height);
    model.bodies = {make_body("crank", 0.2, {0.2 * crank_length * crank_length / 12, 1.2e-4, 2e-5}, pin / 2),
                    make_body("slider", 5, Vec3::Constant(5e-3), end),
                    make_body("cross", 0.05, Vec3::Constant(1e-5), end)};
    const Beam beam = coupler_beam();
    const bool flexible = values.word("coupler") == "flexible";
    if (flexible)
        model.beams = {beam};
    else
        model.bodies.push_back(rigid_coupler(beam));
    const std::string first = flexible ? "coupler.start" : "coupler",
                      last = flexible ? "coupler.end" : "coupler";
    Joint cut = make_joint("U2", JointKind::revolute, "cross", last, end, Vec3::UnitY());
    loosen(cut, values);
    model.joints = {make_joint("R", JointKind::revolute, "ground", "crank", Vec3::Zero(), Vec3::UnitX()),
                    make_joint("S", JointKind::spherical, "crank", first, pin),
                    make_joint("P", JointKind::translation, "ground", "slider", end, Vec3::UnitX()),
                    make_joint("U1", JointKind::revolute, "slider", "cross", end, Vec3::UnitX()),
                    std::move(cut)};
    drive(model);
    return model;
}

} // namespace

Mechanism rsup() {
    return {
        "rsup",
        "crank, coupler and slider on revolute, spherical, universal and prismatic joints (Augustynek & "
        "Urbas 2018, 5)",
        {choice_parameter("coupler", {"rigid", "flexible"},
                          "one rigid body, or a beam of five rigid elements"),
         choice_parameter("joint", {"perfect", "planar", "spatial"},
                          "U2, where the coupler turns in the cross: perfect, or 1 mm of radial clearance"),
         choice_parameter("friction", {"0", "1"}, "1: LuGre friction in the clearance"),
         number_parameter("stiffness", "2e10", "N/m^1.5", "Lankarani-Nikravesh, whole joint", 1, 1e15),
         restitution_parameter("0.9")},
        5,
        0.001,
        &build_rsup};
}

} // namespace gudgeon
