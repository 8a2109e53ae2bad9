#include "solvers/rank.hpp"

#include "solvers/linear_solver.hpp"
#include "solvers/saddle_ordering.hpp"

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#ifdef GUDGEON_HAVE_SPQR
#include <SuiteSparseQR.hpp>
#endif

namespace gudgeon {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
constexpr double negligible = 1e-9;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Entries of one column or vector, index increasing.
using Entries = std::vector<std::pair<int, double>>;

/// R of G^T P = Q R by columns, and P: column k of R belongs to row order[k] of g. R is a staircase:
/// a column is dependent on those before it if it adds no new row to the stairs.
struct Staircase {
    std::vector<Entries> column;
    std::vector<int> order;
};

#ifdef GUDGEON_HAVE_SPQR
Staircase factor(const SparseMatrix& gt, double tolerance) {
    cholmod_common common;
    cholmod_l_start(&common);
    common.print = 0;
    common.SPQR_nthreads = 1;
    const auto index = [](const int* from, long count) {
        return std::vector<SuiteSparse_long>(from, from + count);
    };
    std::vector<SuiteSparse_long> start = index(gt.outerIndexPtr(), gt.cols() + 1);
    std::vector<SuiteSparse_long> row = index(gt.innerIndexPtr(), gt.nonZeros());
    std::vector<double> value(gt.valuePtr(), gt.valuePtr() + gt.nonZeros());
    cholmod_sparse a{};
    a.nrow = gt.rows();
    a.ncol = gt.cols();
    a.nzmax = row.size();
    a.p = start.data();
    a.i = row.data();
    a.x = value.data();
    a.itype = CHOLMOD_LONG;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = a.packed = 1;
    cholmod_sparse* r = nullptr;
    SuiteSparse_long* perm = nullptr;
    const SuiteSparse_long rank =
        SuiteSparseQR<double>(SPQR_ORDERING_COLAMD, tolerance, a.nrow, &a, &r, &perm, &common);
    Staircase out;
    if (rank >= 0) {
        const auto* p = static_cast<const SuiteSparse_long*>(r->p);
        const auto* i = static_cast<const SuiteSparse_long*>(r->i);
        const auto* x = static_cast<const double*>(r->x);
        for (long k = 0; k < gt.cols(); ++k) {
            out.order.push_back(static_cast<int>(perm ? perm[k] : k));
            Entries& column = out.column.emplace_back();
            for (SuiteSparse_long q = p[k]; q < p[k + 1]; ++q)
                column.emplace_back(static_cast<int>(i[q]), x[q]);
            std::sort(column.begin(), column.end());
        }
    }
    cholmod_l_free_sparse(&r, &common);
    cholmod_l_free(gt.cols(), sizeof(SuiteSparse_long), perm, &common);
    cholmod_l_finish(&common);
    if (rank < 0)
        throw std::runtime_error("rank of the constraints: sparse QR failed");
    return out;
}
#else
constexpr double dropped = 1e-16; // entries of unit columns: below their rounding

/// Sparse QR by Givens rotations, one row of G^T after the other into R (George & Heath 1980); columns that
/// turn out dependent give their row of R back to the later ones (Heath 1982). Only R is kept.
class GivensQr {
  public:
    explicit GivensQr(int columns) : row_(columns) {}

    void insert(Entries w) {
        while (!w.empty()) {
            Entries& r = row_[w.front().first];
            if (r.empty()) {
                r = std::move(w);
                return;
            }
            rotate(r, w);
        }
    }

    void release_dependent(double tolerance) {
        for (Entries& r : row_) {
            if (r.empty() || std::abs(r.front().second) >= tolerance)
                continue;
            Entries w(r.begin() + 1, r.end());
            r.clear();
            insert(std::move(w));
        }
    }

    const std::vector<Entries>& rows() const { return row_; }

  private:
    /// Turns the pair of rows so that the leading entry of w vanishes; both lead in the same column.
    void rotate(Entries& r, Entries& w) {
        const double length = std::hypot(r.front().second, w.front().second);
        const double c = r.front().second / length, s = w.front().second / length;
        new_r_.assign(1, {r.front().first, length});
        new_w_.clear();
        std::size_t i = 1, j = 1;
        while (i < r.size() || j < w.size()) {
            const int at_r = i < r.size() ? r[i].first : std::numeric_limits<int>::max();
            const int at_w = j < w.size() ? w[j].first : std::numeric_limits<int>::max();
            const int column = std::min(at_r, at_w);
            const double x = at_r == column ? r[i++].second : 0.0;
            const double y = at_w == column ? w[j++].second : 0.0;
            if (const double v = c * x + s * y; std::abs(v) > dropped)
                new_r_.emplace_back(column, v);
            if (const double v = c * y - s * x; std::abs(v) > dropped)
                new_w_.emplace_back(column, v);
        }
        r.swap(new_r_);
        w.swap(new_w_);
    }

