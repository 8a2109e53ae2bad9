// Pose and velocity of every body at one instant, as all kernels read them.
#pragma once

#include "core/types.hpp"

#include <vector>

namespace gudgeon {

/// Pose and velocity of one body. A turns body components into global ones.
struct BodyMotion {
    Mat3 A = Mat3::Identity();
    Vec4 p{1, 0, 0, 0};
    Vec3 r = Vec3::Zero(); // m, global
    Vec3 v = Vec3::Zero(); // m/s, global
    Vec3 w = Vec3::Zero(); // rad/s, body frame
};

/// The motion of one body by its 7 coordinates (of any length of p) and 6 velocities.
template <class Q, class U> void set_body_motion(const Q& q, const U& u, BodyMotion& out) {
    out.r = q.template head<3>();
    out.p = q.template tail<4>().normalized();
    out.A = rotation(out.p);
    out.v = u.template head<3>();
    out.w = u.template tail<3>();
}

/// A joint frame on a body: origin and triad (h, t, b as columns) in body coordinates.
struct Anchor {
    int body = 0;
    Vec3 point = Vec3::Zero();
    Mat3 axes = Mat3::Identity();
};

inline Vec3 point_position(const BodyMotion& m, const Vec3& s) { return m.r + m.A * s; }
inline Vec3 point_velocity(const BodyMotion& m, const Vec3& s) { return m.v + m.A * m.w.cross(s); }
/// Velocity of the body's material at a global point p.
inline Vec3 point_velocity_at(const BodyMotion& m, const Vec3& p) { return m.v + (m.A * m.w).cross(p - m.r); }

/// Triad (h, t, b) of an axis: b along it; h is the global axis that follows, cyclically, the one
/// closest to b, projected normal to b (axis X gives h = Y, axis Z gives h = X); t = b x h.
Mat3 joint_triad(const Vec3& axis);

/// Triad with b along axis and h the part of reference normal to it.
Mat3 joint_triad(const Vec3& axis, const Vec3& reference);

} // namespace gudgeon
