// Elastic part of springs and bushings: linear, or a table.
#pragma once

#include "core/curve.hpp"

namespace gudgeon {

/// Restoring force (N or N m), stiffness and stored energy (J) at the displacement x (m or rad) from
/// the free state; the table, where there is one, replaces the stiffness.
inline CurveValue elastic_law(double stiffness, const Spline* table, double x) {
    if (table)
        return (*table)(x);
    return {stiffness * x, stiffness, 0.5 * stiffness * x * x};
}

} // namespace gudgeon
