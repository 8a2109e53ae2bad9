// A free journal in a fixed bearing: bouncing-journal, tilted-journal.
#include "models/builders.hpp"

#include <fmt/format.h>

namespace gudgeon {

namespace {

const char* const law_names[] = {"lankarani-nikravesh", "cylinder"};

MechanismParameter law_parameter() {
    return choice_parameter("law", {law_names[0], law_names[1]},
                            "normal law: Lankarani-Nikravesh, or the cylinder law with steel");
}

ContactLaw law_of(const ParameterValues& values, double stiffness) {
    const double restitution = values.number("restitution");
    return values.word("law") == "cylinder" ? steel_cylinders(restitution)
                                            : lankarani_nikravesh(stiffness, restitution);
}

/// Bearing on the ground along X at the origin; the journal's axis as given, global.
Joint bearing(const Clearance& clearance, const Vec3& journal_axis) {
    Joint joint = make_joint("bearing", JointKind::cylindrical, "ground", "journal", Vec3::Zero());
    joint.axes = {Vec3::UnitX(), journal_axis};
    joint.fidelity = Fidelity::clearance;
    joint.clearance = clearance;
    return joint;
}

Model build_bouncing_journal(const ParameterValues& values) {
    Model model;
    model.bodies.push_back(make_body("journal", 1, {1e-4, 1e-3, 1e-3}, Vec3::Zero()));
    model.joints.push_back(bearing(strip_bearing(0.011, 0.02, 1e-3, 8, law_of(values, 5e6)), Vec3::UnitX()));
    return model;
}

/// Turned by `tilt` about the global axis (0, ty, tz), after the turn that lays body z on X.
Vec4 tilted_pose(const ParameterValues& values) {
    const double tilt = values.number("tilt");
    const Vec3 axis(0, values.number("ty"), values.number("tz"));
    const double length = axis.norm();
    if (length == 0 && tilt != 0)
        throw ModelError("tilted-journal", "/parameters/ty",
                         fmt::format("a tilt of {} rad about an axis of no direction", tilt),
                         "ty and tz not both 0, or tilt 0");
    const Vec3 s = length > 0 ? Vec3(std::sin(tilt / 2) / length * axis) : Vec3::Zero();
    const Eigen::Quaterniond turn(std::cos(tilt / 2), s.x(), s.y(), s.z());
    const Eigen::Quaterniond q = turn * Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5);
    const Vec4 p(q.w(), q.x(), q.y(), q.z());
    return (p[0] < 0 ? -p : p).normalized();
}

Model build_tilted_journal(const ParameterValues& values) {
    const auto vector = [&](const char* x, const char* y, const char* z) {
        return Vec3(values.number(x), values.number(y), values.number(z));
    };
    Model model;
    Body journal = make_body("journal", 1, {4e-3, 4e-3, 2e-4}, Vec3::Zero());
    journal.orientation = tilted_pose(values);
    journal.velocity = vector("vx", "vy", "vz");
    journal.angular_velocity = vector("wx", "wy", "wz");
    model.bodies.push_back(journal);
    const Clearance clearance =
        strip_bearing(0.01, 0.04, values.number("clearance"), values.integer("strips"),
                      law_of(values, values.number("stiffness")));
    model.joints.push_back(bearing(clearance, rotation(journal.orientation) * Vec3::UnitZ()));
    return model;
}

} // namespace

Mechanism bouncing_journal() {
    return {"bouncing-journal",
            "journal of 1 kg bouncing in a fixed bearing along X, radial clearance 1 mm, from rest",
            {law_parameter(), restitution_parameter("0.75")},
            1,
            0.01,
            &build_bouncing_journal};
}

Mechanism tilted_journal() {
    const auto speed = [](const char* name, const char* value, const char* unit, const char* help) {
        return number_parameter(name, value, unit, help, -1e6, 1e6);
    };
    return {
        "tilted-journal",
        "spinning journal of 1 kg bouncing and tilting in a fixed bearing along X",
        {number_parameter("clearance", "5e-4", "m", "radial clearance", 0, 9e-3),
         count_parameter("strips", "16", "strips of the bearing", 1e6), law_parameter(),
         number_parameter("stiffness", "1e8", "N/m^1.5", "Lankarani-Nikravesh, whole joint", 1, 1e15),
         restitution_parameter("0.8"),
         number_parameter("tilt", "0.017453292519943295", "rad", "tilt about the axis (0, ty, tz)", -pi, pi),
         speed("ty", "1", "", "axis of the tilt"), speed("tz", "0", "", "axis of the tilt"),
         speed("vx", "0.01", "m/s", "velocity, global"), speed("vy", "0.03", "m/s", "velocity, global"),
         speed("vz", "0", "m/s", "velocity, global"),
         speed("wx", "0.4", "rad/s", "angular velocity, body axes"),
         speed("wy", "0.3", "rad/s", "angular velocity, body axes"),
         speed("wz", "50", "rad/s", "angular velocity, body axes: spin")},
        0.2,
        1e-3,
        &build_tilted_journal};
}

} // namespace gudgeon
