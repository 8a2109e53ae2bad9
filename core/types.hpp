// Vector types and rotation helpers shared by every folder.
//
// Frames: a vector without a suffix is in the global frame; "_body" (a prime in the papers) is in
// the frame of a body. A(p) turns body components into global ones: x = A x_body.
// Rotation increments are body-frame vectors: A(p + dp) = A (I + skew(dtheta)), dp = 1/2 L^T dtheta.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>

namespace gudgeon {

using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d; // Euler parameters (e0, e1, e2, e3), e0 scalar
using Vec6 = Eigen::Matrix<double, 6, 1>;
using VecX = Eigen::VectorXd;
using Mat3 = Eigen::Matrix3d;
using MatX = Eigen::MatrixXd;

inline constexpr double pi = 3.14159265358979323846;

/// skew(a) b = a x b.
inline Mat3 skew(const Vec3& a) {
    Mat3 s;
    s << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return s;
}

/// Rotation matrix body -> global of unit Euler parameters (Nikravesh 1988).
inline Mat3 rotation(const Vec4& p) {
    const double e0 = p[0], e1 = p[1], e2 = p[2], e3 = p[3];
    Mat3 a;
    a << 1 - 2 * (e2 * e2 + e3 * e3), 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2),
        2 * (e1 * e2 + e0 * e3), 1 - 2 * (e1 * e1 + e3 * e3), 2 * (e2 * e3 - e0 * e1),
        2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1 * e1 + e2 * e2);
    return a;
}

/// L^T x, with L the 3x4 matrix of omega_body = 2 L p' (AP 2.1): p' = 1/2 L^T omega_body.
inline Vec4 lt_times(const Vec4& p, const Vec3& x) {
    return {-p[1] * x[0] - p[2] * x[1] - p[3] * x[2], p[0] * x[0] - p[3] * x[1] + p[2] * x[2],
            p[3] * x[0] + p[0] * x[1] - p[1] * x[2], -p[2] * x[0] + p[1] * x[1] + p[0] * x[2]};
}

/// L y: the transpose of the above, L L^T = I for unit p.
inline Vec3 l_times(const Vec4& p, const Vec4& y) {
    return {-p[1] * y[0] + p[0] * y[1] + p[3] * y[2] - p[2] * y[3],
            -p[2] * y[0] - p[3] * y[1] + p[0] * y[2] + p[1] * y[3],
            -p[3] * y[0] + p[2] * y[1] - p[1] * y[2] + p[0] * y[3]};
}

/// Euler parameters after turning p by the body-frame rotation vector theta (exact, unit length).
inline Vec4 turned(const Vec4& p, const Vec3& theta) {
    const double x = 0.25 * theta.squaredNorm(); // square of the half angle
    double c, s;                                 // its cosine, and its sine over the whole angle
    if (x < 0.01) {                              // both to round-off by their series
        c = 1 - x / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56)));
        s = 0.5 * (1 - x / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72))));
    } else {
        const double half = std::sqrt(x);
        c = std::cos(half);
        s = 0.5 * std::sin(half) / half;
    }
    const Vec4 out = c * p + s * lt_times(p, theta);
    return (1 / out.norm()) * out;
}

} // namespace gudgeon
