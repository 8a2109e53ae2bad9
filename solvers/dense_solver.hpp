// Dense LU with complete pivoting: slow, reliable; the oracle the sparse solvers are tested against.
#pragma once

#include "solvers/linear_solver.hpp"

#include <memory>

namespace gudgeon {

/// Cost n^3: for small systems. Singular means a pivot below 1e-14 n of the largest one of the
/// equilibrated matrix (solvers/equilibration.hpp).
class DenseSolver : public LinearSolver {
  public:
    DenseSolver();
    ~DenseSolver() override;
    void analyse(const CscPattern& pattern) override;
    FactorStatus factor(std::span<const double> values) override;
    void solve(std::span<double> rhs, int columns = 1) override;
    const LinearSolverCounts& counts() const override;
    long factor_nonzeros() const override;
    const char* name() const override { return "dense"; }

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
