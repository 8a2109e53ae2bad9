#include "solvers/sparse_cholesky.hpp"

#include "solvers/cholmod_tools.hpp"
#include "solvers/linear_solver.hpp"
#include "solvers/saddle_ordering.hpp"

#include <algorithm>
#include <cmath>
#include <new>

namespace gudgeon {

struct SparseCholesky::Impl {
    cholmod_common common{};
    cholmod_factor* factor = nullptr;
    std::vector<int> place;
    CscPattern upper;
    std::vector<double> values;

    Impl() { cholmod::start(common, CHOLMOD_SIMPLICIAL); }
    ~Impl() {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }

    // L D L^T goes on after a negative pivot.
    bool positive() const {
        if (static_cast<int>(factor->minor) < upper.cols)
            return false;
        const int* start = static_cast<const int*>(factor->p);
        const double* value = static_cast<const double*>(factor->x);
        for (int k = 0; k < upper.cols; ++k)
            if (!(value[start[k]] > 0) || !std::isfinite(value[start[k]]))
                return false;
        return true;
    }

    template <class Scalar> void solve(Scalar* x) const {
        const int n = upper.cols;
        const int* start = static_cast<const int*>(factor->p);
        const int* size = static_cast<const int*>(factor->nz);
        const int* row = static_cast<const int*>(factor->i);
        const double* value = static_cast<const double*>(factor->x); // D(k,k) stands first in column k
        for (int k = 0; k < n; ++k) {
            const Scalar xk = x[k];
            for (int p = start[k] + 1; p < start[k] + size[k]; ++p)
                x[row[p]] -= value[p] * xk;
        }
        for (int k = n - 1; k >= 0; --k) {
            Scalar xk = x[k] / value[start[k]];
            for (int p = start[k] + 1; p < start[k] + size[k]; ++p)
                xk -= value[p] * x[row[p]];
            x[k] = xk;
        }
    }
};

SparseCholesky::SparseCholesky() : impl_(std::make_unique<Impl>()) {}
SparseCholesky::~SparseCholesky() = default;

void SparseCholesky::analyse(const CscPattern& full) {
    check_pattern(full);
    Impl& s = *impl_;
    cholmod_free_factor(&s.factor, &s.common);
    const std::vector<int> order = minimum_degree_ordering(full);
    s.place.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        s.place[order[k]] = static_cast<int>(k);
    s.upper = {full.rows, full.cols, {0}, {}};
    for (int j = 0; j < full.cols; ++j) {
        const int old = order[j];
        const auto first = static_cast<std::ptrdiff_t>(s.upper.row.size());
        for (int p = full.col_start[old]; p < full.col_start[old + 1]; ++p)
            if (const int i = s.place[full.row[p]]; i <= j)
                s.upper.row.push_back(i);
        std::sort(s.upper.row.begin() + first, s.upper.row.end());
        s.upper.col_start.push_back(s.upper.nonzeros());
    }
    s.values.assign(s.upper.nonzeros(), 0.0);
    if (full.cols == 0)
        return;
    cholmod_sparse a = cholmod::view_upper(s.upper, s.values);
    s.factor = cholmod_analyze(&a, &s.common);
    if (!s.factor)
        throw std::bad_alloc();
}

const std::vector<int>& SparseCholesky::place() const { return impl_->place; }
std::vector<double>& SparseCholesky::values() { return impl_->values; }

int SparseCholesky::slot(int i, int j) const {
    const CscPattern& a = impl_->upper;
    if (i > j)
        std::swap(i, j);
    const auto first = a.row.begin() + a.col_start[j], last = a.row.begin() + a.col_start[j + 1];
    const auto found = std::lower_bound(first, last, i);
    return found != last && *found == i ? static_cast<int>(found - a.row.begin()) : -1;
}

bool SparseCholesky::factor() {
    Impl& s = *impl_;
    if (s.upper.cols == 0)
        return true;
    cholmod_sparse a = cholmod::view_upper(s.upper, s.values);
    cholmod_factorize(&a, s.factor, &s.common);
    if (s.common.status < CHOLMOD_OK)
        throw std::bad_alloc();
    return s.positive();
}

void SparseCholesky::solve(double* x) const { impl_->solve(x); }
void SparseCholesky::solve(std::complex<double>* x) const { impl_->solve(x); }

long SparseCholesky::factor_nonzeros() const {
    const cholmod_factor* l = impl_->factor;
    if (!l)
        return 0;
    if (l->xtype == CHOLMOD_PATTERN)
        return static_cast<long>(impl_->common.lnz);
    const int* size = static_cast<const int*>(l->nz);
    long count = 0;
    for (std::size_t k = 0; k < l->n; ++k)
        count += size[k];
    return count;
}

} // namespace gudgeon
