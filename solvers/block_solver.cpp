#include "solvers/block_solver.hpp"

#include <algorithm>
#include <stdexcept>

namespace gudgeon {

namespace {
constexpr double suspicious_pivot = 1e-12; // of the scaled matrix
constexpr double small_pivot = 1e-6;       // worth a probe
constexpr double largest_error = 1e-5;     // of a probe's residual: worse costs sweeps

/// The first column with a number that is not finite, -1: none.
template <class Scalar> int bad_column(const BlockStructure& s, std::span<const Scalar> values) {
    Scalar probe = 0; // 0 * x is 0 for finite x only
    for (const Scalar& x : values)
        probe += 0.0 * x;
    if (probe == Scalar(0))
        return -1;
    int first = s.unknowns;
    for (const Front& front : s.fronts)
        s.for_entries(front.entry_start, front.entry_end, [&](int, int col, int slot) {
            if (0.0 * values[slot] != Scalar(0))
                first = std::min(first, s.order[s.unknown(front, col)]);
        });
    return first;
}
} // namespace

template <class Scalar> void BlockSolverOf<Scalar>::analyse(const CscPattern& pattern) {
    check_pattern(pattern);
    if (pattern.rows != pattern.cols)
        throw std::invalid_argument("a square matrix is needed");
    if (!options_.always_klu)
        if (BlockStructure s = block_structure(pattern); !s.fronts.empty() || pattern.cols == 0)
            return analyse(std::make_shared<const BlockStructure>(std::move(s)));
    by_klu_ = true;
    factors_.reset();
    unknowns_ = pattern.cols;
    entries_ = pattern.nonzeros();
    klu_.reset();
    make_klu(pattern);
    klu_in_use_ = factored_ = false;
    ++counts_.analyses;
}

template <class Scalar> void BlockSolverOf<Scalar>::analyse(std::shared_ptr<const BlockStructure> structure) {
    by_klu_ = false;
    unknowns_ = structure->unknowns;
    entries_ = structure->matrix_entries;
    factors_ = std::make_unique<BlockFactors<Scalar>>(std::move(structure), options_.threads,
                                                      options_.single_precision);
    klu_.reset();
    klu_in_use_ = factored_ = false;
    ++counts_.analyses;
}

template <class Scalar> void BlockSolverOf<Scalar>::make_klu(const CscPattern& pattern) {
    if constexpr (std::is_same_v<Scalar, double>)
        klu_ = std::make_unique<Klu>(KluOptions{.refinements = 0});
    else
        klu_ = std::make_unique<Klu>();
    klu_->analyse(pattern);
}

template <class Scalar> FactorStatus BlockSolverOf<Scalar>::factor_by_klu(std::span<const Scalar> values) {
    if (!klu_)
        make_klu(pattern_of(factors_->structure()));
    const FactorStatus status = klu_->factor(values);
    klu_in_use_ = factored_ = status.ok();
    if (status.ok()) {
        ++counts_.factorisations;
        ++counts_.klu_fallbacks;
    }
    return status;
}

template <class Scalar> FactorStatus BlockSolverOf<Scalar>::factor(std::span<const Scalar> values) {
    if (!factors_ && !klu_)
        throw std::logic_error("factor before analyse");
    if (std::ssize(values) != entries_)
        throw std::invalid_argument("one value per pattern entry is needed");
    klu_in_use_ = factored_ = false;
    if (by_klu_) {
        const FactorStatus status = klu_->factor(values);
        klu_in_use_ = factored_ = status.ok();
        return status;
    }
    if (const int column = bad_column(factors_->structure(), values); column >= 0)
        return {FactorStatus::Kind::non_finite, column};
    const bool single = factors_->in_single_precision();
    const auto quality = factors_->factor(values);
    if (!quality.usable || quality.smallest_pivot < suspicious_pivot ||
        (quality.smallest_pivot < small_pivot && !(factors_->backward_error(values) < largest_error)))
        return factor_by_klu(values);
    const bool as_before = counts_.factorisations > 0 && factors_->in_single_precision() == single;
    ++(as_before ? counts_.refactorisations : counts_.factorisations);
    factored_ = true;
    return {};
}

template <class Scalar> void BlockSolverOf<Scalar>::solve(std::span<Scalar> rhs, int columns) {
    if (!factored_)
        throw std::logic_error("solve without factors");
    if (std::ssize(rhs) != static_cast<std::ptrdiff_t>(unknowns_) * columns)
        throw std::invalid_argument("right-hand side of another size");
    counts_.solves += columns;
    if (klu_in_use_)
        klu_->solve(rhs, columns);
    else
        factors_->solve(rhs, columns);
}

template <class Scalar> const LinearSolverCounts& BlockSolverOf<Scalar>::counts() const {
    return by_klu_ && klu_ ? klu_->counts() : counts_;
}

template <class Scalar> long BlockSolverOf<Scalar>::factor_nonzeros() const {
    if (!factored_)
        return 0;
    return klu_in_use_ ? klu_->factor_nonzeros() : factors_->structure().nonzeros;
}

template <class Scalar>
std::shared_ptr<const BlockStructure> BlockSolverOf<Scalar>::shared_structure() const {
    return factors_ ? factors_->shared_structure() : nullptr;
}

template <class Scalar> void BlockSolverOf<Scalar>::visit(Archive& archive) {
    LinearSolverCounts& c = counts_;
    archive.section("block");
    archive.same(entries_, "a matrix of another size");
    bool with_klu = klu_ != nullptr;
    archive(factored_, klu_in_use_, with_klu, c.analyses, c.factorisations, c.refactorisations, c.solves,
            c.klu_fallbacks);
    if (factors_)
        factors_->visit(archive);
    if (!with_klu) {
        klu_.reset();
        return;
    }
    if (!klu_)
        make_klu(pattern_of(factors_->structure()));
    klu_->visit(archive);
}

template class BlockSolverOf<double>;
template class BlockSolverOf<std::complex<double>>;

} // namespace gudgeon
