// Sparse LU of complex saddle-point matrices by KLU (Davis & Palamadai Natarajan 2010).
#pragma once

#include "core/archive.hpp"
#include "solvers/linear_solver.hpp"

#include <complex>
#include <memory>

namespace gudgeon {

/// The complex counterpart of KluSolver: same scaling by powers of two (of the magnitudes), same two
/// orderings to choose from, refactorisation while the pivots serve. No refinement.
class ComplexKluSolver {
  public:
    ComplexKluSolver();
    ~ComplexKluSolver();
    ComplexKluSolver(const ComplexKluSolver&) = delete;
    ComplexKluSolver& operator=(const ComplexKluSolver&) = delete;

    void analyse(const CscPattern& pattern);
    /// As KluSolver::visit.
    void visit(Archive& archive);
    FactorStatus factor(std::span<const std::complex<double>> values);
    /// In place, n x columns, column by column.
    void solve(std::span<std::complex<double>> rhs, int columns);
    const LinearSolverCounts& counts() const;
    long factor_nonzeros() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
