// Jacobi's elliptic functions, for closed forms of pendulums and tops.
#pragma once

#include <array>
#include <cmath>

namespace gudgeon::test {

struct Jacobi {
    double sn, cn, dn;
};

/// Modulus k, 0 <= k < 1, by the arithmetic-geometric mean (Abramowitz & Stegun 16.4).
inline Jacobi jacobi(double u, double k) {
    std::array<double, 16> a{1}, c{k};
    double b = std::sqrt(1 - k * k);
    int n = 0;
    for (; n < 15 && std::abs(c[n]) > 1e-17; ++n) {
        a[n + 1] = 0.5 * (a[n] + b);
        c[n + 1] = 0.5 * (a[n] - b);
        b = std::sqrt(a[n] * b);
    }
    double phi = std::ldexp(a[n] * u, n);
    for (; n > 0; --n)
        phi = 0.5 * (phi + std::asin(c[n] * std::sin(phi) / a[n]));
    return {std::sin(phi), std::cos(phi), std::sqrt(1 - k * k * std::sin(phi) * std::sin(phi))};
}

} // namespace gudgeon::test
