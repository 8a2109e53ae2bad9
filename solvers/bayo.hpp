// Index-3 augmented Lagrangian with projections, fixed step: the method of Bayo & Ledesma, for comparison
// with the literature.
//
// E. Bayo and R. Ledesma, Augmented Lagrangian and mass-orthogonal projection methods for constrained
// multibody dynamics, Nonlinear Dynamics 9 (1996) 113-130. Its equations (notation of core/README.md),
//
//   M u' + G^T (lambda* + alpha Phi) = f,      lambda*_{i+1} = lambda*_i + alpha Phi_{i+1},
//
// with the trapezoidal rule (Newmark's average acceleration), here for bodies that turn:
//
//   q_{n+1} = q_n moved by z along T(q),  z = h/2 (u_n + u_{n+1}),   u_{n+1} = u_n + h/2 (u'_n + u'_{n+1}),
//
// z holding a displacement and a rotation vector in the body frame. Each iteration solves
//
//   (2/h M + C + h/2 (S + G^T alpha G)) Delta u = f - M u' - G^T (lambda* + alpha Phi),  Delta z = h/2 Delta
//   u,
//
// by CHOLMOD on the symmetric part, and then adds alpha Phi to lambda*: one pass of the method of multipliers
// (augmented_solver.hpp) per iteration, until displacements and Phi are at round-off; where that is slow
// (large skew parts), or the matrix is not positive definite, the same linear system is solved to the end
// instead. Velocities and accelerations are then projected in the mass norm,
//
//   (M + G^T alpha G) u  = M u*  - G^T alpha dPhi/dt,
//   (M + G^T alpha G) u' = M u'* - G^T alpha (dG/dt u + dPhi'/dt),
//
// with multipliers until G u + dPhi/dt and G u' - gamma vanish (the limit of the paper's iteration).
//
// The multipliers of the last projection are added to lambda*, so that reactions belong to the projected
// motion and have order 2 (lambda* alone: 1); the next step starts its iteration from them.
//
// alpha: one per row, the same number times the inertia that the row feels (1 / alpha of the scaled matrix,
// see augmented_solver.hpp), so units and mass ratios do not matter; the converged result does not depend on
// it. Rows that repeat each other need no care. Order 2 in positions and velocities. Friction states follow
// the trapezoidal rule too.
//
// A step whose iteration does not converge stops the run. Contacts and dense output: fixed_step.hpp.
#pragma once

#include "solvers/integrator.hpp"

namespace gudgeon {

/// Options as in fixed_step.hpp.
std::unique_ptr<Integrator> make_bayo(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
