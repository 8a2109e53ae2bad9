// Lankarani & Nikravesh (AP 43, AU 13): f = K d^n (1 + chi rho), chi = 3 (1 - e^2) / 4 (units, sign and
// singular cases: hysteretic.hpp). Derived for e near 1: 0.9 / 0.5 / 0.3 comes out 0.913 / 0.725 / 0.684.
#pragma once

#include "contact/laws/hysteretic.hpp"

namespace gudgeon {

struct LankaraniNikravesh : Hysteretic {
    LankaraniNikravesh(double stiffness, double exponent, double restitution)
        : Hysteretic{{stiffness, exponent}, 0.75 * (1 - restitution * restitution)} {}
};

} // namespace gudgeon
