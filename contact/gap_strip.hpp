// Cylinder in cylinder by strips (AP 25-42): one circle of the bearing against the axis of the journal.
//
// The bearing's axis passes through P_a along z (fixed in a), the journal's through P_b along s (fixed in b).
// Strip k is the circle of radius R about C = P_a + offset z, normal to z. Its depth is the journal's radius
// less the least distance of the circle from the axis line. Seen along s the circle is an ellipse with half
// axes R and R |z.s|; the nearest point p = C + R rho has the angle (cos, sin) = (A/(mu + D), B/mu), where A,
// B/|z.s| are the axis' coordinates in the ellipse's frame, D = R (1 - (z.s)^2) and mu > 0 the only positive
// root that makes it unit (AP 36 in one unknown). n is the unit vector from the axis to p.
//
// Inside the evolute of the ellipse (A^(2/3) + B^(2/3) < D^(2/3)) there is a second local minimum, -D < mu <
// 0: a tilted circle touches the journal on two sides. It is born and dies with a finite distance. A journal
// axis outside the circle is measured the same way, by the distance from the circle. No pose fails: parallel,
// antiparallel, concentric, at right angles; where all points of the circle are equally near, one is chosen
// and its rates along the circle are left out.
#pragma once

#include "contact/point_contact.hpp"
#include "contact/relative_wrench.hpp"

#include <array>

namespace gudgeon {

/// Points in m and unit axes, in the frames of their bodies.
struct CylinderPair {
    Vec3 point_a = Vec3::Zero(), axis_a = Vec3::UnitZ(); // bearing: middle, axis
    Vec3 point_b = Vec3::Zero(), axis_b = Vec3::UnitZ(); // journal: middle, axis
    double journal_radius = 0;                           // m
};

/// What all strips of a joint share; global components.
struct CylinderPose {
    Vec3 z, s;               // axes of bearing and journal
    Vec3 centre_a, centre_b; // m, P_a and P_b
    Vec3 offset,
        offset_slope;  // m and 1: a circle's centre off the journal axis is offset + (its offset) slope
    double cosine = 1; // z . s
};
CylinderPose cylinder_pose(const BodyMotion& a, const BodyMotion& b, const CylinderPair& pair);

/// Never below the depth of any strip with |offset| <= half_span and radius >= least_radius: a joint with a
/// negative value cannot touch. Above the truth by at most R (1 - |z.s|).
double bearing_depth_bound(const CylinderPose& pose, double journal_radius, double half_span,
                           double least_radius);

/// Frame of the ellipses: e normal to both axes, f normal to e and s, m normal to e and z.
struct StripFrame {
    Vec3 e, f, m;
    double sine = 0;         // of the tilt, >= 0: s = cosine z + sine m
    double q_e = 0, q_f = 0; // m, journal axis off the circle of offset 0
    double x = 0;            // m, centre of that circle along the journal
    double cosine = 1;       // z . s

    double journal_f(double offset) const { return q_f + offset * sine; } // m, beside q_e
};
StripFrame strip_frame(const CylinderPose& pose);

/// Never below the depth of a strip, above it by at most R (1 - |z.s|).
double strip_depth_bound(const StripFrame& frame, double journal_radius, double offset, double radius);
/// That bound is not above zero: the strip does not touch.
bool strip_is_apart(const StripFrame& frame, double journal_radius, double offset, double radius);
/// The second nearest point is at least R (z.s)^2 from the journal's axis: below that one side at most
/// touches.
bool may_touch_twice(const StripFrame& frame, double journal_radius, double radius);

struct StripPoint : ContactPoint {
    double x = 0;               // m, along the journal's axis from P_b
    Vec3 radial = Vec3::Zero(); // unit, rho
    Vec3 arm = Vec3::Zero();    // m, p - P_a
    double radius = 0;          // m, of the circle
    double distance = 0;        // m, of p from the journal's axis
};

/// The local nearest points of the circle, the nearest first: 1 or 2.
int strip_points(const CylinderPose& pose, const StripFrame& frame, double journal_radius, double offset,
                 double radius, StripPoint out[2]);

/// The nearest points of several circles of a joint, found side by side; the same bits as one by one.
struct StripRow {
    static constexpr int most = 32;
    int count = 0;
    std::array<int, most> strip; // whose numbers these are, rising
    std::array<double, most> offset, radius, distance;
    std::array<double, most> c, s;     // rho = c e + s m
    std::array<double, most> w_e, w_f; // m, of p from the journal's axis

    /// Those of the strips [first, last), at most `most`, that are not apart.
    void find(const StripFrame& frame, double journal_radius, int first, int last, const double* offsets,
              const double* radii);
    /// Of one strip, apart or not.
    void find(const StripFrame& frame, double offset, double radius);
    double depth(int i, double journal_radius) const { return journal_radius - distance[i]; }
    void fill(const CylinderPose& pose, const StripFrame& frame, double journal_radius, int i,
              StripPoint& out) const;

  private:
    void solve(const StripFrame& frame);
};

/// How a point moves, seen from the bearing, with the journal's displacement at P_a and its turn (six
/// columns, global components; relative_wrench.hpp). Exact, through the implicit function: with r the arm, w
/// = d n from the axis to p, tau = z x rho, t = s x n, k = t . tau, G = (n, r x n), T = (t, r x t)
///   depth    G
///   angle    phi = (k T + (0, tau x w)) / g,   g = R (1 - (s . tau)^2) - w . rho
///   point    dp = R tau phi
///   normal   dn = t (R k phi - T) / d + turn x n
///   wrench   dG = R g / d phi phi^T - T T^T / d + (0, turn x n; 0, r x (turn x n))
struct StripSlopes {
    StripSlopes(const CylinderPose& pose, const StripPoint& c);

    Vec3 tau, t;
    Vec6 depth, tangent, angle;    // G, T, phi
    double k, along;               // along = s . tau
    double g, per_g, per_distance; // m, 1/m; the last two 0 where they are infinite

    Vec6 slide(double radius) const { return per_distance * (radius * k * angle - tangent); } // dn = t slide
    Mat36 point(const StripPoint& c) const { return c.radius * tau * angle.transpose(); }
    Mat36 normal(const StripPoint& c) const;
    /// Of the depth's rate n . velocity, velocity that of the journal's material at p off the bearing's,
    /// turning its angular velocity, both held seen from the bearing.
    Vec6 rate(const StripPoint& c, const Vec3& velocity, const Vec3& turning) const;
    Vec6 position(const CylinderPose& pose, const StripPoint& c) const;       // of StripPoint::x
    Mat6 position_slope(const CylinderPose& pose, const StripPoint& c) const; // of position()
};

/// Part of a strip [x - width/2, x + width/2] that a journal [-length/2, length/2] covers, in 0..1, and its
/// derivative in x (1/m). Continuous, with kinks where an end of the strip passes an end of the journal.
struct Coverage {
    double fraction = 1, by_x = 0;
};
Coverage strip_coverage(double x, double width, double journal_length);

} // namespace gudgeon
