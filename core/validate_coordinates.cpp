// Stops and friction on the coordinates of a joint.
#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"
#include "core/validate_laws.hpp"
#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

namespace {

void check_limits(const Checker& check, const std::string& pointer, const std::string& coordinate,
                  const Stop& stop) {
    if (!stop.lower && !stop.upper)
        check.refuse(pointer + (coordinate == "swing" ? "/upper" : "/lower"), "neither 'lower' nor 'upper'",
                     "at least one of the two");
    if (stop.lower)
        check.finite(pointer, "lower", *stop.lower);
    if (stop.upper)
        check.finite(pointer, "upper", *stop.upper);
    if (coordinate == "swing") {
        if (stop.lower)
            check.refuse(pointer + "/lower", fmt::format("the lower limit {} of a swing", *stop.lower),
                         "an upper limit only: the half angle of the cone");
        if (!(*stop.upper > 0 && *stop.upper < pi))
            check.refuse(pointer + "/upper", fmt::format("the swing {}", *stop.upper),
                         "above 0 and below pi");
    } else if (stop.lower && stop.upper && *stop.lower >= *stop.upper) {
        check.refuse(pointer + "/upper",
                     fmt::format("the upper limit {} below the lower {}", *stop.upper, *stop.lower),
                     "an upper limit above the lower");
    }
}

/// Stops rub where something slides over them: sideways, turning about a slide, or along the axis of a turn.
void check_stop_friction(const Checker& check, const std::string& pointer, const std::string& coordinate,
                         const Joint& joint, const Friction& friction) {
    const bool slide = coordinate == "slide", on_axis = joint.kind == JointKind::point_on_axis;
    const auto loose = [&](Motion motion) {
        return !holds_motion(joint.kind, motion) || joint.holds(motion) != Fidelity::perfect;
    };
    const bool key = coordinate == "angle" && joint.kind != JointKind::planar && loose(Motion::axial);
    const bool turns = slide && loose(Motion::rotation);
    const bool sideways =
        coordinate == "u" || coordinate == "v" || (slide && !on_axis && loose(Motion::radial));
    if (!key && !turns && !sideways)
        check.refuse(pointer,
                     fmt::format("friction in a stop of '{}' in a {} joint, over which nothing slides",
                                 coordinate, joint_kind(joint.kind).name),
                     "friction where a face turns or moves sideways, or a key slides along the axis");
    check_friction_law(check, pointer, friction);
    refuse_coordinate_and_force(check, pointer, friction, "a stop");
    if (!sideways && !friction.radius)
        check.refuse(pointer + "/radius", "'radius' is missing",
                     key ? "the radius of the stop" : "the radius at which the turning face rubs");
}

} // namespace

void check_stops(const Checker& check, const std::string& at, const Joint& joint) {
    const auto names = stop_coordinates(joint);
    for (const auto& [coordinate, stop] : joint.stops) {
        const std::string pointer = at + "/stops/" + coordinate;
        if (std::ranges::find(names, coordinate) == names.end())
            check.refuse(pointer,
                         fmt::format("a {} joint has no coordinate '{}' to stop", joint_kind(joint.kind).name,
                                     coordinate),
                         suggestion(coordinate, names) + listed(names));
        if (joint.drives.contains(coordinate))
            check.refuse(pointer, fmt::format("stops of '{}', which is driven", coordinate),
                         "stops of coordinates without a drive");
        if (coordinate == "swing" && !joint.axes)
            check.refuse(at + (joint.body_frame ? "/axes" : "/axis"), "a stop of 'swing' without axes",
                         "an axis of the socket and one of the stud");
        check_limits(check, pointer, coordinate, stop);
        check_law(check, pointer + "/law", stop.law, {"a stop"});
        if (stop.friction)
            check_stop_friction(check, pointer + "/friction", coordinate, joint, *stop.friction);
    }
}

void check_joint_friction(const Checker& check, const std::string& at, const Joint& joint) {
    const std::string_view kind = joint_kind(joint.kind).name;
    const auto names = driveable_coordinates(joint.kind, Fidelity::perfect);
    std::vector<std::string> seen;
    for (std::size_t i = 0; i < joint.friction.size(); ++i) {
        const Friction& friction = joint.friction[i];
        const std::string base =
            at + (joint.friction.size() == 1 ? "/friction" : fmt::format("/friction/{}", i));
        if (names.empty())
            check.refuse(base, fmt::format("friction in a {} joint, which has no such coordinate", kind),
                         "friction in joints with a free coordinate, or in 'clearance'");
        check_friction_law(check, base, friction);
        if (!friction.coordinate && names.size() > 1)
            check.refuse(base + "/coordinate", "'coordinate' is missing", listed(names));
        const std::string coordinate = friction.coordinate.value_or(names[0]);
        if (std::ranges::find(names, coordinate) == names.end())
            check.refuse(base + "/coordinate",
                         fmt::format("a {} joint has no coordinate '{}'", kind, coordinate),
                         suggestion(coordinate, names) + listed(names));
        if (std::ranges::find(seen, coordinate) != seen.end())
            check.refuse(base + "/coordinate", fmt::format("a second friction on '{}'", coordinate),
                         "one on each coordinate");
        seen.push_back(coordinate);
        if (coordinate.starts_with("angle") != friction.radius.has_value())
            check.refuse(base + "/radius",
                         friction.radius ? fmt::format("the radius {} on '{}'", *friction.radius, coordinate)
                                         : "'radius' is missing",
                         "a radius on rotations, and only there");
        if (!friction.normal_force && !is_wholly_perfect(joint))
            check.refuse(base + "/normal_force", "'normal_force' is missing",
                         "'normal_force' is required in joints that are not wholly perfect");
    }
}

} // namespace gudgeon
