// Chain of double-wishbone suspension units with rubber bushings.
#include "models/builders.hpp"

#include <fmt/format.h>

#include <tuple>

namespace gudgeon {

namespace {

constexpr double gravity = 9.81; // m/s2, in the tyre's static load

Bushing arm_bushing() {
    Bushing bushing;
    bushing.stiffness = {5e6, 5e6, 5e6, 100, 1e4, 1e4};
    bushing.damping = {1e3, 1e3, 1e3, 1, 10, 10};
    bushing.global_axes = true;
    return bushing;
}

Joint unit_link(int k) {
    Joint link = make_joint(fmt::format("link{}", k), JointKind::rigid, fmt::format("chassis{}", k - 1),
                            fmt::format("chassis{}", k), {1.0 - 2 * k, 0, 0.28});
    link.fidelity = Fidelity::bushing;
    link.bushing = Bushing{};
    link.bushing->stiffness = {1e6, 1e6, 1e6, 1e5, 1e5, 1e5};
    link.bushing->damping = {2e3, 2e3, 2e3, 5e2, 5e2, 5e2};
    return link;
}

SpringDamper point_spring(const std::string& name, const std::string& a, const std::string& b,
                          const Vec3& point_a, const Vec3& point_b) {
    SpringDamper spring;
    spring.name = name;
    spring.bodies = {a, b};
    spring.points = {point_a, point_b};
    return spring;
}

struct ArmJoints {
    Fidelity lower, upper;
    Clearance bearing; // where one of them has clearance
    bool perfect() const { return lower == Fidelity::perfect; }
};

ArmJoints arm_joints(const ParameterValues& values) {
    const std::string& word = values.word("joints");
    if (word == "perfect")
        return {Fidelity::perfect, Fidelity::perfect, {}};
    const double play = values.number("clearance");
    ArmJoints arms{word == "clearance" ? Fidelity::clearance : Fidelity::bushing,
                   word == "bushing" ? Fidelity::bushing : Fidelity::clearance,
                   strip_bearing(0.006, 0.04, play, values.integer("strips"), lankarani_nikravesh(1e9, 0.8))};
    arms.bearing.axial = play;
    return arms;
}

/// side: +1 left, -1 right.
void add_corner(Model& model, int unit, int side, const ArmJoints& arms) {
    const std::string tag = fmt::format("{}{}", unit, side > 0 ? 'L' : 'R');
    const std::string chassis = fmt::format("chassis{}", unit), lower = "lower" + tag, upper = "upper" + tag,
                      upright = "upright" + tag;
    const auto at = [&](double x, double y, double z) { return Vec3(x - 2.0 * unit, y * side, z); };

    model.bodies.push_back(make_body(lower, 5, {0.06, 0.03, 0.08}, at(0, 0.575, 0.21)));
    model.bodies.push_back(make_body(upper, 4, {0.025, 0.02, 0.04}, at(-0.02, 0.575, 0.47)));
    model.bodies.push_back(make_body(upright, 30, {0.8, 1.2, 0.8}, at(0, 0.80, 0.34)));

    for (auto [name, arm, point, fidelity] :
         {std::tuple("LI" + tag, lower, at(0, 0.40, 0.22), arms.lower),
          std::tuple("UI" + tag, upper, at(-0.02, 0.45, 0.46), arms.upper)}) {
        Joint inner = make_joint(name, JointKind::revolute, chassis, arm, point, Vec3::UnitX());
        inner.fidelity = fidelity;
        if (fidelity == Fidelity::bushing)
            inner.bushing = arm_bushing();
        else if (fidelity == Fidelity::clearance)
            inner.clearance = arms.bearing;
        model.joints.push_back(inner);
    }
    model.joints.push_back(make_joint("LO" + tag, JointKind::spherical, lower, upright, at(0, 0.75, 0.20)));
    model.joints.push_back(
        make_joint("UO" + tag, JointKind::spherical, upper, upright, at(-0.02, 0.70, 0.48)));

    const Vec3 tie_in = at(0.15, 0.42, 0.26), tie_out = at(0.15, 0.74, 0.25);
    if (arms.perfect()) {
        Joint tie = make_joint("tie" + tag, JointKind::distance, chassis, upright, tie_in);
        tie.points[1] = tie_out;
        model.joints.push_back(tie);
    } else {
        SpringDamper tie = point_spring("tie" + tag, chassis, upright, tie_in, tie_out);
        tie.stiffness = 2e7;
        tie.damping = 1e3;
        tie.free_length = (tie_out - tie_in).norm();
        model.forces.push_back(tie);
    }

    const Vec3 coil_top = at(0, 0.50, 0.62), coil_bottom = at(0, 0.62, 0.212);
    SpringDamper coil = point_spring("coil" + tag, chassis, lower, coil_top, coil_bottom);
    coil.stiffness = 3e4;
    coil.damping = 3e3;
    coil.free_length = (coil_top - coil_bottom).norm() + 3400 / coil.stiffness;
    model.forces.push_back(coil);

    Tyre tyre;
    tyre.name = "tyre" + tag;
    tyre.body = upright;
    tyre.point = at(0, 0.80, 0.34);
    tyre.stiffness = 2e5;
    tyre.damping = 200;
    tyre.preload = 239 * gravity;
    tyre.reference = 0.34;
    tyre.road = HarmonicFunction{0.02, 2, -0.5 * unit, 0};
    model.forces.push_back(tyre);
}

/// Torsion bar across the unit behind the arms, on two bushings of the chassis; its ends are levers, tied to
/// the lower arms by upright links.
void add_antiroll_bar(Model& model, int unit, bool perfect) {
    constexpr double lever = 0.25, half_width = 0.55, mount = 0.50, height = 0.31, pickup = 0.2114;
    const std::string bar = fmt::format("bar{}", unit), chassis = fmt::format("chassis{}", unit);
    const double x = -2.0 * unit;
    Beam beam;
    beam.name = bar;
    beam.points = {Vec3(x - lever, half_width, height), Vec3(x - lever, -half_width, height)};
    beam.direction = Vec3::UnitX();
    beam.section = RoundSection{0.02};
    beam.material = {2.1e11, 0.3, 7850, 0.02, {}};
    beam.elements = 4;
    model.beams.push_back(beam);
    for (const auto& [side, end, letter] : {std::tuple(1, ".start", 'L'), std::tuple(-1, ".end", 'R')}) {
        const std::string tag = fmt::format("{}{}", unit, letter);
        Joint rubber = make_joint("mount" + tag, JointKind::revolute, chassis, bar + end,
                                  {x - lever, side * mount, height}, Vec3::UnitY());
        rubber.fidelity = Fidelity::bushing;
        rubber.bushing = Bushing{};
        rubber.bushing->stiffness = {5e6, 5e6, 5e6, 100, 100, 0}; // free about the bar
        rubber.bushing->damping = {1e3, 1e3, 1e3, 1, 1, 0};
        model.joints.push_back(rubber);
        const Vec3 top(x, side * half_width, height), bottom(x, side * half_width, pickup);
        if (perfect) {
            Joint link = make_joint("drop" + tag, JointKind::distance, bar + end, "lower" + tag, top);
            link.points[1] = bottom;
            model.joints.push_back(link);
        } else {
            SpringDamper link = point_spring("drop" + tag, bar + end, "lower" + tag, top, bottom);
            link.stiffness = 2e7;
            link.damping = 1e3;
            model.forces.push_back(link);
        }
    }
}

Model build_suspension_chain(const ParameterValues& values) {
    Model model;
    const ArmJoints arms = arm_joints(values);
    const int units = values.integer("units");
    for (int k = 0; k < units; ++k) {
        model.bodies.push_back(
            make_body(fmt::format("chassis{}", k), 400, {40, 200, 220}, {-2.0 * k, 0, 0.28}));
        if (k > 0)
            model.joints.push_back(unit_link(k));
        add_corner(model, k, +1, arms);
        add_corner(model, k, -1, arms);
        if (values.integer("antiroll") == 1)
            add_antiroll_bar(model, k, arms.perfect());
    }
    return model;
}

} // namespace

Mechanism suspension_chain() {
    return {"suspension-chain",
            "double-wishbone suspension units on a wavy road, joined by bushings",
            {count_parameter("units", "1", "number of units of 7 bodies", 1e5),
             choice_parameter("joints", {"bushing", "perfect", "clearance", "mixed"},
                              "inner joints of the arms: bushings, perfect revolutes (and rigid tie rods), "
                              "bearings with clearance, bushings below and bearings above"),
             number_parameter("clearance", "1e-4", "m", "radial and axial, of the bearings", 0, 5e-3),
             count_parameter("strips", "16", "strips of each bearing", 1e6),
             choice_parameter("antiroll", {"0", "1"},
                              "1: a torsion bar, a flexible beam, between the lower arms of each unit")},
            5,
            0.05,
            &build_suspension_chain};
}

} // namespace gudgeon
