// Parts of the model file reader, one function per kind of entry.
#pragma once

#include "core/json_input.hpp"

namespace gudgeon {

Body read_body(const JsonInput& in);
Joint read_joint(const JsonInput& in);
Force read_force(const JsonInput& in);
Marker read_marker(const JsonInput& in);
Beam read_beam(const JsonInput& in);
TimeFunction read_time_function(const JsonInput& in);
Table read_table(const JsonInput& in);
Clearance read_clearance(const JsonInput& in);
Stop read_stop(const JsonInput& in);
Friction read_friction(const JsonInput& in);
/// One word for the whole joint, or an object with a word per relative motion.
void read_fidelity(const JsonInput& in, Joint& joint);
/// "clearance", "bearing", "stops" and "friction" of a joint.
void read_contacts(const JsonInput& in, Joint& joint);

/// Euler parameters of unit length. What is already normalised keeps its bits, so that written
/// models read back identically.
Vec4 read_orientation(const JsonInput& in);

/// "frame": "global" (default) or "body"; true for body.
bool read_body_frame(const JsonInput& in);
std::array<std::string, 2> read_body_pair(const JsonInput& in);
/// "point" (of both sides; global only) or "points" (one per side).
std::array<Vec3, 2> read_points(const JsonInput& in, bool body_frame);

} // namespace gudgeon
