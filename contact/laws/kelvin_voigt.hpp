// Modified Kelvin-Voigt (AP 54; its first and third case are restitution and compression):
//   f = K d [e + (1 - e) s(r)],   r = d' / v0
//   s = 0 for d' <= 0 (restitution), 3 r^2 - 2 r^3 for 0 < d' < v0, 1 for d' >= v0 (compression)
// d depth (m), d' rate (m/s, > 0 approaching), K in N/m, v0 > 0 in m/s, 0 < e <= 1. Never pulls.
// Stored: K e d^2 / 2, the force while leaving; the rest, K d (1 - e) s >= 0, acts only while approaching, so
// the dissipated power is never negative. The speed ratio that comes out is about sqrt(e), and less for
// approaches not well above v0. Under a steady load W > K d e the contact creeps in, ever slower:
// there is no other resting place than d = W / (K e).
#pragma once

#include "contact/indentation.hpp"

namespace gudgeon {

struct KelvinVoigt {
    double stiffness = 0;   // N/m
    double restitution = 1; // e
    double speed = 1;       // v0

    NormalForce operator()(const Indentation& c) const {
        if (!(c.depth > 0))
            return {};
        double s = 0, by_r = 0;
        if (c.rate >= speed) {
            s = 1;
        } else if (c.rate > 0) {
            const double r = c.rate / speed;
            s = r * r * (3 - 2 * r);
            by_r = 6 * r * (1 - r);
        }
        const double full = stiffness * c.depth;
        const double share = restitution + (1 - restitution) * s;
        const double elastic = full * restitution;
        return {full * share, stiffness * share, full * (1 - restitution) * by_r / speed, elastic,
                elastic * c.depth / 2};
    }
};

} // namespace gudgeon
