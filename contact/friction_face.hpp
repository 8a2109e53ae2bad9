// Friction of a surface that a limit presses: end face of a bearing, stop on a displacement, key or spline.
//
// Slip has up to three components, in a's frame (a the bearing or guide):
//   face  s = (h . v, t . v, R b . omega), v = velocity of b's joint point relative to a's material there,
//         omega = angular velocity of b relative to a, b the pressing direction, h and t across it, R (m) the
//         effective radius at which a turning face rubs; the normal force N is the limit's force
//   key   s = (b . v, 0, 0), b the axis of the slider; N = M/r, M the moment on the key, r its radius
// and the force conjugate to s is -N mu(s) with the friction laws of friction_law.hpp taken for the whole
// vector: a face that only slides brakes with mu N, one that only turns with the moment mu N R (a thrust
// washer), and one that does both with less of each, (F / mu N)^2 + (M / mu N R)^2 = 1: the ellipsoid taken
// for the limit surface of a pressed patch (Howe and Cutkosky, Int. J. Robotics Research 15 (1996) 557-572).
// The pressure on a face does not move with its tilt.
//
// -B^T (N mu) acts on the two bodies, B = ds/du: opposite forces at b's joint point and opposite moments, so
// momentum is kept; the power N mu . s is dissipated. Three friction states, the bristles' deflections along
// the three components: z' = s - decay z.
//
// Derivatives are exact, but for the change of source and decay with the pose, which S leaves out.
#pragma once

#include "contact/friction_law.hpp"
#include "core/force_batch.hpp"

#include <array>

namespace gudgeon {

/// Where and how a surface slips; a slip whose weight is 0 does not rub.
struct FaceSlip {
    Vec3 sa = Vec3::Zero(), sb = Vec3::Zero(); // joint points, body frames
    Mat3 axes = Mat3::Identity();              // in a: h, t, b
    Vec3 weight{1, 1, 0};                      // 1, 1, R (m)
    double pressing = 1; // normal force per force of the limit: 1, or 1/r (1/m) of a key
};

/// End face or stop across column `axis` of the triad; radius 0: turning does not rub.
FaceSlip face_slip(const Vec3& sa, const Vec3& sb, const Mat3& triad, int axis, double radius);
/// Key at a radius that slides along the third column of the triad.
FaceSlip key_slip(const Vec3& sa, const Vec3& sb, const Mat3& triad, double radius);

struct FaceFriction {
    FrictionValue<3> f;
    std::array<Gradient<1>, 3> gradient; // of the slip's components
    Vec3 slip = Vec3::Zero();            // m/s
    double normal_force = 0;             // N

    double force() const { return normal_force * f.mu.norm(); }    // N, turning counted at the radius
    double power() const { return normal_force * f.mu.dot(slip); } // W, dissipated
};

/// z: three states, null for laws without. limit_force: of the limit's law, N or N m.
FaceFriction face_friction(const FrictionLaw& law, const FaceSlip& face, const double* z, const BodyMotion& a,
                           const BodyMotion& b, double limit_force);

PairWrench face_wrench(const FaceFriction& friction);
/// The resultant on b, N, global.
Vec3 face_force(const FaceFriction& friction, const FaceSlip& face, const BodyMotion& a);

/// C += -df/du and S += -df/dq; by_pose and by_speed are d(limit force)/dq and /du.
void add_face_linearisation(const FaceFriction& friction, const FaceSlip& face, const BodyMotion& a,
                            const BodyMotion& b, const Gradient<1>& by_pose, const Gradient<1>& by_speed,
                            BlockMatrix& C, BlockMatrix& S);

/// z' = source - decay z of the three states.
void face_state_terms(const FaceFriction& friction, double* source, double* decay);
/// Derivatives for Linearisation::states; the numbers of state, pair and bodies are left to the caller.
std::array<Linearisation::StateCoupling, 3> face_state_couplings(const FaceFriction& friction);

} // namespace gudgeon
