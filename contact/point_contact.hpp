// Contact of two bodies at a point: what every gap (sphere, strip, face, corner) reduces to.
//
// A gap is a depth (m, > 0 touching) with the contact point p and the unit normal n, both global; n points
// from b (journal, ball, slider) towards a (bearing, socket, guide), so that a force f >= 0 pushes
// a by +f n and b by -f n at the same point p: moments balance. The depth is the extremum of a distance over
// the candidate points, so its rate is that of the material points there:
//   depth' = B u = -n . (v_a(p) - v_b(p)),   v_x(p) = v_x + omega_x x (p - r_x)
// and -B^T f is exactly the wrench above.
#pragma once

#include "core/force_batch.hpp"

namespace gudgeon {

struct ContactPoint {
    double depth = 0;      // m
    Vec3 p = Vec3::Zero(); // m, global
    Vec3 n = Vec3::Zero(); // unit, global, from b to a
};

/// How point and normal move with (r_a, turn of a, r_b, turn of b), turns in the bodies' frames (types.hpp):
/// dp, dn = sum over the four 3 x 3 parts.
struct ContactPointRates {
    Gradient<3> p, n;
};

/// B of the depth: depth' = B u.
Gradient<1> depth_gradient(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c);

/// D = d(B u)/dq at fixed u.
Gradient<1> depth_rate_gradient(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c,
                                const ContactPointRates& rates, const Gradient<1>& gradient);

/// The pair of wrenches of a force F (global) on a and -F on b, both at p.
PairWrench point_wrench(const BodyMotion& a, const BodyMotion& b, const Vec3& p, const Vec3& force);

/// S += -d(wrench)/dq, C += -d(wrench)/du for a normal force f(depth, rate), f_depth and f_rate its
/// derivatives (N/m, N s/m): C = f_rate B^T B, S = B^T (f_depth B + f_rate D) + d(B^T f)/dq.
void add_normal_linearisation(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c,
                              const ContactPointRates& rates, double f, double f_depth, double f_rate,
                              BlockMatrix& C, BlockMatrix& S);

/// The same for a force that depends on more than depth and rate (the covered part of a strip): gradient is
/// B, force_change is df/dq at fixed u.
void add_contact_linearisation(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c,
                               const ContactPointRates& rates, const Gradient<1>& gradient, double f,
                               const Gradient<1>& force_change, double f_rate, BlockMatrix& C,
                               BlockMatrix& S);

} // namespace gudgeon
