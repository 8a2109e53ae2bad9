// Motion of one body inside a step, from coordinates, velocities and accelerations at both ends: quintic in
// the position, cubic in Euler parameters and velocities.
#pragma once

#include "core/motion.hpp"

namespace gudgeon {

/// Weights at the share s of a step between values x0, x1 with rates and second derivatives at both ends:
///   quintic  x0 + value (x1 - x0) + h (slope0 x0' + slope1 x1') + h^2 (bend0 x0'' + bend1 x1'')
///   cubic    x0 + c (x1 - x0) + h (c0 x0' + c1 x1')
struct HermiteWeights {
    double value, slope0, slope1, bend0, bend1, c, c0, c1;

    explicit HermiteWeights(double s) {
        const double s2 = s * s, s3 = s2 * s, r = 1 - s;
        value = s3 * (10 - 15 * s + 6 * s2);
        slope0 = s * r * r * r * (1 + 3 * s);
        slope1 = -s3 * r * (4 - 3 * s);
        bend0 = 0.5 * s2 * r * r * r;
        bend1 = 0.5 * s3 * r * r;
        c = s2 * (3 - 2 * s);
        c0 = s * r * r;
        c1 = -s2 * r;
    }
};

/// One end of a step: arrays of the whole system (q: 7, u and acceleration: 6 per moving body).
struct StepEnd {
    double t; // s
    const VecX& q;
    const VecX& u;
    const VecX& acceleration;
};

/// a.t <= t <= b.t, a.t < b.t.
inline void hermite_motion(const StepEnd& a, const StepEnd& b, double t, int body, BodyMotion& out) {
    const double h = b.t - a.t;
    const auto [value, slope0, slope1, bend0, bend1, c, c0, c1] = HermiteWeights((t - a.t) / h);
    const Vec3 r0 = a.q.segment<3>(7 * body), r1 = b.q.segment<3>(7 * body);
    const Vec4 p0 = a.q.segment<4>(7 * body + 3), p1 = b.q.segment<4>(7 * body + 3);
    const Vec6 u0 = a.u.segment<6>(6 * body), u1 = b.u.segment<6>(6 * body);
    const Vec6 a0 = a.acceleration.segment<6>(6 * body), a1 = b.acceleration.segment<6>(6 * body);
    const Vec6 u = u0 + c * (u1 - u0) + h * (c0 * a0 + c1 * a1);
    out.r = r0 + value * (r1 - r0) + h * (slope0 * u0.head<3>() + slope1 * u1.head<3>()) +
            h * h * (bend0 * a0.head<3>() + bend1 * a1.head<3>());
    const Vec4 rate0 = 0.5 * lt_times(p0, Vec3(u0.tail<3>())), rate1 = 0.5 * lt_times(p1, Vec3(u1.tail<3>()));
    out.p = (p0 + c * (p1 - p0) + h * (c0 * rate0 + c1 * rate1)).normalized();
    out.A = rotation(out.p);
    out.v = u.head<3>();
    out.w = u.tail<3>();
}

/// The motion carried on beyond a point by its accelerations.
inline void motion_carried_on(const StepEnd& from, double t, int body, BodyMotion& out) {
    const double h = t - from.t;
    const Vec6 u = from.u.segment<6>(6 * body), a = from.acceleration.segment<6>(6 * body);
    const Vec4 p = from.q.segment<4>(7 * body + 3);
    out.r = from.q.segment<3>(7 * body) + h * u.head<3>() + 0.5 * h * h * a.head<3>();
    out.p = (p + h * 0.5 * lt_times(p, Vec3(u.tail<3>() + 0.5 * h * a.tail<3>()))).normalized();
    out.A = rotation(out.p);
    out.v = u.head<3>() + h * a.head<3>();
    out.w = u.tail<3>() + h * a.tail<3>();
}

} // namespace gudgeon
