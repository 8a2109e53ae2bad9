#include "solvers/klu_solver.hpp"

#include "solvers/equilibration.hpp"
#include "solvers/saddle_ordering.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include <klu.h>

namespace gudgeon {

namespace {

constexpr double round_off = std::numeric_limits<double>::epsilon();
constexpr double refined_enough = 8 * round_off; // backward error that needs no correction
constexpr double suspicious_pivot = 1e-9;        // share of its column: worth a condition number
constexpr double hopeless_residual = 1e-5;       // of the largest terms: one refinement does not repair this

/// Column k of L or U inside KLU's packed storage: len indices, padded to whole doubles, then len values.
struct FactorColumn {
    const int* index;
    const double* value;
    int size;
};

FactorColumn factor_column(const double* storage, const int* start, const int* length, int k) {
    if (!storage) // a single unknown has a diagonal only
        return {nullptr, nullptr, 0};
    const double* head = storage + start[k];
    const int size = length[k];
    const std::size_t padded = (sizeof(int) * size + sizeof(double) - 1) / sizeof(double);
    return {reinterpret_cast<const int*>(head), head + padded, size};
}

void check_permutation(std::vector<int> perm, int n) {
    std::sort(perm.begin(), perm.end());
    for (int i = 0; i < n; ++i)
        if (std::ssize(perm) != n || perm[i] != i)
            throw std::invalid_argument("ordering: not a permutation of the unknowns");
}

} // namespace

struct KluSolver::Impl {
    KluOptions options;
    klu_common common{};
    klu_symbolic* symbolic = nullptr;
    klu_numeric* numeric = nullptr;
    CscPattern pattern;
    std::vector<int> ordering;                // given by the user, may be empty
    std::vector<std::vector<int>> candidates; // orderings to choose from at the first factorisation
    Equilibration scaling;
    std::vector<double> factors; // row[i] * col[j] per entry
    std::vector<double> scaled;  // the matrix that is factored
    std::vector<double> pivoted; // the one whose full factorisation chose the pivots
    std::vector<int> chosen;     // ordering of the symbolic analysis
    bool refactored = false;     // the factors are those of scaled with the pivots of pivoted
    std::vector<double> magnitude;
    std::vector<double> scaled_rhs, solution, residual;
    double growth = 0;
    double growth_when_pivoted = 0;
    int bad_column = -1;
    bool analysed = false;
    bool factored = false;
    bool new_pivots = true;
    LinearSolverCounts counts;

