// Elastic characteristic with viscous damping (AP 49): f = e(d) + c d', clipped at zero (it never pulls).
// d depth (m), d' rate (m/s, > 0 approaching), c >= 0 in N s/m. Stored: the integral of e; dissipated: c
// d'^2, and where the force is clipped what was stored. With c > 0 the force begins and ends with a jump of c
// d' at d = 0.
#pragma once

#include "contact/indentation.hpp"
#include "core/curve.hpp"

namespace gudgeon {

inline NormalForce damped_force(const CurveValue& e, double damping, double rate) {
    NormalForce out{0, 0, 0, e.value, e.integral};
    const double force = e.value + damping * rate;
    if (force <= 0)
        return out;
    out.force = force;
    out.by_depth = e.slope;
    out.by_rate = damping;
    return out;
}

} // namespace gudgeon
