// Cylinder in cylinder with one or two points (AU 10-19), beside the strips of gap_strip.hpp.
//
// Planar (AU 10-17): the axes count as parallel. e = part of P_b - P_a across the bearing's axis, depth
// |e| - c, n = e / |e|, p = foot of P_b on the bearing's axis + R n: the force goes through P_b.
//
// Two-end (AU 19): the two ends E = P_a -+ (l/2) z of the bearing's axis, each with its own distance |w| from
// the journal's axis, w from the axis' foot to E: depth |w| - c, n = -w / |w|, p = E + R n. No end touching
// is free flight, one is a point, two are two points or, with equal depths, a line. AU measures the offset in
// the plane across the bearing's axis; across the journal's it is smaller by at most the cosine of the tilt,
// and its rate is exactly that of the material points, so that force and depth are conjugate.
//
// At zero offset the normal and its rates are zero, the depth is -c.
#pragma once

#include "contact/point_contact.hpp"

#include <array>

namespace gudgeon {

/// Points in m and unit axes, in the frames of their bodies.
struct PlanarGap {
    Vec3 point_a = Vec3::Zero(), axis_a = Vec3::UnitZ(); // bearing: middle, axis
    Vec3 point_b = Vec3::Zero();                         // on the journal's axis
    double clearance = 0;                                // m, bearing radius - journal radius
    double radius = 0;                                   // m, of the bearing; 0 if unknown
};

ContactPoint planar_point(const BodyMotion& a, const BodyMotion& b, const PlanarGap& gap);

ContactPointRates planar_rates(const BodyMotion& a, const BodyMotion& b, const PlanarGap& gap,
                               const ContactPoint& c);

struct TwoEndGap {
    Vec3 point_a = Vec3::Zero(), axis_a = Vec3::UnitZ(); // bearing: middle, axis
    Vec3 point_b = Vec3::Zero(), axis_b = Vec3::UnitZ(); // journal: a point of its axis, axis
    double length = 0;                                   // m, of the bearing
    double clearance = 0;                                // m, bearing radius - journal radius
    double radius = 0;                                   // m, of the bearing; 0 if unknown
};

/// The end -l/2, then the end +l/2.
std::array<ContactPoint, 2> two_end_points(const BodyMotion& a, const BodyMotion& b, const TwoEndGap& gap);

/// end: 0 or 1, c: that end's point.
ContactPointRates two_end_rates(const BodyMotion& a, const BodyMotion& b, const TwoEndGap& gap, int end,
                                const ContactPoint& c);

} // namespace gudgeon
