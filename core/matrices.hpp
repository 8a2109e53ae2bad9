// Parts of the equations of motion as sparse matrices, for other programs and for tests.
#pragma once

#include "core/assembly.hpp"

namespace gudgeon {

/// G (rows x velocities) from ws.rows.
CscMatrix rows_as_matrix(const System& system, const Workspace& ws);

/// The mass matrix (velocities x velocities).
CscMatrix mass_matrix(const System& system);

/// 3 x 3 blocks (ws.lin.C or ws.lin.S) as a matrix (velocities x velocities).
CscMatrix blocks_as_matrix(const System& system, const std::vector<double>& blocks);

} // namespace gudgeon
