// Open chains: pendulum, chain, heavy-top, triple-pendulum.
#include "models/builders.hpp"

#include <fmt/format.h>

namespace gudgeon {

namespace {

Model build_pendulum(const ParameterValues&) {
    Model model;
    const Vec3 start(-1, 0, 0);
    model.bodies.push_back(make_body("bob", 1, Vec3::Constant(0.01), start));
    for (const auto& [name, kind] : {std::pair("rod", JointKind::distance), {"plane", JointKind::planar}}) {
        Joint joint = make_joint(name, kind, "ground", "bob", start);
        joint.points[0] = Vec3::Zero();
        if (kind == JointKind::planar)
            joint.axes = {Vec3::UnitY(), Vec3::UnitY()};
        model.joints.push_back(joint);
    }
    return model;
}

Model build_chain(const ParameterValues& values) {
    Model model;
    const int links = values.integer("links");
    // The thin rod of the reference solutions, or the round bar whose Ixx is the given 5e-5.
    const double transverse = values.word("thin") == "1" ? 1.0 / 12 : (1 + 3e-4) / 12;
    const std::string& kind = values.word("joint");
    std::string previous = "ground";
    for (int k = 1; k <= links; ++k) {
        const std::string link = fmt::format("link{}", k), name = fmt::format("J{}", k);
        const Vec3 point(k - 1, 0, 0);
        model.bodies.push_back(make_bar(link, transverse, {k - 0.5, 0, 0}));
        if (kind == "spherical") {
            model.joints.push_back(make_joint(name, JointKind::spherical, previous, link, point));
        } else if (kind == "universal") {
            Joint joint = make_joint(name, JointKind::universal, previous, link, point);
            joint.axes = {Vec3::UnitY(), Vec3::UnitZ()};
            model.joints.push_back(joint);
        } else {
            model.joints.push_back(
                make_joint(name, JointKind::revolute, previous, link, point, Vec3::UnitY()));
        }
        previous = link;
    }
    model.markers.push_back(make_marker("tip", previous, {static_cast<double>(links), 0, 0}));
    return model;
}

Model build_heavy_top(const ParameterValues& values) {
    const double iperp = values.number("iperp"), iaxial = values.number("iaxial");
    if (iaxial > 2 * iperp * (1 + 1e-12))
        throw ModelError("heavy-top", "/parameters/iaxial",
                         fmt::format("iaxial = {} with iperp = {} belongs to no body", iaxial, iperp),
                         "at most twice iperp");
    Model model;
    const double tilt = values.number("tilt");
    const Vec3 axis(std::sin(tilt), 0, std::cos(tilt));
    Body top =
        make_body("top", values.number("mass"), {iperp, iperp, iaxial}, values.number("length") * axis);
    top.orientation = {std::cos(tilt / 2), 0, std::sin(tilt / 2), 0};
    // Spinning about the line through the fixed point: the mass centre is at rest.
    top.angular_velocity = {0, 0, values.number("spin")};
    model.bodies.push_back(top);
    model.joints.push_back(make_joint("O", JointKind::spherical, "ground", "top", Vec3::Zero()));
    return model;
}

/// Limits of a free coordinate both ways, with one of the two laws of AP 3.2.
Stop stop_at(double limit, double stiffness, const ParameterValues& values) {
    Stop stop;
    stop.lower = -limit;
    stop.upper = limit;
    if (values.word("law") == "kelvin-voigt") {
        stop.law.kind = "kelvin-voigt";
        stop.law.stiffness = stiffness;
        stop.law.restitution = values.number("restitution");
        stop.law.speed = values.number("speed");
    } else {
        stop.law = lankarani_nikravesh(stiffness, values.number("restitution"));
    }
    return stop;
}

Model build_triple_pendulum(const ParameterValues& values) {
    Model model;
    // AP Table 3; the printed e1 = -0.383 is a turn of -45 degrees about X.
    model.bodies = {make_body("body1", 0.10, {3e-3, 3e-2, 3e-2}, {0.3, 0, 0}),
                    make_body("body2", 0.04, {1.2e-3, 1.2e-2, 1.2e-2}, {0.9, 0, 0}),
                    make_body("body3", 0.02, {0.6e-3, 0.6e-2, 0.6e-2}, {1.5, 0, 0})};
    model.bodies[2].orientation = {std::cos(pi / 8), -std::sin(pi / 8), 0, 0};
    const double s = std::sqrt(0.5);
    model.joints = {
        make_joint("J1", JointKind::revolute, "ground", "body1", {0, 0, 0}, Vec3::UnitY()),
        make_joint("J2", JointKind::cylindrical, "body1", "body2", {0.6, 0, 0}, Vec3::UnitZ()),
        make_joint("J3", JointKind::revolute, "body2", "body3", {1.2, 0, 0}, {0, s, s}),
    };
    if (values.word("stops") == "1") {
        model.joints[1].stops["slide"] = stop_at(0.25, 1e5, values);
        model.joints[2].stops["angle"] = stop_at(pi / 4, 1e3, values);
    }
    return model;
}

} // namespace

Mechanism pendulum() {
    return {"pendulum", "1 kg at 1 m from the origin in the plane y = 0, from rest at (-1, 0, 0)",
            {},         10,
            0.01,       &build_pendulum};
}

Mechanism chain() {
    return {"chain",
            "bars of 1 m and 1 kg hanging on the origin, from rest along +X",
            {count_parameter("links", "10", "number of bars", 1e6),
             choice_parameter("joint", {"revolute", "spherical", "universal"},
                              "joints: revolute about Y, spherical, universal (Y then Z)"),
             choice_parameter("thin", {"0", "1"}, "1: Iyy = Izz = 1/12 kg m2 (thin rods)")},
            1,
            0.01,
            &build_chain};
}

Mechanism heavy_top() {
    return {
        "heavy-top",
        "symmetric top turning about the origin, symmetry axis body z",
        {number_parameter("mass", "1", "kg", "mass", 1e-9, 1e9),
         number_parameter("length", "0.3", "m", "origin to mass centre", 0, 1e6),
         number_parameter("iperp", "0.02", "kg m2", "transverse inertia about the mass centre", 1e-12, 1e12),
         number_parameter("iaxial", "0.01", "kg m2", "inertia about the symmetry axis", 1e-12, 1e12),
         number_parameter("tilt", "1.0471975511965976", "rad", "angle from +Z, about +Y", -pi, pi),
         number_parameter("spin", "40", "rad/s", "speed about the symmetry axis", -1e6, 1e6)},
        2,
        0.01,
        &build_heavy_top};
}

Mechanism triple_pendulum() {
    MechanismParameter restitution = restitution_parameter("0.75");
    restitution.default_with = {{"kelvin-voigt", "0.01"}};
    restitution.help += "; 0.01 with law=kelvin-voigt";
    return {
        "triple-pendulum",
        "three bodies on a revolute, a cylindrical and a revolute joint (Ambrosio & Pombo 2018, 3.2)",
        {choice_parameter("stops", {"1", "0"}, "1: J2 stops after 0.25 m, J3 after 45 degrees, both ways"),
         choice_parameter("law", {"lankarani-nikravesh", "kelvin-voigt"}, "normal law of the stops"),
         restitution,
         number_parameter("speed", "0.1", "m/s, rad/s", "transition of the law kelvin-voigt", 1e-9, 1e3)},
        4,
        0.01,
        &build_triple_pendulum};
}

} // namespace gudgeon
