// The relative motions of a pair of bodies a, b (AP 6-19): value, gradient, and the derivatives that
// constraints, bushings, springs, drives and stops share.
//
// Each measure c(q) has
//   gradient  B: c' = B u, u = (v_a, w_a, v_b, w_b), v global, w body frame (rows of length 12)
//   drift     B' u: the part of c'' that does not contain accelerations
//   rate_gradient D = d(B u)/dq at fixed u
//   geometric d(B^T g)/dq at fixed g, the geometric stiffness of a force g conjugate to c
// where d/dq is taken along body-frame rotations (types.hpp). A force g acting on c puts -B^T g on the
// bodies; a constraint c = 0 with multiplier lambda likewise (AP 2 with its transpose).
#pragma once

#include "core/motion.hpp"

#include <array>

namespace gudgeon {

/// R rows over (v_a, w_a, v_b, w_b): four R x 3 parts.
template <int R> struct Gradient {
    using Part = Eigen::Matrix<double, R, 3, (R == 1 ? Eigen::RowMajor : Eigen::ColMajor)>;
    Part ra = Part::Zero(), ta = Part::Zero(), rb = Part::Zero(), tb = Part::Zero();

    Eigen::Matrix<double, R, 1> times(const BodyMotion& a, const BodyMotion& b) const {
        return ra * a.v + ta * a.w + rb * b.v + tb * b.w;
    }
    const Part& part(int k) const { return k == 0 ? ra : k == 1 ? ta : k == 2 ? rb : tb; }
};

/// 4 x 4 blocks of 3 x 3 over (v_a, w_a, v_b, w_b); only those a measure touches are written.
struct BlockMatrix {
    std::array<std::array<Mat3, 4>, 4> block;
    void set_zero();
};

/// Which 3 x 3 blocks can be nonzero: bit 4 i + j for row part i, column part j of (r_a, t_a, r_b, t_b).
using CouplingMask = unsigned;
inline constexpr CouplingMask coupling_bit(int i, int j) { return 1u << (4 * i + j); }
inline constexpr CouplingMask couple_all = 0xffff;

/// Point difference d = P_b - P_a in global components (AP 6): spherical part of the joints.
namespace point_difference {
inline constexpr CouplingMask coupling = coupling_bit(1, 1) | coupling_bit(3, 3);
inline Vec3 value(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    return point_position(b, sb) - point_position(a, sa);
}
Gradient<3> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb);
Vec3 drift(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb);
Gradient<3> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb);
void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& g,
                   BlockMatrix& out);
} // namespace point_difference

/// Displacement of P_b along a direction x fixed in a: x . d (AP 7, 11; corrected AP 8).
namespace displacement {
inline constexpr CouplingMask coupling = coupling_bit(0, 1) | coupling_bit(1, 0) | coupling_bit(1, 1) |
                                         coupling_bit(1, 2) | coupling_bit(1, 3) | coupling_bit(2, 1) |
                                         coupling_bit(3, 1) | coupling_bit(3, 3);
double value(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& x);
Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& x);
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb,
                          const Vec3& x);
/// gx: the force times its direction, in a's body frame (several directions add up).
void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& gx,
                   BlockMatrix& out);
} // namespace displacement

/// Cosine between a direction x fixed in a and y fixed in b: x . y (AP 7, 9).
namespace alignment {
inline constexpr CouplingMask coupling =
    coupling_bit(1, 1) | coupling_bit(1, 3) | coupling_bit(3, 1) | coupling_bit(3, 3);
inline double value(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    return (a.A * x).dot(b.A * y);
}
inline Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    const Vec3 x_global = a.A * x, y_global = b.A * y;
    Gradient<1> g;
    g.ta = x.cross(a.A.transpose() * y_global).transpose();
    g.tb = y.cross(b.A.transpose() * x_global).transpose();
    return g;
}
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y);
void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y, double g,
                   BlockMatrix& out);
} // namespace alignment

/// Angle in [0, pi] between a direction x fixed in a and y fixed in b: atan2(|x x y|, x . y). Its gradient
/// jumps at 0 and pi, where it is returned as zero.
namespace swing {
inline constexpr CouplingMask coupling = alignment::coupling;
double value(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y);
Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y);
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y);
void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y, double g,
                   BlockMatrix& out);
} // namespace swing

/// Distance |P_b - P_a| > 0: distance joints and spring-dampers.
namespace distance {
inline constexpr CouplingMask coupling = couple_all;
double value(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb);
Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb);
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb);
void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, double g,
                   BlockMatrix& out);
} // namespace distance

/// Rotation vector of b's joint frame relative to a's, in a's joint frame (|theta| < pi).
namespace rotation_vector {
inline constexpr CouplingMask coupling = alignment::coupling;
/// qa, qb: Euler parameters of the joint frames in their bodies.
Vec3 value(const BodyMotion& a, const BodyMotion& b, const Vec4& qa, const Vec4& qb);
/// With omega_a, omega_b in the two joint frames:
/// theta' = E (omega_b - omega_a) + 1/2 theta x (omega_a + omega_b), E x = x + c theta x (theta x x);
/// this is c = (1 - (|theta|/2) cot(|theta|/2)) / |theta|^2.
double curvature(const Vec3& theta);
Gradient<3> gradient(const Vec3& theta, const Mat3& axes_a, const Mat3& axes_b);
Gradient<3> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& theta, const Mat3& axes_a,
                          const Mat3& axes_b, const Gradient<3>& gradient);
void add_geometric(const Vec3& theta, const Mat3& axes_a, const Mat3& axes_b, const Gradient<3>& gradient,
                   const Vec3& g, BlockMatrix& out);
} // namespace rotation_vector

/// Angle atan2(x1 . y1, x2 . y2) with x in a and y in b: turn of b relative to a (AP 19, unfolded).
/// Returned on the branch closest to a reference, so that it counts turns.
struct AngleFrames {
    Vec3 x1, y1, x2, y2;
};
namespace angle {
inline constexpr CouplingMask coupling = alignment::coupling;
double value(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f, double reference);
Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f);
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f);
void add_geometric(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f, double g,
                   BlockMatrix& out);
} // namespace angle

} // namespace gudgeon
