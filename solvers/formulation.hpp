// The formulations of the implicit integrators' linear systems K (du, dlambda) = (f, g).
//
// saddle-point: block elimination of K (block_solver.hpp); saddle-point-klu: its sparse LU by KLU
// (klu_solver.hpp). augmented-lagrangian: Cholesky of the leading block
// and its penalised constraints by CHOLMOD, with passes on the residual of K (augmented_solver.hpp). The
// equations, residuals and error control are the same; solutions differ by the tolerance of the passes.
#pragma once

#include "core/system.hpp"
#include "solvers/block_solver.hpp"
#include "solvers/integrator.hpp"
#include "solvers/linear_solver.hpp"

#include <memory>

namespace gudgeon {

/// What `automatic` means for a system; other words stay. Measured (solvers/README.md): on chains, trees,
/// ladders of loops and small nets blocks are ahead; where many closed loops fill the factors, CHOLMOD is. So
/// the entries that L will have per unknown of the leading block decide.
Formulation formulation_for(const System& system, Formulation asked);

/// Of the saddle-point formulations, by blocks or by KLU.
BlockOptions saddle_options(Formulation formulation, int threads);

/// Not yet analysed; formulation is not automatic.
std::unique_ptr<LinearSolver> make_saddle_solver(const System& system, Formulation formulation,
                                                 int threads = 1);

} // namespace gudgeon
