#include "bench/hard_cases/singular_models.hpp"

#include "models/builders.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon::hard {

namespace {

Vec4 about_y(double angle) { return {std::cos(angle / 2), 0, std::sin(angle / 2), 0}; }

} // namespace

Model equal_bars(double angle, double rate, bool in_space) {
    const double c = std::cos(angle), s = std::sin(angle);
    const Vec3 top(c, 0, s), end(2 * c, 0, 0), bar(5e-5, 1.0 / 12, 1.0 / 12);
    Model model;
    model.name = "equal-bars";
    model.bodies = {make_body("crank", 1, bar, top / 2), make_body("rod", 1, bar, (top + end) / 2),
                    make_body("slider", 1, Vec3::Constant(0.01), end)};
    const Vec3 velocity[]{Vec3(-s, 0, c) * rate / 2, Vec3(-3 * s, 0, c) * rate / 2,
                          Vec3(-2 * s * rate, 0, 0)};
    for (int i = 0; i < 3; ++i) {
        const double turn = i == 0 ? -1 : i == 1 ? 1 : 0; // about +Y
        model.bodies[i].velocity = velocity[i];
        model.bodies[i].orientation = about_y(turn * angle);
        model.bodies[i].angular_velocity = {0, turn * rate, 0};
    }
    const auto joint = [&](const char* name, JointKind kind, const char* a, const char* b, const Vec3& point,
                           const Vec3& axis) {
        Joint j = make_joint(name, kind, a, b, point);
        j.axes = {axis, axis};
        model.joints.push_back(j);
    };
    const Vec3 y = Vec3::UnitY();
    joint("A", JointKind::revolute, "ground", "crank", Vec3::Zero(), y);
    joint("B", in_space ? JointKind::spherical : JointKind::revolute, "crank", "rod", top, y);
    joint("C", in_space ? JointKind::universal : JointKind::revolute, in_space ? "slider" : "rod",
          in_space ? "rod" : "slider", end, y);
    if (in_space)
        model.joints.back().axes = {y, Vec3(s, 0, c)};
    joint("D", JointKind::translation, "ground", "slider", end, Vec3::UnitX());
    return model;
}

Model square_shafts(double angle, double rate) {
    Model model;
    model.name = "square-shafts";
    model.bodies = {make_body("input", 1, {0.02, 0.01, 0.01}, {-0.5, 0, 0}),
                    make_body("output", 1, {0.01, 0.02, 0.01}, {0.1, 0.5, 0})};
    model.bodies[0].angular_velocity = {rate, 0, 0};
    const auto shaft = [&](const char* name, const char* body, const Vec3& point, const Vec3& axis) {
        Joint joint = make_joint(name, JointKind::revolute, "ground", body, point);
        joint.axes = {axis, axis};
        model.joints.push_back(joint);
    };
    shaft("in", "input", {-0.5, 0, 0}, Vec3::UnitX());
    shaft("out", "output", {0, 0.5, 0}, Vec3::UnitY());
    Joint cross = make_joint("cross", JointKind::universal, "input", "output", Vec3::Zero());
    cross.axes = {Vec3(0, std::cos(angle), std::sin(angle)), Vec3::UnitX()};
    model.joints.push_back(cross);
    return model;
}

Model flat_chain(const std::vector<double>& rates) {
    Model model;
    model.name = "flat-chain";
    const auto bar = [&](const std::string& name, double x, double rise, double rate) {
        Body body = make_body(name, 1, Vec3(5e-5, 1.0 / 12, 1.0 / 12), {x, 0, 0});
        body.velocity = {0, 0, rise};
        body.angular_velocity = {0, rate, 0};
        model.bodies.push_back(body);
    };
    const auto hinge = [&](const std::string& name, const std::string& a, const std::string& b, double x) {
        model.joints.push_back(make_joint(name, JointKind::revolute, a, b, {x, 0, 0}, Vec3::UnitY()));
    };
    const int loops = static_cast<int>(rates.size()) - 1;
    for (int k = 0; k <= loops; ++k) {
        bar(fmt::format("crank{}", k), k + 0.5, -rates[k] / 2, rates[k]);
        hinge(fmt::format("A{}", k), "ground", fmt::format("crank{}", k), k);
    }
    for (int k = 1; k <= loops; ++k) {
        const std::string coupler = fmt::format("coupler{}", k);
        bar(coupler, k + 0.5, -(rates[k - 1] + rates[k]) / 2, rates[k] - rates[k - 1]);
        hinge(fmt::format("B{}", k - 1), fmt::format("crank{}", k - 1), coupler, k);
        hinge(fmt::format("C{}", k), fmt::format("crank{}", k), coupler, k + 1);
    }
    return model;
}

} // namespace gudgeon::hard