    ~Impl() { release(); }
    void release();
    void release_numeric();
    void load(std::span<const double> values);
    bool refactor();
    void order(std::vector<int> perm);
    bool choose_ordering();
    bool choose_pivots();
    bool factor_fully();
    bool pivots_serve();
    bool nearly_singular();
    void rebuild();
    void reserve_columns(int columns);
    struct BackwardError {
        double componentwise = 0, normwise = 0;
    };
    BackwardError form_residual(int column);
    void solve_scaled(std::vector<double>& x, int columns);
};

void KluSolver::Impl::release_numeric() {
    if (numeric)
        klu_free_numeric(&numeric, &common);
    numeric = nullptr;
}

void KluSolver::Impl::release() {
    release_numeric();
    if (symbolic)
        klu_free_symbolic(&symbolic, &common);
    symbolic = nullptr;
}

void KluSolver::Impl::load(std::span<const double> values) {
    for (std::size_t p = 0; p < scaled.size(); ++p)
        scaled[p] = values[p] * factors[p];
}

/// True when the old pivots served.
bool KluSolver::Impl::refactor() {
    if (!klu_refactor(pattern.col_start.data(), pattern.row.data(), scaled.data(), symbolic, numeric,
                      &common) ||
        common.status != KLU_OK)
        return false;
    return pivots_serve() && growth <= std::max(options.largest_growth, 10 * growth_when_pivoted);
}

void KluSolver::Impl::order(std::vector<int> perm) {
    release();
    chosen = perm;
    symbolic = klu_analyze_given(pattern.cols, pattern.col_start.data(), pattern.row.data(), perm.data(),
                                 perm.data(), &common);
    if (!symbolic)
        throw std::bad_alloc();
}

bool KluSolver::Impl::choose_pivots() {
    release_numeric();
    numeric = klu_factor(pattern.col_start.data(), pattern.row.data(), scaled.data(), symbolic, &common);
    if (common.status < KLU_OK)
        throw std::bad_alloc();
    if (!numeric)
        bad_column = common.singular_col;
    return numeric != nullptr;
}

/// Which ordering leads to less work is known only after pivoting: try each once, keep the best.
/// False if every one meets a column without pivot; the choice then stays open.
bool KluSolver::Impl::choose_ordering() {
    std::vector<int>* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (std::vector<int>& perm : candidates) {
        order(perm);
        if (candidates.size() == 1 || !choose_pivots() || !klu_flops(symbolic, numeric, &common))
            continue;
        if (common.flops < least) {
            least = common.flops;
            best = &perm;
        }
    }
    if (candidates.size() > 1) {
        if (!best)
            return false;
        if (best != &candidates.back())
            order(*best);
    }
    candidates.clear();
    return true;
}

bool KluSolver::Impl::factor_fully() {
    ++counts.factorisations;
    if (!candidates.empty() && !choose_ordering())
        return false;
    if (!choose_pivots())
        return false;
    pivoted = scaled;
    refactored = false;
    counts.off_diagonal_pivots = common.noffdiag;
    if (!klu_sort(symbolic, numeric, &common)) // columns in order: refactor and solve walk through memory
        throw std::bad_alloc();
    const bool good = pivots_serve();
    growth_when_pivoted = growth;
    return good;
}

/// Measures the growth of every column and the smallest pivot; false if there is no usable one somewhere.
bool KluSolver::Impl::pivots_serve() {
    const int n = pattern.cols;
    const double* storage = static_cast<const double*>(numeric->LUbx[0]);
    const double* pivot = static_cast<const double*>(numeric->Udiag);
    growth = 0;
    double smallest = 1;
    for (int k = 0; k < n; ++k) {
        const int q = symbolic->Q[k];
        double in_a = 0;
        for (int p = pattern.col_start[q]; p < pattern.col_start[q + 1]; ++p)
            in_a = std::max(in_a, std::abs(scaled[p]));
        const FactorColumn u = factor_column(storage, numeric->Uip, numeric->Ulen, k);
        double in_u = std::abs(pivot[k]);
        for (int p = 0; p < u.size; ++p)
            in_u = std::max(in_u, std::abs(u.value[p]));
        growth = std::max(growth, in_u / in_a);
        if (const double share = std::abs(pivot[k]) / std::max(in_u, in_a); !(share >= smallest)) {
            smallest = share;
            bad_column = q;
        }
    }
    if (!(smallest > suspicious_pivot) && nearly_singular())
        return false;
    counts.worst_growth = std::max(counts.worst_growth, growth);
    return std::isfinite(growth);
}

/// Settled by the condition number of the scaled matrix (Hager 1984): a small pivot alone may be stiffness.
bool KluSolver::Impl::nearly_singular() {
    if (!klu_condest(pattern.col_start.data(), scaled.data(), symbolic, numeric, &common))
        return true;
    return !(common.condest < options.largest_condition);
}

/// Factors of a loaded matrix by the operations that made them.
void KluSolver::Impl::rebuild() {
    order(std::vector<int>(chosen));
    std::swap(scaled, pivoted);
    const bool good = choose_pivots() && klu_sort(symbolic, numeric, &common);
    std::swap(scaled, pivoted);
    if (!good || (refactored && !klu_refactor(pattern.col_start.data(), pattern.row.data(), scaled.data(),
                                              symbolic, numeric, &common)))
        throw ArchiveError("holds a matrix that cannot be factored");
}

void KluSolver::Impl::reserve_columns(int columns) {
    const std::size_t needed = static_cast<std::size_t>(pattern.cols) * columns;
    if (solution.size() >= needed)
        return;
    scaled_rhs.resize(needed);
    solution.resize(needed);
    residual.resize(needed);
}

/// residual = rhs - A x of one column, with its backward errors (Oettli & Prager 1964; Rigal & Gaches 1967).
KluSolver::Impl::BackwardError KluSolver::Impl::form_residual(int column) {
    const int n = pattern.cols;
    const std::size_t offset = static_cast<std::size_t>(n) * column;
    const double* b = scaled_rhs.data() + offset;
    const double* x = solution.data() + offset;
    double* r = residual.data() + offset;
    double* size = magnitude.data();
    for (int i = 0; i < n; ++i) {
        r[i] = b[i];
        size[i] = std::abs(b[i]);
    }
    for (int j = 0; j < n; ++j)
        for (int p = pattern.col_start[j]; p < pattern.col_start[j + 1]; ++p) {
            const double t = scaled[p] * x[j];
            r[pattern.row[p]] -= t;
            size[pattern.row[p]] += std::abs(t);
        }
    BackwardError error;
    double largest_residual = 0, largest_size = 0;
    for (int i = 0; i < n; ++i) {
        largest_residual = std::max(largest_residual, std::abs(r[i]));
        largest_size = std::max(largest_size, size[i]);
        if (r[i] != 0)
            error.componentwise = std::max(error.componentwise, std::abs(r[i]) / size[i]);
    }
    if (largest_residual > 0)
        error.normwise = largest_residual / largest_size;
    return error;
}

void KluSolver::Impl::solve_scaled(std::vector<double>& x, int columns) {
    klu_solve(symbolic, numeric, pattern.cols, columns, x.data(), &common);
}

KluSolver::KluSolver(KluOptions options) : impl_(std::make_unique<Impl>()) {
    impl_->options = options;
    klu_defaults(&impl_->common);
    impl_->common.tol = options.pivot_tolerance;
    impl_->common.btf = 0;
    impl_->common.scale = -1;
    impl_->common.halt_if_singular = 1;
}

KluSolver::~KluSolver() = default;

void KluSolver::set_ordering(std::vector<int> perm) { impl_->ordering = std::move(perm); }
void KluSolver::forget_pivots() { impl_->new_pivots = true; }

void KluSolver::analyse(const CscPattern& pattern) {
    check_pattern(pattern);
    if (pattern.rows != pattern.cols)
        throw std::invalid_argument("a square matrix is needed");
    Impl& s = *impl_;
    s.release();
    s.analysed = s.factored = false;
    s.new_pivots = true;
    s.pattern = pattern;
    const int n = pattern.cols;
    if (s.ordering.empty()) {
        s.candidates = ordering_candidates(pattern);
    } else {
        check_permutation(s.ordering, n);
        s.candidates = {s.ordering};
    }
    s.scaling.analyse(pattern);
    s.factors.assign(pattern.nonzeros(), 1.0);
    s.scaled.assign(pattern.nonzeros(), 0.0);
    s.pivoted.assign(pattern.nonzeros(), 0.0);
    s.magnitude.assign(n, 0.0);
    s.solution.clear();
    s.reserve_columns(2);
    s.analysed = true;
    ++s.counts.analyses;
}

void KluSolver::visit(Archive& archive) {
    Impl& s = *impl_;
    LinearSolverCounts& c = s.counts;
    archive.section("klu");
    archive.same(s.pattern.nonzeros(), "a matrix of another size");
    bool numeric = s.numeric != nullptr, open = !s.candidates.empty();
    archive(numeric, open, s.chosen, s.scaling, s.factors, s.scaled, s.pivoted, s.refactored, s.growth,
            s.growth_when_pivoted, s.bad_column, s.factored, s.new_pivots);
    archive(c.analyses, c.factorisations, c.refactorisations, c.solves, c.refinements, c.off_diagonal_pivots,
            c.worst_growth, c.worst_backward_error);
    if (!archive.reading())
        return;
    s.release();
    if (!open)
        s.candidates.clear();
    if (numeric)
        s.rebuild();
    else if (!open && !s.chosen.empty())
        s.order(s.chosen);
}

FactorStatus KluSolver::factor(std::span<const double> values) {
    Impl& s = *impl_;
    if (!s.analysed)
        throw std::logic_error("factor before analyse");
    const CscPattern& a = s.pattern;
    if (std::ssize(values) != a.nonzeros())
        throw std::invalid_argument("one value per pattern entry is needed");
    s.factored = false;
    double probe = 0; // 0 * x is 0 for finite x only
    for (const double v : values)
        probe += 0.0 * v;
    if (probe != 0)
        for (int j = 0; j < a.cols; ++j)
            for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
                if (!std::isfinite(values[p]))
                    return {FactorStatus::Kind::non_finite, j};
    if (a.cols == 0) {
        s.factored = true;
        return {};
    }
    if (s.numeric && !s.new_pivots) {
        s.load(values);
        if (s.refactor()) {
            ++s.counts.refactorisations;
            s.factored = s.refactored = true;
            return {};
        }
    }
    s.scaling.compute(values);
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            s.factors[p] = s.scaling.row()[a.row[p]] * s.scaling.col()[j];
    s.load(values);
    s.factored = s.factor_fully();
    s.new_pivots = !s.factored;
    if (!s.factored)
        return {FactorStatus::Kind::singular, s.bad_column};
    return {};
}

void KluSolver::solve(std::span<double> rhs, int columns) {
    Impl& s = *impl_;
    if (!s.factored)
        throw std::logic_error("solve without factors");
    const int n = s.pattern.cols;
    if (std::ssize(rhs) != static_cast<std::ptrdiff_t>(n) * columns)
        throw std::invalid_argument("right-hand side of another size");
    s.counts.solves += columns;
    if (n == 0 || columns == 0)
        return;
    s.reserve_columns(columns);
    const double* row = s.scaling.row().data();
    const double* col = s.scaling.col().data();
    for (int c = 0; c < columns; ++c)
        for (int i = 0; i < n; ++i) {
            const std::size_t k = static_cast<std::size_t>(n) * c + i;
            s.solution[k] = s.scaled_rhs[k] = row[i] * rhs[k];
        }
    s.solve_scaled(s.solution, columns);
    for (int sweep = 0; sweep < s.options.refinements; ++sweep) {
        double error = 0;
        for (int c = 0; c < columns; ++c) {
            const Impl::BackwardError e = s.form_residual(c);
            error = std::max(error, e.componentwise);
            // componentwise errors of a nearly empty right-hand side say nothing about the pivots
            s.new_pivots = s.new_pivots || e.normwise > hopeless_residual;
        }
        if (sweep == 0)
            s.counts.worst_backward_error = std::max(s.counts.worst_backward_error, error);
        if (!(error > refined_enough))
            break;
        s.solve_scaled(s.residual, columns);
        for (std::size_t k = 0; k < static_cast<std::size_t>(n) * columns; ++k)
            s.solution[k] += s.residual[k];
        s.counts.refinements += columns;
    }
    for (int c = 0; c < columns; ++c)
        for (int i = 0; i < n; ++i)
            rhs[static_cast<std::size_t>(n) * c + i] =
                col[i] * s.solution[static_cast<std::size_t>(n) * c + i];
}

const LinearSolverCounts& KluSolver::counts() const { return impl_->counts; }

long KluSolver::factor_nonzeros() const {
    return impl_->numeric ? static_cast<long>(impl_->numeric->lnz) + impl_->numeric->unz : 0;
}

} // namespace gudgeon
