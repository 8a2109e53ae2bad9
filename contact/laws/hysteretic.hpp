// Common form of the laws with hysteresis damping:
//   f = K d^n (1 + chi rho) >= 0,   rho = d' / d'(-)
// d depth (m), d' its rate (m/s, > 0 approaching), d'(-) the rate at the start of the contact, chi from the
// restitution. With d'(-) known and no other force the restitution that comes out depends on chi alone, not
// on mass, K, n or speed; for Lankarani-Nikravesh and Hunt-Crossley it is not the one that went in, except
// near 1. Stored: K d^(n+1) / (n+1); the rest, K d^n chi rho, dissipates.
//
// Singular cases (safeguard after AP 43):
// * rho is at most 1: the law has no more damping than at its start.
// * d'(-) < 1e-9 m/s: rho = 1 for ever. The law is then elastic with the stiffness K (1 + chi), stores with
//   that factor and dissipates nothing. A gap of zero clearance starts like that: the law is ill-posed there.
// * d'(-) not known yet (negative): rho = 1 while approaching, as at the start, and 0 while leaving (1 would
//   make energy there). The force jumps by chi K d^n at d' = 0; the step control keeps such depths tiny.
// * Where rho < -1/chi the formula would pull: the force is zero, what was stored is being lost.
// A contact that never ends keeps its first d'(-) for ever.
#pragma once

#include "contact/indentation.hpp"
#include "contact/laws/power.hpp"

namespace gudgeon {

inline constexpr double least_start_speed = 1e-9; // m/s

struct Hysteretic {
    PowerLaw elastic;
    double chi = 0; // >= 0

    /// What the elastic part is multiplied with in a contact that began at this speed: 1 or 1 + chi.
    double elastic_factor(double start_speed) const {
        return start_speed >= 0 && start_speed < least_start_speed ? 1 + chi : 1;
    }

    NormalForce operator()(const Indentation& c) const {
        if (!(c.depth > 0))
            return {};
        const CurveValue e = elastic(c.depth);
        const double factor = elastic_factor(c.start_speed);
        NormalForce out{0, 0, 0, factor * e.value, factor * e.integral};
        double hysteresis = 0, by_rate = 0; // chi rho
        if (c.start_speed < 0) {
            hysteresis = c.rate >= 0 ? chi : 0;
        } else if (c.start_speed < least_start_speed || c.rate >= c.start_speed) {
            hysteresis = chi;
        } else {
            by_rate = chi / c.start_speed;
            hysteresis = by_rate * c.rate;
        }
        if (1 + hysteresis <= 0)
            return out;
        out.force = e.value * (1 + hysteresis);
        out.by_depth = e.slope * (1 + hysteresis);
        out.by_rate = e.value * by_rate;
        return out;
    }
};

} // namespace gudgeon
