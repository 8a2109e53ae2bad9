// The matrix [a M + C + s S, G^T; G, 0] of a mechanism at rest, factored and solved by KLU, with the rows of
// G that repeat others taken out: statics and modes use it.
#pragma once

#include "core/assembly.hpp"
#include "solvers/klu_solver.hpp"

#include <vector>

namespace gudgeon {

class ConstrainedMatrix {
  public:
    /// dependent: rows that repeat others (RedundancyReport); their multipliers come out as zero.
    ConstrainedMatrix(const System& system, const std::vector<int>& dependent);

    /// Of ws.lin and ws.rows; friction states and forces that depend on multipliers are left out.
    FactorStatus factor(const Workspace& ws, double a, double s);
    /// [M, G^T; G, 0] of ws.rows.
    FactorStatus factor_mass(const Workspace& ws);

    /// Solves for (x, multipliers) of the right-hand side (force, residual); force and residual are replaced.
    void solve(VecX& force, VecX& residual);
    /// Several right-hand sides at once: force is velocities x columns, nothing on the constraints.
    void solve(MatX& force);

    const LinearSolverCounts& counts() const { return klu_.counts(); }
    const std::vector<int>& dependent() const { return dependent_; }

  private:
    FactorStatus factor_values();

    const System& system_;
    SaddleMatrix saddle_;
    KluSolver klu_;
    std::vector<int> dependent_, slot_, cleared_, unit_;
    std::vector<double> values_, kept_;
    std::vector<double> rhs_;
};

} // namespace gudgeon
