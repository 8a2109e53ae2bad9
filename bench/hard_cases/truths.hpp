// Exact motions that the hard cases are compared with.
#pragma once

#include "core/types.hpp"
#include "tests/solvers/elliptic.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon::hard {

/// 1/s^2, of the cranks of the ready four-bar: N + 1 cranks and N couplers of 1 m and 1 kg.
inline double crank_pull(int loops) { return 9.81 * (9 * loops + 3) / (8 * loops + 2); }

/// a'' = pull sin a, a from the upright position, turning over and over: with a = pi - 2 psi,
/// psi'^2 = W^2 (1 - m sin^2 psi), W^2 = rate^2/4 + pull, m = pull/W^2, so psi = am(K - W t).
struct Circulation {
    double pull, rate; // 1/s^2; rad/s, a' at a = 0
    double speed() const { return std::sqrt(rate * rate / 4 + pull); }
    double modulus() const { return std::sqrt(pull) / speed(); }
    /// First time at an angle between 0 and pi, s.
    double time_at(double angle) const {
        return (std::comp_ellint_1(modulus()) - std::ellint_1(modulus(), (pi - angle) / 2)) / speed();
    }
    struct Now {
        double sine, cosine, rate, acceleration; // of a
    };
    Now at(double t) const {
        const test::Jacobi j =
            test::jacobi(std::comp_ellint_1(modulus()) - speed() * t, modulus()); // sn = cos(a/2)
        const double sine = 2 * j.sn * j.cn, cosine = j.sn * j.sn - j.cn * j.cn;
        return {sine, cosine, 2 * speed() * j.dn, pull * sine};
    }
};

/// a'' = pull sin a about its lowest point a = pi, from rest at pi - amplitude: sin(theta/2) = k sn(K - W t).
struct Swing {
    double pull, amplitude; // 1/s^2, rad
    double modulus() const { return std::sin(amplitude / 2); }
    double period() const { return 4 * std::comp_ellint_1(modulus()) / std::sqrt(pull); }
    struct Now {
        double theta, rate; // from the lowest point, positive at the start; rad/s
    };
    Now at(double t) const {
        const double k = modulus(), w = std::sqrt(pull);
        const test::Jacobi j = test::jacobi(std::comp_ellint_1(k) - w * std::fmod(t, period()), k);
        return {2 * std::asin(k * j.sn), -2 * k * w * j.cn};
    }
};

/// A symmetric top with a fixed point, released while it spins about its own axis: with u = cos(tilt),
/// u'^2 = b (u0 - u)(u - u1)(u3 - u), b = 2 m g l / A (A: about the fixed point), and
/// azimuth' = s (u0 - u)/(1 - u^2), s = C spin / A. Landau & Lifshitz, Mechanics, section 35.
class ReleasedTop {
  public:
    ReleasedTop(double b, double s, double tilt) : b_(b), s_(s), u0_(std::cos(tilt)) {
        const double square = 1 - u0_ * u0_, half = s * s - 2 * b * u0_;
        fall_ = 2 * b * square / (half + std::sqrt(half * half + 4 * b * b * square));
        above_ = square / fall_;
    }
    double nutation_period() const { return 2 * std::comp_ellint_1(modulus()) / rate(); }
    double cosine(double t) const {
        const double full = 4 * std::comp_ellint_1(modulus());
        const test::Jacobi j = test::jacobi(std::fmod(full / 4 + rate() * t, full), modulus());
        return u0_ - fall_ * (1 - j.sn * j.sn);
    }
    /// The azimuth by Simpson's rule, from one time to a later one.
    double azimuth(double from, double to) const {
        const int n = 2 * static_cast<int>(std::ceil(50 * (to - from) / nutation_period()) + 1);
        const double h = (to - from) / n;
        double sum = 0;
        for (int i = 0; i <= n; ++i)
            sum += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * precession(from + i * h);
        return sum * h / 3;
    }

  private:
    double modulus() const { return std::sqrt(fall_ / (fall_ + above_)); }
    double rate() const { return std::sqrt(b_ * (fall_ + above_)) / 2; }
    double precession(double t) const {
        const double u = cosine(t);
        return s_ * (u0_ - u) / (1 - u * u);
    }
    double b_, s_, u0_;
    double fall_, above_; // u0 - u1, u3 - u0
};

} // namespace gudgeon::hard
