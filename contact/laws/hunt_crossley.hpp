// Hunt & Crossley (J. Appl. Mech. 42, 1975): f = K d^n (1 + chi rho), chi = 3 (1 - e) / 2 (units, sign and
// singular cases: hysteretic.hpp). Derived for e near 1.
#pragma once

#include "contact/laws/hysteretic.hpp"

namespace gudgeon {

struct HuntCrossley : Hysteretic {
    HuntCrossley(double stiffness, double exponent, double restitution)
        : Hysteretic{{stiffness, exponent}, 1.5 * (1 - restitution)} {}
};

} // namespace gudgeon
