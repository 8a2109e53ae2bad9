// A force and a moment between two bodies that depend on their relative motion only: on the two bodies, with
// derivatives, from six columns.
//
// At an origin fixed in a, b's material moves off a's with the twist (V, W), W = w_b - w_a; a displacement
// and a turn of b relative to a likewise. The wrench is the force on a and its moment about the origin; b
// gets the opposite on the same line. All in global components, but changes are those seen from a: a turn of
// both bodies changes none of them.
#pragma once

#include "core/force_batch.hpp"

namespace gudgeon {

using Mat36 = Eigen::Matrix<double, 3, 6>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

Vec6 relative_twist(const BodyMotion& a, const BodyMotion& b, const Vec3& origin); // m/s, rad/s

/// J: relative twist = J u, and relative displacement and turn = J dq.
Gradient<6> relative_twist_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& origin);

PairWrench on_bodies(const BodyMotion& a, const BodyMotion& b, const Vec3& origin, const Vec6& wrench);

/// A wrench with its derivatives in displacement and turn, and in the twist.
struct RelativeWrench {
    Vec6 value = Vec6::Zero();
    Mat6 by_pose = Mat6::Zero(), by_twist = Mat6::Zero();
    bool damps = false; // by_twist is not zero
};

/// C += -d(on_bodies)/du, S += -d(on_bodies)/dq.
void add_relative_linearisation(const BodyMotion& a, const BodyMotion& b, const Vec3& origin,
                                const RelativeWrench& wrench, BlockMatrix& C, BlockMatrix& S);

} // namespace gudgeon
