// Linear: f = K d + c d' (damped.hpp), K in N/m.
#pragma once

#include "contact/laws/damped.hpp"
#include "contact/laws/power.hpp"

namespace gudgeon {

struct Linear {
    double stiffness = 0; // N/m
    double damping = 0;   // N s/m

    NormalForce operator()(const Indentation& c) const {
        if (!(c.depth > 0))
            return {};
        return damped_force(PowerLaw{stiffness, 1}(c.depth), damping, c.rate);
    }
};

} // namespace gudgeon
