// Sparse Cholesky of the normal equations of constraint rows by CHOLMOD (Davis).
#pragma once

#include "solvers/linear_solver.hpp"

#include <memory>

namespace gudgeon {

/// Factors N = B B^T + beta I, B a sparse m x n matrix: constraint rows times the inverse square root of the
/// mass matrix for projections in the mass norm, N then being G M^-1 G^T. Simplicial LDL^T, minimum degree
/// ordering; with GUDGEON_GPL_CHOLMOD CHOLMOD may choose its supernodal factorisation.
/// The pattern of N is formed once, and N is scaled by powers of two to a diagonal near one.
/// After the first factor() and solve() neither allocates
/// (simplicial).
class NormalSolver {
  public:
    NormalSolver();
    ~NormalSolver();
    NormalSolver(const NormalSolver&) = delete;
    NormalSolver& operator=(const NormalSolver&) = delete;

    /// Throws std::invalid_argument unless the pattern is well formed. No rows are fine.
    void analyse(CscPattern b);

    /// One value per entry of B; beta >= 0 in the unit of B B^T.
    /// Singular: status.column is a row of B that repeats others (a pivot below smallest_pivot of the
    /// largest, or not positive). Non-finite: status.column is a column of B with a bad value, or -1 for a
    /// bad beta.
    FactorStatus factor(std::span<const double> values, double beta = 0, double smallest_pivot = 1e-13);

    /// N x = rhs in place, m entries. Throws std::logic_error unless the last factor() was ok.
    void solve(std::span<double> rhs);

    /// Pivot of a row of B in the last factorisation, in the unit of B B^T.
    double pivot(int row) const;

    /// factorisations counts the first one, refactorisations the later ones; pivots are never exchanged.
    const LinearSolverCounts& counts() const;
    /// Entries of L, diagonal included.
    long factor_nonzeros() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
