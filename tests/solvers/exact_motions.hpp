// Exact motions of the ready pendulum and heavy top.
#pragma once

#include "core/types.hpp"
#include "tests/solvers/elliptic.hpp"

namespace gudgeon::test {

/// The ready pendulum: sin(theta / 2) = k sn(K - w t), theta from the lowest point.
struct PendulumTruth {
    Vec3 r, v;
    explicit PendulumTruth(double t) {
        const double k = std::sqrt(0.5), w = std::sqrt(9.81);
        const Jacobi j = jacobi(std::comp_ellint_1(k) - w * t, k);
        const double theta = 2 * std::asin(k * j.sn), rate = -2 * k * w * j.cn;
        r = {-std::sin(theta), 0, -std::cos(theta)};
        v = {-std::cos(theta) * rate, 0, std::sin(theta) * rate};
    }
};

/// Velocity of the mass centre of the ready heavy top from its first integrals (energy, angular momentum
/// about Z and about its own axis), given the exact tilt and azimuth and the sign of the tilt's rate.
inline Vec3 top_velocity(double azimuth, double tilt, bool falling) {
    const double m = 1, l = 0.3, axial = 0.01, spin = 40, tilt0 = pi / 3, g = 9.81;
    const double across = 0.02 + m * l * l, own = axial * spin, about_z = own * std::cos(tilt0);
    const double s = std::sin(tilt), c = std::cos(tilt);
    const double precession = (about_z - own * c) / (across * s * s);
    const double square = 2 * m * g * l * (std::cos(tilt0) - c) / across - std::pow(precession * s, 2);
    const double rate = (falling ? 1 : -1) * std::sqrt(square);
    const double sa = std::sin(azimuth), ca = std::cos(azimuth);
    return l * (rate * Vec3(c * ca, c * sa, -s) + precession * s * Vec3(-sa, ca, 0));
}

} // namespace gudgeon::test
