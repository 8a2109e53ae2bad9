#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"
#include "core/validate_laws.hpp"
#include "core/validate_parts.hpp"
#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

namespace {

struct ForceCheck {
    const Checker& check;
    const std::string& at;

    /// Linear or tabulated; a table replaces the stiffness, so both would hide one of them.
    void spring(double stiffness, double damping, const Table& table) const {
        check.not_negative(at, "stiffness", stiffness);
        check.not_negative(at, "damping", damping);
        if (table.empty() && table.y.empty())
            return;
        check.table(at, "table", table);
        if (stiffness != 0)
            check.refuse(at + "/stiffness", fmt::format("the stiffness {} beside a table", stiffness),
                         "one of the two");
    }

    void operator()(const SpringDamper& f) const {
        check.body_pair(at, f.bodies);
        for (std::size_t side = 0; side < 2; ++side)
            check.finite(at, fmt::format("points/{}", side), f.points[side]);
        check.points_apart(at, f.bodies, f.body_frame, f.points);
        spring(f.stiffness, f.damping, f.table);
        if (f.free_length)
            check.not_negative(at, "free_length", *f.free_length);
        if (f.preload)
            check.finite(at, "preload", *f.preload);
        if (f.free_length && f.preload)
            check.refuse(at + "/preload", fmt::format("the preload {} beside a free length", *f.preload),
                         "one of the two");
        if (f.actuator)
            check.function(at + "/actuator", *f.actuator);
    }

    void operator()(const TorsionSpring& f) const {
        const Joint* joint = check.find_joint(f.joint);
        if (!joint) {
            std::vector<std::string> names;
            for (const Joint& j : check.model().joints)
                names.push_back(j.name);
            check.refuse(at + "/joint", fmt::format("unknown joint '{}'", f.joint),
                         suggestion(f.joint, names) + listed(names));
        }
        const bool perfect = is_wholly_perfect(*joint);
        const auto names =
            perfect ? rotation_coordinates(joint->kind, Fidelity::perfect) : std::vector<std::string>{};
        if (std::find(names.begin(), names.end(), f.coordinate) == names.end())
            check.refuse(at + "/coordinate",
                         fmt::format("'{}' is no rotation coordinate of the {} joint '{}'{}", f.coordinate,
                                     joint_kind(joint->kind).name, joint->name,
                                     perfect ? "" : " with " + imperfection(*joint)),
                         listed(names));
        spring(f.stiffness, f.damping, f.table);
        check.finite(at, "free_angle", f.free_angle);
    }

    void operator()(const Tyre& f) const {
        check.body_moves(at, f.body);
        check.finite(at, "point", f.point);
        check.not_negative(at, "stiffness", f.stiffness);
        check.not_negative(at, "damping", f.damping);
        check.finite(at, "preload", f.preload);
        if (f.reference)
            check.finite(at, "reference", *f.reference);
        if (f.road)
            check.function(at + "/road", *f.road);
        if (!f.profile.empty() || !f.profile.y.empty())
            check.table(at, "profile", f.profile);
    }

    void operator()(const FrictionForce& f) const {
        check.body_pair(at, f.bodies);
        const bool one = !f.body_frame && f.points[0] == f.points[1];
        for (std::size_t side = 0; side < 2; ++side)
            check.finite(at, one ? "point" : fmt::format("points/{}", side), f.points[side]);
        check.direction(at + "/axis", f.axis);
        const std::string base = at + "/friction";
        check_friction_law(check, base, f.friction);
        refuse_radius_and_coordinate(check, base, f.friction, "a force");
        if (!f.friction.normal_force)
            check.refuse(base + "/normal_force", "'normal_force' is missing",
                         "'normal_force' is required here");
    }

    void operator()(const AppliedForce& f) const {
        check.body_moves(at, f.body);
        check.finite(at, "point", f.point);
        check.finite(at, "vector", f.vector);
        if (f.time)
            check.function(at + "/time", *f.time);
    }
};

} // namespace

void check_forces(const Checker& check) {
    const auto& forces = check.model().forces;
    for (std::size_t i = 0; i < forces.size(); ++i) {
        const std::string at = fmt::format("/forces/{}", i);
        std::visit(ForceCheck{check, at}, forces[i]);
    }
}

} // namespace gudgeon
