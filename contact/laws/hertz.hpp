// Hertz: f = K d^n, n = 3/2 for spheres; d depth (m), f >= 0 pushes apart. Elastic: nothing is dissipated.
// Lankarani & Nikravesh (Nonlinear Dynamics 5, 1994); AP 43 without its bracket.
#pragma once

#include "contact/laws/hysteretic.hpp"

#include <cmath>

namespace gudgeon {

struct Hertz : Hysteretic {
    Hertz(double stiffness, double exponent) : Hysteretic{{stiffness, exponent}, 0} {}
};

/// Composite modulus E* (Pa): 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
inline double composite_modulus(double young1, double poisson1, double young2, double poisson2) {
    return 1 / ((1 - poisson1 * poisson1) / young1 + (1 - poisson2 * poisson2) / young2);
}

/// K of a ball in a socket, N/m^1.5 (AP 43): 4/3 E* sqrt(Ri Rj / dR); modulus in Pa, radii and clearance
/// dR > 0 in m.
inline double socket_stiffness(double modulus, double bearing_radius, double journal_radius,
                               double clearance) {
    return 4.0 / 3.0 * modulus * std::sqrt(bearing_radius * journal_radius / clearance);
}

} // namespace gudgeon
