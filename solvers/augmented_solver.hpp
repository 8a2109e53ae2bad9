// The saddle-point matrix K = [A U; G -E] solved as an augmented Lagrangian on CHOLMOD.
//
// K (du, dlambda) = (f, g) is kept as it is; what is factored is the positive definite
//
//   H = (A + A^T) / 2 + G^T W G,   W = (E + 1 / alpha)^-1,
//
// by L D L^T. One pass is the method of multipliers (Hestenes 1969, Powell 1969; Bayo & Ledesma 1996 for
// multibody systems):
//
//   du = H^-1 (f + G^T W g),   dlambda = W (G du - g),
//
// which is the exact solution of [sym A, G^T; G, -E - 1/alpha]. Passes on the residual of K converge by
// 1 / (1 + alpha s), s the eigenvalues of G A^-1 G^T, where A is symmetric and U = G^T; here they are
// accelerated as flexible GMRES on the true residual of K (gmres.hpp), which also brings back the skew part
// of A (gyroscopic terms, friction, contact damping) and U - G^T (friction that reactions press on).
//
// K is scaled by powers of two first, so that sym A has a diagonal near one and G rows of length near one:
// alpha is relative to that, and a constraint between light bodies weighs as much as one between heavy ones.
// Rows that repeat each other are harmless where the right-hand side is consistent: the passes never leave
// the range of G, so the multipliers are those of least norm (in the scaled unit).
//
// KLU takes over for a factorisation where H is not positive definite or where the residual does not fall
// fast enough, and for the next ones too if that repeats (1, 2, 4, ... 64 of them, then H is tried again).
#pragma once

#include "solvers/linear_solver.hpp"

#include <complex>
#include <memory>

namespace gudgeon {

struct AugmentedOptions {
    /// Relative to the scaled matrix. Larger: fewer passes; round-off of a pass is about alpha * 1e-16.
    double penalty = 1e8;
    /// Of the scaled residual, per right-hand side.
    double tolerance = 1e-10;
    /// More passes than this: KLU.
    int most_passes = 25;
};

/// Real matrices. After the first factor() and solve() neither allocates, but where a solve needs more
/// passes than any before or KLU is called for the first time.
class AugmentedSolver : public LinearSolver {
  public:
    /// leading: order of A; throws std::invalid_argument in analyse() unless the pattern is as large.
    explicit AugmentedSolver(int leading, AugmentedOptions options = {});
    ~AugmentedSolver() override;

    void analyse(const CscPattern& pattern) override;
    FactorStatus factor(std::span<const double> values) override;
    void solve(std::span<double> rhs, int columns = 1) override;

    /// One pass alone in place of a solution, one right-hand side: what the classical method takes per
    /// iteration. Throws std::logic_error where the last factorisation was taken over by KLU.
    void pass(std::span<double> rhs);
    /// The last factor() was CHOLMOD's and has served so far.
    bool factored_by_cholmod() const;

    const LinearSolverCounts& counts() const override;
    /// Of L (known after analyse()), or of KLU where that is in use.
    long factor_nonzeros() const override;
    const char* name() const override { return "cholmod"; }

  private:
    friend class AugmentedPairSolver;
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Complex matrices K(s) = [s M + C + S/s, U; G, -E] beside a real K(sigma) of the same derivatives, which an
/// AugmentedSolver has factored. CHOLMOD factors no complex symmetric matrix (Hermitian ones only), so the
/// real factor serves as the preconditioner: with c = s / sigma,
///
///   K(s) = [c (sigma M + C/c + S/(sigma c^2)), U; G, -E]  is near  [c H_sigma, G^T; G, -E / c],
///
/// one pass being u = 1/c v, (v, lambda) = the real pass on (f, c g). GMRES on the true complex residual
/// converges at once where sigma M rules, and slowly (by about 0.45 a pass at worst) where many modes of S
/// have frequencies near |s|: stiff bushings. KLU takes over as in AugmentedSolver.
class AugmentedPairSolver {
  public:
    /// With the options of `real`, which must outlive it.
    explicit AugmentedPairSolver(const AugmentedSolver& real);
    ~AugmentedPairSolver();

    void analyse(const CscPattern& pattern);
    /// The real matrix has been factored for the same derivatives; ratio = s / sigma.
    FactorStatus factor(std::span<const std::complex<double>> values, std::complex<double> ratio);
    /// In place, n x columns, column by column.
    void solve(std::span<std::complex<double>> rhs, int columns);
    const LinearSolverCounts& counts() const;
    /// Of KLU where that is in use; the real factors are counted by their owner.
    long factor_nonzeros() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