    std::vector<Entries> row_; // row k of R, leading entry in column k; empty if there is none
    Entries new_r_, new_w_;
};

/// Minimum degree on the rows of g that share an unknown: R has the fill of the Cholesky factor of G G^T.
std::vector<int> fill_reducing_order(const SparseMatrix& gt) {
    const SparseMatrix normal = SparseMatrix(gt.transpose()) * gt;
    CscPattern pattern;
    pattern.rows = pattern.cols = static_cast<int>(gt.cols());
    pattern.col_start.assign(normal.outerIndexPtr(), normal.outerIndexPtr() + normal.cols() + 1);
    pattern.row.assign(normal.innerIndexPtr(), normal.innerIndexPtr() + normal.nonZeros());
    return minimum_degree_ordering(pattern);
}

Staircase factor(const SparseMatrix& gt, double tolerance) {
    Staircase out;
    out.order = fill_reducing_order(gt);
    std::vector<int> place(out.order.size());
    for (std::size_t k = 0; k < place.size(); ++k)
        place[out.order[k]] = static_cast<int>(k);
    std::vector<Entries> unknowns(gt.rows());
    for (int i = 0; i < gt.cols(); ++i)
        for (SparseMatrix::InnerIterator it(gt, i); it; ++it)
            unknowns[it.row()].emplace_back(place[i], it.value());
    for (Entries& w : unknowns)
        std::sort(w.begin(), w.end());
    std::sort(unknowns.begin(), unknowns.end());
    GivensQr qr(static_cast<int>(gt.cols()));
    for (Entries& w : unknowns)
        qr.insert(std::move(w));
    qr.release_dependent(tolerance);
    out.column.resize(gt.cols());
    int step = 0;
    for (const Entries& r : qr.rows()) {
        for (const auto& [column, value] : r)
            out.column[column].emplace_back(step, value);
        step += !r.empty();
    }
    return out;
}
#endif

double largest(const Entries& v) {
    double out = 0;
    for (const auto& [row, value] : v)
        out = std::max(out, std::abs(value));
    return out;
}

/// v - factor * w, without the negligible rest; the entry at `gone` vanishes by construction.
Entries subtract(const Entries& v, double factor, const Entries& w, int gone) {
    const double cut = negligible * std::max(largest(v), std::abs(factor) * largest(w));
    Entries out;
    std::size_t i = 0, j = 0;
    while (i < v.size() || j < w.size()) {
        const int row =
            std::min(i < v.size() ? v[i].first : w[j].first, j < w.size() ? w[j].first : v[i].first);
        double value = 0;
        if (i < v.size() && v[i].first == row)
            value += v[i++].second;
        if (j < w.size() && w[j].first == row)
            value -= factor * w[j++].second;
        if (row != gone && std::abs(value) > cut)
            out.emplace_back(row, value);
    }
    return out;
}

void scale_and_trim(Entries& v, double factor) {
    const double cut = negligible * largest(v) * std::abs(factor);
    for (auto& [row, value] : v)
        value *= factor;
    std::erase_if(v, [&](const auto& entry) { return std::abs(entry.second) <= cut; });
}

/// One vanishing combination of rows per column of R that adds no stair, by back substitution.
std::vector<Entries> null_vectors(const Staircase& r) {
    std::vector<int> stair; // column of R that has its last entry on each step
    std::vector<Entries> out;
    std::vector<double> work(r.column.size(), 0.0);
    for (int k = 0; k < std::ssize(r.column); ++k) {
        const Entries& column = r.column[k];
        const int steps = static_cast<int>(stair.size());
        if (!column.empty() && column.back().first == steps) {
            stair.push_back(k);
            continue;
        }
        for (const auto& [row, value] : column)
            work[row] = value;
        Entries v{{r.order[k], 1.0}};
        for (int s = column.empty() ? -1 : column.back().first; s >= 0; --s) {
            if (work[s] == 0)
                continue;
            const Entries& basis = r.column[stair[s]];
            const double c = work[s] / basis.back().second;
            for (const auto& [row, value] : basis)
                work[row] -= c * value;
            work[s] = 0;
            v.emplace_back(r.order[stair[s]], -c);
        }
        std::sort(v.begin(), v.end());
        scale_and_trim(v, 1 / largest(v));
        out.push_back(std::move(v));
    }
    return out;
}

/// Reduced echelon form from the last row upwards: each vector ends at a row no other vector contains.
std::vector<Entries> reduce(std::vector<Entries> vectors, int rows) {
    std::vector<std::vector<Entries>> ending(rows);
    for (Entries& v : vectors)
        ending[v.back().first].push_back(std::move(v));
    std::vector<Entries> owner(rows);
    for (int row = rows - 1; row >= 0; --row) {
        std::vector<Entries>& group = ending[row];
        if (group.empty())
            continue;
        const auto best =
            std::max_element(group.begin(), group.end(), [](const Entries& x, const Entries& y) {
                return std::abs(x.back().second) < std::abs(y.back().second);
            });
        std::swap(*best, group.back());
        Entries pivot = std::move(group.back());
        group.pop_back();
        scale_and_trim(pivot, 1 / pivot.back().second);
        for (const Entries& v : group) {
            Entries rest = subtract(v, v.back().second, pivot, row);
            if (rest.empty())
                continue;
            scale_and_trim(rest, 1 / largest(rest));
            ending[rest.back().first].push_back(std::move(rest));
        }
        owner[row] = std::move(pivot);
    }
    std::vector<Entries> out;
    for (int row = 0; row < rows; ++row) {
        if (owner[row].empty())
            continue;
        Entries& v = owner[row];
        for (int bound = row;;) { // entries below the bound are still to be looked at
            auto entry = std::lower_bound(v.begin(), v.end(), std::pair(bound, -infinity));
            if (entry == v.begin())
                break;
            --entry;
            bound = entry->first;
            if (!owner[bound].empty())
                v = subtract(v, entry->second, owner[bound], bound);
        }
        out.push_back(v);
    }
    return out;
}

} // namespace

