// Flores, Machado, Silva & Martins (Multibody Syst. Dyn. 25, 2011): f = K d^n (1 + chi rho),
// chi = 8 (1 - e) / (5 e), e > 0 (units, sign and singular cases: hysteretic.hpp). Meant for all e:
// 0.9 / 0.5 / 0.3 comes out 0.894 / 0.470 / 0.256.
#pragma once

#include "contact/laws/hysteretic.hpp"

namespace gudgeon {

struct Flores : Hysteretic {
    Flores(double stiffness, double exponent, double restitution)
        : Hysteretic{{stiffness, exponent}, 8 * (1 - restitution) / (5 * restitution)} {}
};

} // namespace gudgeon
