#include "core/validate_parts.hpp"
#include "core/words.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

std::string shown(const Vec3& v) { return fmt::format("({}, {}, {})", v[0], v[1], v[2]); }

Checker::Checker(const Model& model) : model_(model) {
    for (const Body& body : model.bodies)
        bodies_.emplace(body.name, &body);
    for (const Joint& joint : model.joints)
        joints_.emplace(joint.name, &joint);
}

void Checker::refuse(const std::string& pointer, const std::string& problem,
                     const std::string& allowed) const {
    throw ModelError(model_.source, pointer, problem, allowed);
}

void Checker::finite(const std::string& at, const char* member, double value) const {
    if (!std::isfinite(value))
        refuse(at + '/' + member, fmt::format("{} is not finite", value), "finite numbers");
}

void Checker::finite(const std::string& at, const std::string& member, const Vec3& value) const {
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(value[i]))
            refuse(fmt::format("{}/{}/{}", at, member, i), fmt::format("{} is not finite", value[i]),
                   "finite numbers");
}

void Checker::not_negative(const std::string& at, const char* member, double value) const {
    finite(at, member, value);
    if (value < 0)
        refuse(at + '/' + member, fmt::format("{} is negative", value), "0 or more");
}

void Checker::positive(const std::string& at, const char* member, double value) const {
    finite(at, member, value);
    if (value <= 0)
        refuse(at + '/' + member, fmt::format("{} is not positive", value), "more than 0");
}

void Checker::direction(const std::string& pointer, const Vec3& value) const {
    finite(pointer.substr(0, pointer.rfind('/')), pointer.substr(pointer.rfind('/') + 1), value);
    const double length = value.stableNorm();
    if (length < 1e-100 || length > 1e100)
        refuse(pointer, fmt::format("{} is no direction", shown(value)),
               "a vector that is not zero, of any length from 1e-100 to 1e100");
}

void Checker::table(const std::string& at, const char* member, const Table& table) const {
    if (const auto found = find_problem(table))
        refuse(at + (*member ? "/" : "") + member + found->where, found->problem, found->allowed);
}

namespace {

struct FunctionCheck {
    const Checker& check;
    const std::string& at;

    void operator()(const ConstantFunction& f) const { check.finite(at, "value", f.value); }
    void operator()(const HarmonicFunction& f) const {
        check.finite(at, "amplitude", f.amplitude);
        check.not_negative(at, "frequency", f.frequency);
        check.finite(at, "phase", f.phase);
        check.finite(at, "offset", f.offset);
    }
    void operator()(const SmoothStepFunction& f) const {
        check.finite(at, "start", f.start);
        check.finite(at, "end", f.end);
        check.finite(at, "from", f.from);
        check.finite(at, "to", f.to);
        if (f.end <= f.start)
            check.refuse(at + "/end", fmt::format("the step ends at {} and starts at {}", f.end, f.start),
                         "an end after the start");
    }
    void operator()(const RampFunction& f) const {
        check.finite(at, "value", f.value);
        check.finite(at, "rate", f.rate);
        check.finite(at, "start", f.start);
    }
    void operator()(const TableFunction& f) const { check.table(at, "", f.table()); }
};

} // namespace

void Checker::function(const std::string& pointer, const TimeFunction& f) const {
    std::visit(FunctionCheck{*this, pointer}, f);
}

const Body* Checker::find_body(const std::string& name) const {
    const auto found = bodies_.find(name);
    return found == bodies_.end() ? nullptr : found->second;
}

const Joint* Checker::find_joint(const std::string& name) const {
    const auto found = joints_.find(name);
    return found == joints_.end() ? nullptr : found->second;
}

bool Checker::moves(const std::string& name) const {
    const Body* body = find_body(name);
    return body && !body->fixed;
}

std::string Checker::body_names() const {
    std::vector<std::string> names{"ground"};
    for (const Body& body : model_.bodies)
        names.push_back(body.name);
    return listed(names);
}

void Checker::body_exists(const std::string& pointer, const std::string& name) const {
    if (name == "ground" || find_body(name))
        return;
    std::vector<std::string> names{"ground"};
    for (const Body& body : model_.bodies)
        names.push_back(body.name);
    refuse(pointer, fmt::format("unknown body '{}'", name), suggestion(name, names) + body_names());
}

void Checker::body_moves(const std::string& at, const std::string& name) const {
    body_exists(at + "/body", name);
    if (!moves(name))
        refuse(at + "/body", fmt::format("'{}' does not move", name), "a body that is not fixed");
}

void Checker::body_pair(const std::string& at, const std::array<std::string, 2>& names) const {
    for (std::size_t side = 0; side < 2; ++side)
        body_exists(fmt::format("{}/bodies/{}", at, side), names[side]);
    if (names[0] == names[1])
        refuse(at + "/bodies", fmt::format("'{}' on both sides", names[0]), "two different bodies");
    if (!moves(names[0]) && !moves(names[1]))
        refuse(at + "/bodies", fmt::format("neither '{}' nor '{}' moves", names[0], names[1]),
               "at least one body that is not fixed");
}

Vec3 Checker::global_direction(const std::string& name, bool body_frame, const Vec3& v) const {
    const Body* body = find_body(name);
    return body_frame && body ? Vec3(rotation(body->orientation.normalized()) * v) : v;
}

Vec3 Checker::global_point(const std::string& name, bool body_frame, const Vec3& point) const {
    const Body* body = find_body(name);
    return body_frame && body ? Vec3(body->position + global_direction(name, true, point)) : point;
}

void Checker::points_apart(const std::string& at, const std::array<std::string, 2>& bodies, bool body_frame,
                           const std::array<Vec3, 2>& points) const {
    const Vec3 a = global_point(bodies[0], body_frame, points[0]);
    const Vec3 b = global_point(bodies[1], body_frame, points[1]);
    const double size = std::max(a.lpNorm<Eigen::Infinity>(), b.lpNorm<Eigen::Infinity>());
    if (const double d = (b - a).norm(); d <= 1e-12 * size || d == 0)
        refuse(at + "/points", fmt::format("both points are at {}: no direction between them", shown(a)),
               "two different points");
}

} // namespace gudgeon
