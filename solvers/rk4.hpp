// Classic Runge-Kutta method of order 4 with a fixed step, on the index-1 form with Baumgarte terms.
//
// Each stage solves (AP 1, AU 8-9)
//
//   M u' + G^T lambda = f,   G u' = gamma - 2 alpha (G u + dPhi/dt) - beta^2 Phi
//
// and q' = T(q) u, Euler parameters by p' = 1/2 L^T omega' and normalised after each step.
//
// The Baumgarte terms take the residuals at the beginning of the step and keep them over its four
// stages. Kept so, with h the step,
//
//   alpha = 3 / (4 h),  beta = 1 / h
//
// takes a violation (Phi, Phi') out in two steps (both eigenvalues of the discrete error equation
// are zero) and keeps the order, since what a step leaves is small of order h^5. Taken anew at each stage
// (AU), whose states are off the constraints by h^2, the terms disturb the solution unless alpha stays far
// below 1/h, and then drift hardly decays. Measured on the ready pendulum over 10 s with h = 0.01 s, |Phi|
// and the error of the last position in m:
//
//   none 3e-5 and 8e-5; at the stages with alpha = beta = 10/s 3e-7 and 2e-5, with 100/s 5e-5 and 9e-4;
//   kept over the step 2e-10 and 1e-7 (h = 0.001 s: below 1e-15 and 1e-10).
//
// Stability: the eigenvalues of the mechanism must keep |h s| below about 2.8; stiff bushings need
// small steps. Contacts and dense output: fixed_step.hpp. Dissipated and input energy: the method's own
// weights on the powers.
#pragma once

#include "solvers/integrator.hpp"

namespace gudgeon {

/// Options as in fixed_step.hpp.
std::unique_ptr<Integrator> make_rk4(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
