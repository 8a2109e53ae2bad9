#include "solvers/cholmod_solver.hpp"

#include "solvers/cholmod_tools.hpp"
#include "solvers/saddle_ordering.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

namespace gudgeon {

struct NormalSolver::Impl {
    cholmod_common common{};
    cholmod_factor* factor = nullptr;
    cholmod_dense* x = nullptr;
    cholmod_dense* y = nullptr; // workspace of the triangular solves, kept between calls
    cholmod_dense* e = nullptr;
    CscPattern b;
    std::vector<int> perm;    // perm[k]: row of B eliminated k-th
    std::vector<int> inverse; // of perm
    CscPattern normal;        // upper triangle of P N P^T
    std::vector<double> values;
    // Slots of the products of two entries of one column of B, in order; columns with the same rows share
    // theirs.
    std::vector<int> slot, column_slot;
    std::vector<double> scale, rhs;
    bool analysed = false;
    bool factored = false;
    LinearSolverCounts counts;

    Impl();
    ~Impl();
    void release();
    void order_rows();
    void find_slots();
    void assemble(std::span<const double> b_values, double beta);
    void scale_diagonal();
    double pivot(int k) const;
    int bad_pivot(double smallest) const;
    void solve_permuted();
    void solve_supernodal();
};

NormalSolver::Impl::Impl() {
#ifdef GUDGEON_GPL_CHOLMOD
    cholmod::start(common, CHOLMOD_AUTO);
#else
    cholmod::start(common, CHOLMOD_SIMPLICIAL);
#endif
    common.quick_return_if_not_posdef = 1;
}

NormalSolver::Impl::~Impl() {
    release();
    cholmod_finish(&common);
}

void NormalSolver::Impl::release() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
}

/// Row pairs of a column of B, in a fixed order: the diagonal ones too.
template <class Visit> void visit_products(const CscPattern& b, int column, Visit visit) {
    for (int p = b.col_start[column]; p < b.col_start[column + 1]; ++p)
        for (int q = p; q < b.col_start[column + 1]; ++q)
            visit(p, q);
}

/// Column of B with the same rows as the one before it.
bool repeats(const CscPattern& b, int column) {
    if (column == 0)
        return false;
    const auto at = [&](int c) { return b.row.begin() + b.col_start[c]; };
    return std::equal(at(column - 1), at(column), at(column), at(column + 1));
}

/// Columns in which each row has an entry; of columns with the same rows the first alone.
CscPattern by_rows(const CscPattern& b) {
    CscPattern out;
    out.cols = b.rows;
    out.rows = b.cols;
    std::vector<int> taken;
    for (int j = 0; j < b.cols; ++j)
        if (!repeats(b, j))
            taken.push_back(j);
    out.col_start.assign(b.rows + 1, 0);
    for (const int j : taken)
        for (int p = b.col_start[j]; p < b.col_start[j + 1]; ++p)
            ++out.col_start[b.row[p] + 1];
    for (int i = 0; i < b.rows; ++i)
        out.col_start[i + 1] += out.col_start[i];
    out.row.resize(out.col_start.back());
    std::vector<int> next(out.col_start.begin(), out.col_start.end() - 1);
    for (const int j : taken)
        for (int p = b.col_start[j]; p < b.col_start[j + 1]; ++p)
            out.row[next[b.row[p]]++] = j;
    return out;
}

/// Pattern of B B^T, both triangles.
CscPattern products(const CscPattern& b) {
    const CscPattern columns = by_rows(b);
    CscPattern out;
    out.rows = out.cols = b.rows;
    out.col_start.reserve(std::size_t(b.rows) + 1);
    out.col_start.push_back(0);
    std::vector<int> seen(b.rows, -1);
    for (int i = 0; i < b.rows; ++i) {
        const auto begin = static_cast<std::ptrdiff_t>(out.row.size());
        for (int c = columns.col_start[i]; c < columns.col_start[i + 1]; ++c)
            for (int p = b.col_start[columns.row[c]]; p < b.col_start[columns.row[c] + 1]; ++p)
                if (std::exchange(seen[b.row[p]], i) != i)
                    out.row.push_back(b.row[p]);
        std::sort(out.row.begin() + begin, out.row.end());
        out.col_start.push_back(static_cast<int>(out.row.size()));
    }
    return out;
}

