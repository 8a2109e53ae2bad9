// Pereira, Ramalho & Ambrosio: cylinder in a cylindrical bearing (AP 44-48, internal contact)
//   f = (a dR + b) L E* / dR  d^n (1 + chi rho),   chi = 3 (1 - e^2) / 4,   a = 0.965, b = 0.0965
//   n = Y dR^-0.005,  Y = 1.51 ln(1000 dR)^-0.151 below dR = 0.34954 mm, 0.0151 dR + 1.151 above
// dR radial clearance, L length of the bearing. The fit holds with mm and MPa only and for
// dR = 0.005 ... 10 mm; here everything outside this file is SI: K in N/m^n of the whole bearing (one strip
// of N: K/N). Sign and singular cases: hysteretic.hpp.
#pragma once

#include "contact/laws/hysteretic.hpp"

#include <cmath>

namespace gudgeon {

struct Cylinder : Hysteretic {
    Cylinder(double stiffness, double exponent, double restitution)
        : Hysteretic{{stiffness, exponent}, 0.75 * (1 - restitution * restitution)} {}

    /// Is this radial clearance (m) one the fit knows?
    static bool knows(double clearance) {
        constexpr double round_off = 1e-12;
        return clearance >= 5e-6 * (1 - round_off) && clearance <= 1e-2 * (1 + round_off);
    }

    /// n; the clearance (m) must be one the fit knows.
    static double exponent_of(double clearance) {
        const double mm = 1e3 * clearance;
        const double y = mm < 0.34954 ? 1.51 * std::pow(std::log(1000 * mm), -0.151) : 0.0151 * mm + 1.151;
        return y * std::pow(mm, -0.005);
    }

    /// K in N/m^n; modulus E* in Pa (hertz.hpp), length and clearance in m.
    static double stiffness_of(double modulus, double length, double clearance) {
        const double mm = 1e3 * clearance;
        const double per_mm = (0.965 * mm + 0.0965) * (1e3 * length) * (1e-6 * modulus) / mm; // N/mm^n
        return per_mm * std::pow(1e3, exponent_of(clearance));
    }
};

} // namespace gudgeon
