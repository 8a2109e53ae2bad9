#include "core/reader_parts.hpp"

#include <fmt/format.h>

namespace gudgeon {

namespace {

void refuse_both(const JsonInput& in, const char* one, const char* other) {
    if (in.has(one) && in.has(other))
        in.at(other).refuse(fmt::format("'{}' beside '{}'", other, one), "one of the two");
}

/// "stiffness" or "table": one of them describes the spring; neither leaves a damper.
void read_spring(const JsonInput& in, double& stiffness, double& damping, Table& table) {
    refuse_both(in, "stiffness", "table");
    stiffness = in.number("stiffness", 0);
    damping = in.number("damping", 0);
    if (in.has("table"))
        table = read_table(in.at("table"));
}

SpringDamper read_spring_damper(const JsonInput& in) {
    in.expect_keys({"name", "kind", "bodies", "frame", "points", "stiffness", "damping", "free_length",
                    "preload", "table", "actuator"});
    SpringDamper force;
    force.name = in.at("name").text();
    force.bodies = read_body_pair(in);
    force.body_frame = read_body_frame(in);
    in.at("points");
    force.points = read_points(in, force.body_frame);
    read_spring(in, force.stiffness, force.damping, force.table);
    refuse_both(in, "free_length", "preload");
    if (in.has("free_length"))
        force.free_length = in.at("free_length").number();
    if (in.has("preload"))
        force.preload = in.at("preload").number();
    if (in.has("actuator"))
        force.actuator = read_time_function(in.at("actuator"));
    return force;
}

TorsionSpring read_torsion_spring(const JsonInput& in) {
    in.expect_keys({"name", "kind", "joint", "coordinate", "stiffness", "damping", "free_angle", "table"});
    TorsionSpring force;
    force.name = in.at("name").text();
    force.joint = in.at("joint").text();
    if (in.has("coordinate"))
        force.coordinate = in.at("coordinate").text();
    read_spring(in, force.stiffness, force.damping, force.table);
    force.free_angle = in.number("free_angle", 0);
    return force;
}

Tyre read_tyre(const JsonInput& in) {
    in.expect_keys({"name", "kind", "body", "point", "frame", "stiffness", "damping", "preload", "reference",
                    "road", "profile"});
    Tyre force;
    force.name = in.at("name").text();
    force.body = in.at("body").text();
    force.body_frame = read_body_frame(in);
    force.point = in.at("point").vector();
    force.stiffness = in.at("stiffness").number();
    force.damping = in.number("damping", 0);
    force.preload = in.number("preload", 0);
    if (in.has("reference"))
        force.reference = in.at("reference").number();
    if (in.has("road"))
        force.road = read_time_function(in.at("road"));
    if (in.has("profile"))
        force.profile = read_table(in.at("profile"));
    return force;
}

AppliedForce read_applied_force(const JsonInput& in, bool torque) {
    if (torque)
        in.expect_keys({"name", "kind", "body", "vector", "axes", "time"});
    else
        in.expect_keys({"name", "kind", "body", "point", "frame", "vector", "axes", "time"});
    AppliedForce force;
    force.name = in.at("name").text();
    force.body = in.at("body").text();
    force.torque = torque;
    force.follows = in.has("axes") && in.at("axes").choice({"global", "body"}) == 1;
    if (!torque) {
        force.body_frame = read_body_frame(in);
        force.point = in.at("point").vector();
    }
    force.vector = in.at("vector").vector();
    if (in.has("time"))
        force.time = read_time_function(in.at("time"));
    return force;
}

FrictionForce read_friction_force(const JsonInput& in) {
    in.expect_keys({"name", "kind", "bodies", "frame", "point", "points", "axis", "friction"});
    FrictionForce force;
    force.name = in.at("name").text();
    force.bodies = read_body_pair(in);
    force.body_frame = read_body_frame(in);
    force.points = read_points(in, force.body_frame);
    force.axis = in.at("axis").vector();
    force.friction = read_friction(in.at("friction"));
    return force;
}

} // namespace

Force read_force(const JsonInput& in) {
    if (!in.is_object())
        in.refuse(in.shown() + " is no force", "an object {\"kind\": ...}");
    switch (
        in.at("kind").choice({"spring-damper", "torsion-spring", "tyre", "force", "torque", "friction"})) {
    case 0:
        return read_spring_damper(in);
    case 1:
        return read_torsion_spring(in);
    case 2:
        return read_tyre(in);
    case 3:
        return read_applied_force(in, false);
    case 4:
        return read_applied_force(in, true);
    default:
        return read_friction_force(in);
    }
}

} // namespace gudgeon
