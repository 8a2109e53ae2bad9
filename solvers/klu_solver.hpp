// Sparse LU of the saddle-point matrix by KLU (Davis & Palamadai Natarajan 2010).
#pragma once

#include "core/archive.hpp"
#include "solvers/linear_solver.hpp"

#include <memory>
#include <vector>

namespace gudgeon {

struct KluOptions {
    /// A diagonal pivot is taken if it is at least this share of the largest candidate in its column.
    /// Larger is more accurate and fills more.
    double pivot_tolerance = 1e-3;
    /// Largest number of corrections per solve; each is skipped when the solution is at round-off already.
    int refinements = 1;
    /// A refactorisation whose pivots grow beyond this (and beyond 10 times the growth of the last full
    /// factorisation) is thrown away for a full one. Refinement repairs about growth * 1e-16.
    double largest_growth = 1e7;
    /// A matrix with a suspiciously small pivot is singular if the condition number (1-norm, equilibrated,
    /// estimated) exceeds this: fewer than two digits of a solution would be right.
    double largest_condition = 4e13;
};

/// For [A G^T; G 0], symmetric pattern or not. No block triangular form, no scaling inside KLU: the matrix
/// is equilibrated by powers of two (solvers/equilibration.hpp) at each full factorisation and those are
/// kept while its pivots serve. factor() refactors with the old pivots and falls back to a full
/// factorisation when they fail. All right-hand sides of one solve() go through the factors together.
///
/// Up to 4000 unknowns two orderings are tried at the first factorisation and the one with less work is kept:
/// minimum degree on the unknowns, and on pairs of multiplier and constrained unknown
/// (solvers/saddle_ordering.hpp), better where bodies carry many joints; larger systems take the latter. A
/// given ordering replaces both.
///
/// After the first full factorisation and the first solve of as many columns, a refactorisation and a
/// solve allocate nothing.
class KluSolver : public LinearSolver {
  public:
    explicit KluSolver(KluOptions options = {});
    ~KluSolver() override;

    /// Order of elimination: perm[k] is the unknown (row and column) eliminated k-th. Takes effect at the
    /// next analyse(), which throws std::invalid_argument unless it is a permutation; empty: own ordering.
    void set_ordering(std::vector<int> perm);

    /// The next factor() chooses new pivots whatever the old ones are worth.
    void forget_pivots();

    /// After analyse() of the same pattern. Loading repeats what made the present factors (the full
    /// factorisation that chose the pivots, then the last refactorisation), which gives the same bits.
    void visit(Archive& archive);

    void analyse(const CscPattern& pattern) override;
    FactorStatus factor(std::span<const double> values) override;
    void solve(std::span<double> rhs, int columns = 1) override;
    const LinearSolverCounts& counts() const override;
    long factor_nonzeros() const override;
    const char* name() const override { return "klu"; }

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
