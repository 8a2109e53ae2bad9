// Linear solver by block elimination (block_factors.hpp), for saddle-point matrices of mechanisms. KLU takes
// over where it may fail.
#pragma once

#include "solvers/block_factors.hpp"
#include "solvers/complex_klu_solver.hpp"
#include "solvers/klu_solver.hpp"

#include <complex>
#include <memory>
#include <type_traits>

namespace gudgeon {

struct BlockOptions {
    int threads = 1;
    /// Factors in single precision where pivots are large (block_factors.hpp): for solutions that are mended
    /// by residuals formed anew.
    bool single_precision = false;
    bool always_klu = false; // for comparison
};

/// KLU takes patterns for which blocks are much more work (block_structure()). Else it factors instead, and
/// is counted (klu_fallbacks, and as a factorisation), where a front has no pivot or a suspiciously small one
/// or a probe is solved badly. KLU decides whether such a matrix is singular.
template <class Scalar> class BlockSolverOf {
  public:
    explicit BlockSolverOf(BlockOptions options = {}) : options_(options) {}

    void analyse(const CscPattern& pattern);
    /// The pattern of another solver, whose structure is shared.
    void analyse(std::shared_ptr<const BlockStructure> structure);
    FactorStatus factor(std::span<const Scalar> values);
    void solve(std::span<Scalar> rhs, int columns);
    const LinearSolverCounts& counts() const;
    long factor_nonzeros() const;
    const char* name() const { return by_klu_ ? "klu" : "block"; }
    void visit(Archive& archive);
    std::shared_ptr<const BlockStructure> shared_structure() const;

  private:
    using Klu = std::conditional_t<std::is_same_v<Scalar, double>, KluSolver, ComplexKluSolver>;

    FactorStatus factor_by_klu(std::span<const Scalar> values);
    void make_klu(const CscPattern& pattern);

    BlockOptions options_;
    int unknowns_ = 0, entries_ = 0;
    std::unique_ptr<BlockFactors<Scalar>> factors_;
    std::unique_ptr<Klu> klu_;          // made when first needed
    bool by_klu_ = options_.always_klu; // all matrices of the pattern
    bool klu_in_use_ = false, factored_ = false;
    LinearSolverCounts counts_;
};

using ComplexBlockSolver = BlockSolverOf<std::complex<double>>;

class BlockSolver : public LinearSolver {
  public:
    explicit BlockSolver(BlockOptions options = {}) : solver_(options) {}

    void analyse(const CscPattern& pattern) override { solver_.analyse(pattern); }
    FactorStatus factor(std::span<const double> values) override { return solver_.factor(values); }
    void solve(std::span<double> rhs, int columns = 1) override { solver_.solve(rhs, columns); }
    const LinearSolverCounts& counts() const override { return solver_.counts(); }
    long factor_nonzeros() const override { return solver_.factor_nonzeros(); }
    const char* name() const override { return solver_.name(); }
    void visit(Archive& archive) { solver_.visit(archive); }
    std::shared_ptr<const BlockStructure> shared_structure() const { return solver_.shared_structure(); }

  private:
    BlockSolverOf<double> solver_;
};

} // namespace gudgeon
