// K d^n: the elastic part of most normal laws.
#pragma once

#include "core/curve.hpp"

#include <cmath>

namespace gudgeon {

/// Force K d^n (N) at the depth d >= 0 (m), its slope (N/m) and its integral from 0 (J); n >= 1, so that the
/// slope is finite at 0 (it is K there for n = 1).
struct PowerLaw {
    double stiffness = 0; // N/m^n
    double exponent = 1;

    CurveValue operator()(double depth) const {
        const double slope_power = exponent == 1.5   ? std::sqrt(depth)
                                   : exponent == 1.0 ? 1.0
                                                     : std::pow(depth, exponent - 1);
        const double value = stiffness * slope_power * depth;
        return {value, exponent * stiffness * slope_power, value * depth / (exponent + 1)};
    }
};

} // namespace gudgeon