void NormalSolver::Impl::order_rows() {
    const int m = b.rows;
    const CscPattern full = products(b);
    perm = minimum_degree_ordering(full);
    inverse.resize(m);
    for (int k = 0; k < m; ++k)
        inverse[perm[k]] = k;
    normal = {};
    normal.rows = normal.cols = m;
    normal.col_start.reserve(std::size_t(m) + 1);
    normal.col_start.push_back(0);
    normal.row.reserve((full.row.size() + std::size_t(m)) / 2 +
                       std::size_t(m)); // rows of zeros have a pivot too
    for (int k = 0; k < m; ++k) {
        const auto begin = static_cast<std::ptrdiff_t>(normal.row.size());
        for (int p = full.col_start[perm[k]]; p < full.col_start[perm[k] + 1]; ++p)
            if (inverse[full.row[p]] < k)
                normal.row.push_back(inverse[full.row[p]]);
        std::sort(normal.row.begin() + begin, normal.row.end());
        normal.row.push_back(k);
        normal.col_start.push_back(static_cast<int>(normal.row.size()));
    }
    normal.row.shrink_to_fit();
}

void NormalSolver::Impl::find_slots() {
    slot.clear();
    column_slot.clear();
    for (int j = 0; j < b.cols; ++j) {
        if (repeats(b, j)) {
            column_slot.push_back(column_slot.back());
            continue;
        }
        column_slot.push_back(static_cast<int>(slot.size()));
        visit_products(b, j, [&](int p, int q) {
            const int i = inverse[b.row[p]], k = inverse[b.row[q]];
            const int col = std::max(i, k);
            const auto begin = normal.row.begin() + normal.col_start[col];
            const auto end = normal.row.begin() + normal.col_start[col + 1];
            slot.push_back(
                static_cast<int>(std::lower_bound(begin, end, std::min(i, k)) - normal.row.begin()));
        });
    }
    slot.shrink_to_fit();
}

void NormalSolver::Impl::assemble(std::span<const double> b_values, double beta) {
    std::fill(values.begin(), values.end(), 0.0);
    for (int j = 0; j < b.cols; ++j) {
        const int* at = slot.data() + column_slot[j];
        visit_products(b, j, [&](int p, int q) { values[*at++] += b_values[p] * b_values[q]; });
    }
    for (int c = 0; c < b.rows; ++c)
        values[normal.col_start[c + 1] - 1] += beta; // the diagonal is the last entry of an upper column
}

void NormalSolver::Impl::scale_diagonal() {
    for (int c = 0; c < b.rows; ++c) {
        const double d = values[normal.col_start[c + 1] - 1];
        scale[c] = d > 0 ? std::ldexp(1.0, -std::ilogb(d) / 2) : 1.0;
    }
    for (int c = 0; c < b.rows; ++c)
        for (int p = normal.col_start[c]; p < normal.col_start[c + 1]; ++p)
            values[p] *= scale[c] * scale[normal.row[p]];
}

/// D of L D L^T, by position.
double NormalSolver::Impl::pivot(int k) const {
    const double* value = static_cast<const double*>(factor->x);
    if (!factor->is_super)
        return value[static_cast<const int*>(factor->p)[k]];
    const int* super = static_cast<const int*>(factor->super);
    const int* rows = static_cast<const int*>(factor->pi);
    const int* block = static_cast<const int*>(factor->px);
    const int s = static_cast<int>(std::upper_bound(super, super + factor->nsuper, k) - super) - 1;
    const std::ptrdiff_t step = rows[s + 1] - rows[s] + 1;
    const double l = value[block[s] + (k - super[s]) * step];
    return l * l;
}

/// First position whose pivot is missing or only round-off, -1 if all are good.
int NormalSolver::Impl::bad_pivot(double smallest) const {
    const int m = b.rows;
    if (static_cast<int>(factor->minor) < m)
        return static_cast<int>(factor->minor);
    double largest = 0;
    for (int k = 0; k < m; ++k)
        largest = std::max(largest, pivot(k));
    for (int k = 0; k < m; ++k)
        if (!(pivot(k) > smallest * largest))
            return k;
    return -1;
}

/// Own loops over the simplicial factor: cholmod_solve2 allocates.
void NormalSolver::Impl::solve_permuted() {
    if (factor->is_super) {
        solve_supernodal();
        return;
    }
    const int m = b.rows;
    const int* start = static_cast<const int*>(factor->p);
    const int* size = static_cast<const int*>(factor->nz);
    const int* row = static_cast<const int*>(factor->i);
    const double* value = static_cast<const double*>(factor->x); // D(k,k) stands first in column k of L
    for (int k = 0; k < m; ++k)
        for (int p = start[k] + 1; p < start[k] + size[k]; ++p)
            rhs[row[p]] -= value[p] * rhs[k];
    for (int k = m - 1; k >= 0; --k) {
        double x = rhs[k] / value[start[k]];
        for (int p = start[k] + 1; p < start[k] + size[k]; ++p)
            x -= value[p] * rhs[row[p]];
        rhs[k] = x;
    }
}

