// Friction at a contact point: on b (journal, ball, slider) the force -N (I - n n^T) mu(v), on a its
// opposite, both at the point p; v = (I - n n^T) (v_b(p) - v_a(p)) the slip of the materials there, N the
// normal force.
//
// Three friction states per point, the bristles' deflection in a's frame: z' = A_a^T v - decay z. They stay
// with the bearing; what of them leaves the tangent plane as the point travels around it does not push.
// While the point is apart they relax (friction_law.hpp).
//
// Derivatives are exact, but for the change of source and decay with the pose, which S leaves out.
#pragma once

#include "contact/friction_law.hpp"
#include "contact/point_contact.hpp"
#include "contact/relative_wrench.hpp"

#include <array>

namespace gudgeon {

struct PointFriction {
    FrictionValue<3> f;
    Mat3 tangential = Mat3::Zero();                   // I - n n^T
    Vec3 bristles = Vec3::Zero();                     // m, in a's frame
    Vec3 slip = Vec3::Zero();                         // m/s, global
    Vec3 force = Vec3::Zero();                        // N, global, on b
    double normal_force = 0;                          // N
    double power() const { return -force.dot(slip); } // W, dissipated
};

/// z: three states in a's frame; null for laws without states.
PointFriction point_friction(const FrictionLaw& law, const double* z, const BodyMotion& a,
                             const BodyMotion& b, const ContactPoint& c, double normal_force);

/// C += -df/du and S += -df/dq; depth_rate is B of the normal force's speed, change = dN/dq, by_rate =
/// dN/d(rate).
void add_friction_linearisation(const PointFriction& friction, const BodyMotion& a, const BodyMotion& b,
                                const ContactPoint& c, const ContactPointRates& rates,
                                const Gradient<1>& depth_rate, const Gradient<1>& change, double by_rate,
                                BlockMatrix& C, BlockMatrix& S);

/// The same seen from a (relative_wrench.hpp): arm = p - origin; velocity of b's material at p off a's,
/// turning = w_b - w_a; dn and dp, change = dN/d(pose) in six columns, depth_slope = d(depth)/d(pose).
void add_relative_friction(const PointFriction& friction, const Vec3& n, const Vec3& arm,
                           const Vec3& velocity, const Vec3& turning, const Mat36& dn, const Mat36& dp,
                           const Vec6& depth_slope, const Vec6& change, double by_rate, RelativeWrench& out);

/// z' = source - decay z of the three states.
void point_state_terms(const PointFriction& friction, const BodyMotion& a, double* source, double* decay);
/// The same of a point that is apart.
void free_state_terms(const FrictionLaw& law, double* source, double* decay);

/// Derivatives for Linearisation::states; the numbers of state, pair and bodies are left to the caller.
std::array<Linearisation::StateCoupling, 3> point_state_couplings(const PointFriction& friction,
                                                                  const BodyMotion& a, const BodyMotion& b,
                                                                  const ContactPoint& c);

/// The same of a point that is apart: they decay and push nothing.
std::array<Linearisation::StateCoupling, 3> free_state_couplings(const FrictionLaw& law);

} // namespace gudgeon