RankReport rank_of_rows(const CscMatrix& g, double tolerance) {
    const CscPattern& a = g.pattern;
    check_pattern(a);
    if (std::ssize(g.values) != a.nonzeros())
        throw std::invalid_argument("one value per pattern entry is needed");
    if (!(tolerance > 0 && tolerance < 1))
        throw std::invalid_argument("rank tolerance: between 0 and 1 is needed");
    std::vector<double> size(a.rows, 0.0), length(a.rows, 0.0);
    for (int p = 0; p < a.nonzeros(); ++p) {
        if (!std::isfinite(g.values[p]))
            throw std::invalid_argument("rank of the constraints: values must be finite");
        size[a.row[p]] = std::max(size[a.row[p]], std::abs(g.values[p]));
    }
    for (int p = 0; p < a.nonzeros(); ++p)
        if (const double s = size[a.row[p]]; s > 0)
            length[a.row[p]] += g.values[p] / s * (g.values[p] / s);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < a.rows; ++i)
        length[i] = size[i] > 0 ? size[i] * std::sqrt(length[i]) : 1.0;
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            if (g.values[p] != 0)
                entries.emplace_back(j, a.row[p], g.values[p] / length[a.row[p]]);

    std::vector<Entries> vectors;
    if (entries.empty()) {
        for (int i = 0; i < a.rows; ++i)
            vectors.push_back({{i, 1.0}});
    } else {
        SparseMatrix gt(a.cols, a.rows);
        gt.setFromTriplets(entries.begin(), entries.end());
        gt.makeCompressed();
        vectors = null_vectors(factor(gt, tolerance));
    }
    RankReport report;
    for (Entries& v : reduce(std::move(vectors), a.rows)) {
        const int row = v.back().first;
        for (auto& [i, c] : v)
            c *= length[row] / length[i];
        report.dependent.push_back({row, std::move(v)});
    }
    report.rank = a.rows - static_cast<int>(report.dependent.size());
    return report;
}

void RankReport::Dependence::visit(Archive& archive) {
    std::size_t terms = combination.size();
    archive(row, terms);
    combination.resize(terms);
    for (auto& [other, coefficient] : combination)
        archive(other, coefficient);
}

} // namespace gudgeon