void NormalSolver::Impl::solve_supernodal() {
    cholmod_dense right{};
    right.nrow = right.nzmax = right.d = rhs.size();
    right.ncol = 1;
    right.x = rhs.data();
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    if (!cholmod_solve2(CHOLMOD_A, factor, &right, nullptr, &x, nullptr, &y, &e, &common))
        throw std::bad_alloc();
    std::copy_n(static_cast<const double*>(x->x), rhs.size(), rhs.begin());
}

NormalSolver::NormalSolver() : impl_(std::make_unique<Impl>()) {}
NormalSolver::~NormalSolver() = default;

void NormalSolver::analyse(CscPattern b) {
    check_pattern(b);
    Impl& s = *impl_;
    s.release();
    s.factored = false;
    s.b = std::move(b);
    s.b.row.shrink_to_fit();
    s.order_rows();
    s.find_slots();
    s.values.assign(s.normal.nonzeros(), 0.0);
    s.scale.assign(s.b.rows, 1.0);
    s.rhs.assign(s.b.rows, 0.0);
    if (s.b.rows > 0) {
        cholmod_sparse view = cholmod::view_upper(s.normal, s.values);
        s.factor = cholmod_analyze(&view, &s.common);
        if (!s.factor)
            throw std::bad_alloc();
    }
    s.analysed = true;
    ++s.counts.analyses;
}

FactorStatus NormalSolver::factor(std::span<const double> values, double beta, double smallest_pivot) {
    Impl& s = *impl_;
    if (!s.analysed)
        throw std::logic_error("factor before analyse");
    if (std::ssize(values) != s.b.nonzeros())
        throw std::invalid_argument("one value per pattern entry is needed");
    const bool first = s.counts.factorisations == 0;
    s.factored = false;
    if (!std::isfinite(beta))
        return {FactorStatus::Kind::non_finite, -1};
    for (int j = 0; j < s.b.cols; ++j)
        for (int p = s.b.col_start[j]; p < s.b.col_start[j + 1]; ++p)
            if (!std::isfinite(values[p]))
                return {FactorStatus::Kind::non_finite, j};
    ++(first ? s.counts.factorisations : s.counts.refactorisations);
    if (s.b.rows > 0) {
        s.assemble(values, beta);
        s.scale_diagonal();
        cholmod_sparse view = cholmod::view_upper(s.normal, s.values);
        cholmod_factorize(&view, s.factor, &s.common);
        if (s.common.status < CHOLMOD_OK)
            throw std::bad_alloc();
        if (const int k = s.bad_pivot(smallest_pivot); k >= 0)
            return {FactorStatus::Kind::singular, s.perm[k]};
    }
    s.factored = true;
    return {};
}

void NormalSolver::solve(std::span<double> rhs) {
    Impl& s = *impl_;
    const int m = s.b.rows;
    if (!s.factored)
        throw std::logic_error("solve without factors");
    if (std::ssize(rhs) != m)
        throw std::invalid_argument("right-hand side of another size");
    ++s.counts.solves;
    if (m == 0)
        return;
    for (int k = 0; k < m; ++k)
        s.rhs[k] = s.scale[k] * rhs[s.perm[k]];
    s.solve_permuted();
    for (int k = 0; k < m; ++k)
        rhs[s.perm[k]] = s.scale[k] * s.rhs[k];
}

double NormalSolver::pivot(int row) const {
    const Impl& s = *impl_;
    if (!s.factored)
        throw std::logic_error("pivot without factors");
    const int k = s.inverse[row];
    return s.pivot(k) / (s.scale[k] * s.scale[k]);
}

const LinearSolverCounts& NormalSolver::counts() const { return impl_->counts; }

long NormalSolver::factor_nonzeros() const {
    const cholmod_factor* l = impl_->factor;
    if (!l || l->xtype == CHOLMOD_PATTERN)
        return 0;
    if (l->is_super)
        return static_cast<long>(l->xsize);
    long count = 0;
    for (std::size_t k = 0; k < l->n; ++k)
        count += static_cast<const int*>(l->nz)[k];
    return count;
}

} // namespace gudgeon
