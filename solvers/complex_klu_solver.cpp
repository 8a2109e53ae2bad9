#include "solvers/complex_klu_solver.hpp"

#include "solvers/equilibration.hpp"
#include "solvers/saddle_ordering.hpp"

#include <klu.h>

#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <vector>

namespace gudgeon {

namespace {
constexpr double worst_reciprocal_growth = 1e-7; // min over columns of max|A| / max|U|
constexpr double smallest_pivot_share = 1e-14;   // of the largest: below, new pivots are chosen
} // namespace

struct ComplexKluSolver::Impl {
    klu_common common{};
    klu_symbolic* symbolic = nullptr;
    klu_numeric* numeric = nullptr;
    CscPattern pattern;
    Equilibration scaling;
    std::vector<double> magnitude, factors;
    std::vector<std::complex<double>> scaled, solution;
    std::vector<std::complex<double>> pivoted; // scaled, at the full factorisation that chose the pivots
    std::vector<int> chosen;                   // ordering of the symbolic analysis; empty: none yet
    bool refactored = false;                   // the factors are those of scaled with the pivots of pivoted
    LinearSolverCounts counts;
    bool factored = false;

    ~Impl() { release(); }
    void release() {
        release_numeric();
        if (symbolic)
            klu_free_symbolic(&symbolic, &common);
        symbolic = nullptr;
    }
    void release_numeric() {
        if (numeric)
            klu_z_free_numeric(&numeric, &common);
        numeric = nullptr;
    }
    double* values() { return reinterpret_cast<double*>(scaled.data()); }
    void order(std::vector<int> perm);
    bool full();
    bool choose();
    bool refactor();
    bool refactor_values();
    void rebuild();
    bool pivots_serve();
    void load(std::span<const std::complex<double>> v) {
        for (std::size_t p = 0; p < scaled.size(); ++p)
            scaled[p] = v[p] * factors[p];
    }
};

void ComplexKluSolver::Impl::order(std::vector<int> perm) {
    release();
    chosen = perm;
    symbolic = klu_analyze_given(pattern.cols, pattern.col_start.data(), pattern.row.data(), perm.data(),
                                 perm.data(), &common);
    if (!symbolic)
        throw std::bad_alloc();
}

bool ComplexKluSolver::Impl::full() {
    release_numeric();
    pivoted = scaled;
    refactored = false;
    numeric = klu_z_factor(pattern.col_start.data(), pattern.row.data(), values(), symbolic, &common);
    if (common.status < KLU_OK)
        throw std::bad_alloc();
    return numeric != nullptr;
}

// Which ordering costs less is known only after pivoting: where the system is small both are tried once.
bool ComplexKluSolver::Impl::choose() {
    std::vector<int> best;
    double least = std::numeric_limits<double>::infinity();
    for (const std::vector<int>& perm : ordering_candidates(pattern)) {
        order(perm);
        if (!full() || !klu_z_flops(symbolic, numeric, &common) || common.flops >= least)
            continue;
        least = common.flops;
        best = perm;
    }
    if (best.empty()) {
        release();
        chosen.clear();
        return false;
    }
    order(best);
    return true;
}

bool ComplexKluSolver::Impl::pivots_serve() {
    return klu_z_rgrowth(pattern.col_start.data(), pattern.row.data(), values(), symbolic, numeric,
                         &common) &&
           common.rgrowth > worst_reciprocal_growth && klu_z_rcond(symbolic, numeric, &common) &&
           common.rcond > smallest_pivot_share;
}

bool ComplexKluSolver::Impl::refactor_values() {
    refactored = true;
    return klu_z_refactor(pattern.col_start.data(), pattern.row.data(), values(), symbolic, numeric,
                          &common) &&
           common.status == KLU_OK;
}

bool ComplexKluSolver::Impl::refactor() { return refactor_values() && pivots_serve(); }

// Factors of a loaded matrix by the operations that made them.
void ComplexKluSolver::Impl::rebuild() {
    const bool again = refactored;
    const std::vector<std::complex<double>> last = scaled;
    order(std::vector<int>(chosen));
    scaled = pivoted;
    bool good = full() && klu_z_sort(symbolic, numeric, &common);
    scaled = last;
    good = good && (!again || refactor_values());
    if (!good)
        throw ArchiveError("holds a matrix that cannot be factored");
}

ComplexKluSolver::ComplexKluSolver() : impl_(std::make_unique<Impl>()) {
    klu_defaults(&impl_->common);
    impl_->common.tol = 1e-3;
    impl_->common.btf = 0;
    impl_->common.scale = -1;
    impl_->common.halt_if_singular = 1;
}
ComplexKluSolver::~ComplexKluSolver() = default;

void ComplexKluSolver::analyse(const CscPattern& pattern) {
    check_pattern(pattern);
    Impl& s = *impl_;
    s.release();
    s.pattern = pattern;
    s.scaling.analyse(pattern);
    s.magnitude.assign(pattern.nonzeros(), 0.0);
    s.factors.assign(pattern.nonzeros(), 1.0);
    s.scaled.assign(pattern.nonzeros(), 0.0);
    s.factored = false;
    ++s.counts.analyses;
}

void ComplexKluSolver::visit(Archive& archive) {
    Impl& s = *impl_;
    LinearSolverCounts& c = s.counts;
    archive.section("complex klu");
    archive.same(s.pattern.nonzeros(), "a matrix of another size");
    bool numeric = s.numeric != nullptr;
    archive(numeric, s.chosen, s.scaling, s.factors, s.scaled, s.pivoted, s.refactored, s.factored);
    archive(c.analyses, c.factorisations, c.refactorisations, c.solves, c.off_diagonal_pivots);
    if (!archive.reading())
        return;
    s.release();
    if (numeric)
        s.rebuild();
    else if (!s.chosen.empty())
        s.order(s.chosen);
}

FactorStatus ComplexKluSolver::factor(std::span<const std::complex<double>> values) {
    Impl& s = *impl_;
    const CscPattern& a = s.pattern;
    if (std::ssize(values) != a.nonzeros())
        throw std::invalid_argument("one value per pattern entry is needed");
    s.factored = a.cols == 0;
    if (s.factored)
        return {};
    for (std::size_t p = 0; p < values.size(); ++p) {
        s.magnitude[p] = std::abs(values[p]);
        if (!std::isfinite(s.magnitude[p]))
            return {FactorStatus::Kind::non_finite, 0};
    }
    if (s.numeric) {
        s.load(values);
        if (s.refactor()) {
            ++s.counts.refactorisations;
            s.factored = true;
            return {};
        }
    }
    s.scaling.compute(s.magnitude);
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            s.factors[p] = s.scaling.row()[a.row[p]] * s.scaling.col()[j];
    s.load(values);
    ++s.counts.factorisations;
    s.factored = (s.symbolic || s.choose()) && s.full() && klu_z_sort(s.symbolic, s.numeric, &s.common) &&
                 klu_z_rcond(s.symbolic, s.numeric, &s.common) && s.common.rcond > 0;
    s.counts.off_diagonal_pivots = s.common.noffdiag;
    if (!s.factored)
        return {FactorStatus::Kind::singular, s.common.singular_col};
    return {};
}

void ComplexKluSolver::solve(std::span<std::complex<double>> rhs, int columns) {
    Impl& s = *impl_;
    if (!s.factored)
        throw std::logic_error("solve without factors");
    const int n = s.pattern.cols;
    if (std::ssize(rhs) != std::ptrdiff_t(n) * columns)
        throw std::invalid_argument("right-hand side of another size");
    s.counts.solves += columns;
    if (n == 0)
        return;
    s.solution.resize(rhs.size());
    for (int c = 0; c < columns; ++c)
        for (int i = 0; i < n; ++i)
            s.solution[std::size_t(n) * c + i] = s.scaling.row()[i] * rhs[std::size_t(n) * c + i];
    klu_z_solve(s.symbolic, s.numeric, n, columns, reinterpret_cast<double*>(s.solution.data()), &s.common);
    for (int c = 0; c < columns; ++c)
        for (int i = 0; i < n; ++i)
            rhs[std::size_t(n) * c + i] = s.scaling.col()[i] * s.solution[std::size_t(n) * c + i];
}

const LinearSolverCounts& ComplexKluSolver::counts() const { return impl_->counts; }
long ComplexKluSolver::factor_nonzeros() const {
    return impl_->numeric ? long(impl_->numeric->lnz) + impl_->numeric->unz : 0;
}

} // namespace gudgeon
