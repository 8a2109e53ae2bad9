// Newton's method of the exact steps of Gear and Radau (StageMatrix). Internal to their .cpp files.
#pragma once

#include "solvers/implicit_integrator.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/stage_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

/// linearise(): residuals and derivatives of all stages into the matrix, phi_worst_ and rate_worst_. apply():
/// takes its solution over, sets increment_; false: the motion cannot follow. Counts into iterations.
/// Converged: the last increment is small and the constraints are closed as far as they go.
template <class Linearise, class Apply>
ImplicitIntegrator::Corrector ImplicitIntegrator::iterate_exactly(StageMatrix& matrix, int& iterations,
                                                                  Linearise&& linearise, Apply&& apply) {
    constexpr int most_iterations = 12;
    constexpr double target = 1e-2;     // of the error limit, for the last increment
    constexpr double most_growth = 4.0; // of an increment over the one before
    double last = 0, last_open = 0;
    for (iterations = 1; iterations <= most_iterations; ++iterations) {
        linearise();
        const double open = std::max(phi_worst_, rate_worst_);
        if (iterations > 2 && last <= target && open <= closed &&
            (open <= round_off || open > 0.5 * last_open))
            return Corrector::converged;
        last_open = open;
        {
            const PhaseTimer timer(statistics_.seconds.factor);
            const FactorStatus status = matrix.factor();
            if (!status.ok())
                return status.kind == FactorStatus::Kind::non_finite ? Corrector::non_finite
                                                                     : Corrector::slow;
        }
        ++statistics_.newton_sweeps;
        {
            const PhaseTimer timer(statistics_.seconds.solve);
            matrix.solve();
        }
        const bool follows = apply();
        if (!std::isfinite(increment_.norm))
            return Corrector::non_finite;
        if (!follows || (iterations > 3 && increment_.norm > most_growth * last && increment_.norm > target))
            return Corrector::slow;
        last = increment_.norm;
    }
    return Corrector::slow;
}

} // namespace gudgeon
