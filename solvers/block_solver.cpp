#include "solvers/block_solver.hpp"

#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {
constexpr double suspicious_pivot = 1e-12; // of the scaled matrix
constexpr double small_pivot = 1e-6;       // worth a probe
constexpr double largest_error = 1e-5;     // of a probe's residual: worse costs sweeps

/// The first column with a number that is not finite, -1: none.
template <class Scalar> int bad_column(const CscPattern& pattern, std::span<const Scalar> values) {
    Scalar probe = 0; // 0 * x is 0 for finite x only
    for (const Scalar& x : values)
        probe += 0.0 * x;
    for (int j = 0; probe != Scalar(0) && j < pattern.cols; ++j)
        for (int p = pattern.col_start[j]; p < pattern.col_start[j + 1]; ++p)
            if (0.0 * values[p] != Scalar(0))
                return j;
    return -1;
}
} // namespace

template <class Scalar> void BlockSolverOf<Scalar>::analyse(const CscPattern& pattern) {
    check_pattern(pattern);
    if (pattern.rows != pattern.cols)
        throw std::invalid_argument("a square matrix is needed");
    analyse(pattern,
            options_.always_klu ? nullptr : std::make_shared<const BlockStructure>(block_structure(pattern)));
}

template <class Scalar>
void BlockSolverOf<Scalar>::analyse(const CscPattern& pattern,
                                    std::shared_ptr<const BlockStructure> structure) {
    pattern_ = pattern;
    factors_.reset();
    klu_.reset();
    if (options_.always_klu)
        make_klu();
    else
        factors_ = std::make_unique<BlockFactors<Scalar>>(std::move(structure), pattern.leading,
                                                          options_.threads, options_.single_precision);
    klu_in_use_ = factored_ = false;
    ++counts_.analyses;
}

template <class Scalar> void BlockSolverOf<Scalar>::make_klu() {
    if (klu_)
        return;
    if constexpr (std::is_same_v<Scalar, double>)
        klu_ = std::make_unique<Klu>(KluOptions{.refinements = 0});
    else
        klu_ = std::make_unique<Klu>();
    klu_->analyse(pattern_);
}

template <class Scalar> FactorStatus BlockSolverOf<Scalar>::factor_by_klu(std::span<const Scalar> values) {
    make_klu();
    const FactorStatus status = klu_->factor(values);
    klu_in_use_ = factored_ = status.ok();
    if (status.ok() && !options_.always_klu)
        ++counts_.klu_fallbacks;
    return status;
}

template <class Scalar> FactorStatus BlockSolverOf<Scalar>::factor(std::span<const Scalar> values) {
    if (!factors_ && !klu_)
        throw std::logic_error("factor before analyse");
    if (std::ssize(values) != pattern_.nonzeros())
        throw std::invalid_argument("one value per pattern entry is needed");
    klu_in_use_ = factored_ = false;
    if (options_.always_klu)
        return factor_by_klu(values);
    if (const int column = bad_column(pattern_, values); column >= 0)
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
    if (std::ssize(rhs) != static_cast<std::ptrdiff_t>(pattern_.cols) * columns)
        throw std::invalid_argument("right-hand side of another size");
    counts_.solves += columns;
    if (klu_in_use_)
        klu_->solve(rhs, columns);
    else
        factors_->solve(rhs, columns);
}

template <class Scalar> const LinearSolverCounts& BlockSolverOf<Scalar>::counts() const {
    return options_.always_klu ? klu_->counts() : counts_;
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
    archive.same(pattern_.nonzeros(), "a matrix of another size");
    bool with_klu = klu_ != nullptr;
    archive(factored_, klu_in_use_, with_klu, c.analyses, c.factorisations, c.refactorisations, c.solves,
            c.klu_fallbacks);
    if (factors_)
        factors_->visit(archive);
    if (!with_klu)
        return;
    make_klu();
    klu_->visit(archive);
}

template class BlockSolverOf<double>;
template class BlockSolverOf<std::complex<double>>;

} // namespace gudgeon
