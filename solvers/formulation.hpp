// The two formulations of the implicit integrators' linear systems K (du, dlambda) = (f, g).
//
// saddle-point: sparse LU of K by KLU (klu_solver.hpp). augmented-lagrangian: Cholesky of the leading block
// and its penalised constraints by CHOLMOD, with passes on the residual of K (augmented_solver.hpp). The
// equations, residuals and error control are the same; solutions differ by the tolerance of the passes.
#pragma once

#include "core/system.hpp"
#include "solvers/integrator.hpp"
#include "solvers/linear_solver.hpp"

#include <memory>

namespace gudgeon {

/// What `automatic` means for a system; other words stay. Measured (solvers/README.md): on chains and trees
/// KLU is ahead; where many closed loops fill the factors, CHOLMOD is, by up to six times. So the entries
/// that L will have per unknown of the leading block decide.
Formulation formulation_for(const System& system, Formulation asked);

/// Not yet analysed; formulation is not automatic.
std::unique_ptr<LinearSolver> make_saddle_solver(const System& system, Formulation formulation);

} // namespace gudgeon
