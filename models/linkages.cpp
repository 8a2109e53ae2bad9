// Closed loops: four-bar, slider-crank.
#include "models/builders.hpp"

#include <fmt/format.h>

namespace gudgeon {

namespace {

Body upright_crank(int k) {
    const Vec3 up(0, 0, 1);
    Body crank = make_bar(fmt::format("crank{}", k), 1.0 / 12, {static_cast<double>(k), 0, 0.5});
    crank.orientation = {std::sqrt(0.5), 0, -std::sqrt(0.5), 0}; // body x up, body y = Y
    crank.angular_velocity = {0, 1, 0};
    crank.velocity = Vec3::UnitY().cross(0.5 * up);
    return crank;
}

Model build_four_bar(const ParameterValues& values) {
    Model model;
    const int loops = values.integer("loops");
    const Vec3 y = Vec3::UnitY();
    for (int k = 0; k <= loops; ++k) {
        const std::string crank = fmt::format("crank{}", k);
        const Vec3 foot(k, 0, 0), top(k, 0, 1);
        model.bodies.push_back(upright_crank(k));
        model.joints.push_back(
            make_joint(fmt::format("A{}", k), JointKind::revolute, "ground", crank, foot, y));
        model.markers.push_back(make_marker(fmt::format("top{}", k), crank, top));
        if (k == 0)
            continue;
        const std::string coupler = fmt::format("coupler{}", k), left = fmt::format("crank{}", k - 1);
        Body bar = make_bar(coupler, 1.0 / 12, {k - 0.5, 0, 1});
        bar.velocity = {1, 0, 0}; // parallelogram: it translates with the tops
        model.bodies.push_back(bar);
        model.joints.push_back(
            make_joint(fmt::format("B{}", k - 1), JointKind::revolute, left, coupler, {k - 1.0, 0, 1}, y));
        model.joints.push_back(
            make_joint(fmt::format("C{}", k), JointKind::revolute, coupler, crank, top, y));
    }
    return model;
}

/// Gives one joint its clearance: the ball B, or the bearing A, whose end faces have the same play.
void loosen(Model& model, const ParameterValues& values) {
    const std::string& loose = values.word("joint");
    if (loose == "perfect")
        return;
    const ContactLaw law = lankarani_nikravesh(values.number("stiffness"), values.number("restitution"));
    const double play = values.number("clearance");
    Joint& joint = model.joints[loose == "revolute" ? 0 : 1];
    joint.fidelity = Fidelity::clearance;
    if (loose == "revolute") {
        joint.clearance = strip_bearing(0.01, values.number("length"), play, values.integer("strips"), law);
        joint.clearance->axial = play;
    } else {
        joint.clearance = Clearance{};
        joint.clearance->radial = play;
        joint.clearance->law = law;
    }
}

/// Exact state behind the rounded Table 2 of AP: the rod's axes are (2,-1,-2)/3, (0,2,-1)/sqrt 5
/// and their cross product; its angular velocity follows from the speeds of both ends and from the
/// universal joint (slider side Z, rod side 0.8 eta + 0.6 zeta = (1,2,0)/sqrt 5).
Model build_slider_crank(const ParameterValues& values) {
    Model model;
    const Vec3 point_a(0, 0.1, 0.12), point_b(0, 0.1, 0.2), point_c(0.2, 0, 0);
    Mat3 axes;
    axes.col(0) = Vec3(2, -1, -2) / 3;
    axes.col(1) = Vec3(0, 2, -1) / std::sqrt(5.0);
    axes.col(2) = axes.col(0).cross(axes.col(1));

    Body crank = make_body("crank", 0.12, {1e-4, 1e-4, 1e-5}, (point_a + point_b) / 2);
    crank.velocity = {0, -0.24, 0};
    crank.angular_velocity = {6, 0, 0};
    Body rod = make_body("rod", 0.5, {4e-4, 4e-3, 4e-3}, (point_b + point_c) / 2);
    rod.orientation = euler_parameters(axes);
    rod.velocity = {0.12, -0.24, 0};
    rod.angular_velocity = {-1.6, -2.4 / std::sqrt(5.0), 3.2 / std::sqrt(5.0)};
    Body slider = make_body("slider", 2, Vec3::Constant(1e-4), point_c);
    slider.velocity = {0.24, 0, 0};
    model.bodies = {crank, rod, slider};

    Joint universal = make_joint("C", JointKind::universal, "slider", "rod", point_c);
    universal.axes = {Vec3::UnitZ(), Vec3(1, 2, 0) / std::sqrt(5.0)};
    model.joints = {
        make_joint("A", JointKind::revolute, "ground", "crank", point_a, Vec3::UnitX()),
        make_joint("B", JointKind::spherical, "crank", "rod", point_b),
        universal,
        make_joint("D", JointKind::translation, "ground", "slider", point_c, Vec3::UnitX()),
    };
    loosen(model, values);
    return model;
}

} // namespace

Mechanism four_bar() {
    return {"four-bar",
            "parallelograms of bars of 1 m and 1 kg in the plane x-z, upright, turning at 1 rad/s about +Y",
            {count_parameter("loops", "1", "number of closed loops", 1e6)},
            10,
            0.01,
            &build_four_bar};
}

Mechanism slider_crank() {
    MechanismParameter stiffness = number_parameter(
        "stiffness", "5e6", "N/m^1.5", "Lankarani-Nikravesh, whole joint; 5e7 with joint=revolute", 1, 1e15);
    stiffness.default_with = {{"revolute", "5e7"}};
    return {"slider-crank",
            "spatial slider-crank started at 6 rad/s (Ambrosio & Pombo 2018, 3.1)",
            {choice_parameter("joint", {"perfect", "spherical", "revolute"},
                              "clearance: none, ball of B in its socket, bearing A of the crank"),
             number_parameter("clearance", "1e-4", "m", "radial clearance, of A the axial one too", 0, 1),
             restitution_parameter("0.75"), stiffness,
             number_parameter("length", "0.04", "m", "length of the bearing (revolute)", 1e-6, 10),
             count_parameter("strips", "8", "strips of the bearing (revolute)", 1e6)},
            5,
            0.01,
            &build_slider_crank};
}

} // namespace gudgeon
