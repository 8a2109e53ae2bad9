#include "models/builders.hpp"

namespace gudgeon {

Body make_body(const std::string& name, double mass, const Vec3& inertia, const Vec3& position) {
    Body body;
    body.name = name;
    body.mass = mass;
    body.inertia = inertia.asDiagonal();
    body.position = position;
    return body;
}

Body make_bar(const std::string& name, double transverse, const Vec3& position) {
    return make_body(name, 1, {5e-5, transverse, transverse}, position);
}

Joint make_joint(const std::string& name, JointKind kind, const std::string& a, const std::string& b,
                 const Vec3& point) {
    Joint joint;
    joint.name = name;
    joint.kind = kind;
    joint.bodies = {a, b};
    joint.points = {point, point};
    return joint;
}

Joint make_joint(const std::string& name, JointKind kind, const std::string& a, const std::string& b,
                 const Vec3& point, const Vec3& axis) {
    Joint joint = make_joint(name, kind, a, b, point);
    joint.axes = {axis, axis};
    return joint;
}

ContactLaw lankarani_nikravesh(double stiffness, double restitution) {
    ContactLaw law;
    law.kind = "lankarani-nikravesh";
    law.stiffness = stiffness;
    law.exponent = 1.5;
    law.restitution = restitution;
    return law;
}

ContactLaw steel_cylinders(double restitution) {
    ContactLaw law;
    law.kind = "cylinder";
    law.materials = {Material{207e9, 0.3}, Material{207e9, 0.3}};
    law.restitution = restitution;
    return law;
}

Clearance strip_bearing(double radius, double length, double radial, int strips, const ContactLaw& law) {
    Clearance clearance;
    clearance.radius = radius;
    clearance.length = length;
    clearance.radial = radial;
    clearance.strips = strips;
    clearance.law = law;
    return clearance;
}

Marker make_marker(const std::string& name, const std::string& body, const Vec3& point) {
    Marker marker;
    marker.name = name;
    marker.body = body;
    marker.point = point;
    return marker;
}

Vec4 euler_parameters(const Mat3& axes) {
    const Eigen::Quaterniond q(axes);
    const Vec4 p(q.w(), q.x(), q.y(), q.z());
    return (p[0] < 0 ? -p : p).normalized();
}

MechanismParameter number_parameter(const std::string& name, const std::string& default_value,
                                    const std::string& unit, const std::string& help, double minimum,
                                    double maximum) {
    return {name, default_value, {}, unit, help, false, minimum, maximum, {}};
}

MechanismParameter restitution_parameter(const std::string& default_value) {
    return number_parameter("restitution", default_value, "", "restitution put into the law", 1e-6, 1);
}

MechanismParameter count_parameter(const std::string& name, const std::string& default_value,
                                   const std::string& help, double maximum) {
    return {name, default_value, {}, "", help, true, 1, maximum, {}};
}

MechanismParameter choice_parameter(const std::string& name, const std::vector<std::string>& choices,
                                    const std::string& help) {
    return {name, choices.front(), choices, "", help, false, 0, 0, {}};
}

} // namespace gudgeon
