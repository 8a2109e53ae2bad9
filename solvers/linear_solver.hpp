// Direct solvers for square sparse systems A x = b: analyse a pattern once, factor values often.
#pragma once

#include "core/sparse.hpp"

#include <span>

namespace gudgeon {

/// Outcome of a factorisation. Never an exception: an integrator meets bad matrices in normal work.
struct FactorStatus {
    enum class Kind { ok, singular, non_finite };
    Kind kind = Kind::ok;
    /// singular: an unknown (column of A) without a usable pivot; non_finite: first column with a bad entry.
    int column = -1;
    bool ok() const { return kind == Kind::ok; }
};

struct LinearSolverCounts {
    long analyses = 0;
    long factorisations = 0;     // full, with a new choice of pivots
    long refactorisations = 0;   // with the pivots (blocks: the storage) of the last full one, and accepted
    long solves = 0;             // right-hand sides
    long refinements = 0;        // corrections by iterative refinement, per right-hand side
    int off_diagonal_pivots = 0; // of the last full factorisation
    double worst_growth = 0;     // largest max|U(:,k)| / max|A(:,k)| met, of the scaled matrix
    double worst_backward_error = 0; // largest componentwise backward error met before refinement
    long cholmod_factorisations = 0;
    long cholmod_solves = 0;     // right-hand sides
    long cholmod_iterations = 0; // each one pair of triangular solves; two right-hand sides may share them
    long klu_fallbacks = 0;      // factorisations that KLU had to take over from blocks or from CHOLMOD
};

/// One object per matrix pattern and thread; two objects share nothing.
class LinearSolver {
  public:
    virtual ~LinearSolver() = default;
    LinearSolver() = default;
    LinearSolver(const LinearSolver&) = delete;
    LinearSolver& operator=(const LinearSolver&) = delete;

    /// Orders the unknowns. Throws std::invalid_argument unless the pattern is square and well formed.
    virtual void analyse(const CscPattern& pattern) = 0;

    /// Factors the matrix with these values (one per pattern entry). The values are not referred to later.
    virtual FactorStatus factor(std::span<const double> values) = 0;

    /// Solves in place for n x columns right-hand sides, stored column by column.
    /// Throws std::logic_error unless the last factor() was ok.
    virtual void solve(std::span<double> rhs, int columns = 1) = 0;

    virtual const LinearSolverCounts& counts() const = 0;

    /// Entries of L and U together, both diagonals counted; 0 before the first factorisation.
    virtual long factor_nonzeros() const = 0;

    virtual const char* name() const = 0;
};

/// Throws std::invalid_argument unless the pattern is consistent (sizes, order and range of indices).
void check_pattern(const CscPattern& pattern);

} // namespace gudgeon
