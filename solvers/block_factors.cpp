#include "solvers/block_factors.hpp"

#include "solvers/block_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace gudgeon {

namespace {

constexpr double back_to_single = 5e-3;
constexpr double pivot_for_single = 1e-3; // of the scaled matrix; with smaller ones digits are lost

constexpr std::size_t ahead = 2; // fronts

/// Blocks of fronts lie apart, each pass leaving out the other's: their lines are asked for before their
/// turn.
template <class Stored> void fetch(const Stored* block, long size) {
    constexpr long line = 64 / sizeof(Stored), most = 16 * line;
    for (long i = 0; i < std::min(size, most); i += line)
        __builtin_prefetch(block + i);
}

template <class Stored> Stored narrowed(double x) { return static_cast<Stored>(x); }

double size_of(double x) { return std::abs(x); }
double size_of(std::complex<double> x) { return std::max(std::abs(x.real()), std::abs(x.imag())); }

double part_of(double x, int) { return x; }
double part_of(std::complex<double> x, int plane) { return plane ? x.imag() : x.real(); }

} // namespace

template <class Scalar>
BlockFactors<Scalar>::BlockFactors(std::shared_ptr<const BlockStructure> structure, int threads,
                                   bool single_precision)
    : structure_(std::move(structure)), may_be_single_(single_precision), in_single_(single_precision),
      threads_(threads) {
    const BlockStructure& s = *structure_;
    scale_.assign(s.unknowns, 1.0);
    if (in_single_)
        single_.assign(planes * std::size_t(s.factors), 0.0F);
    else
        double_.assign(planes * std::size_t(s.factors), 0.0);
    benches_.resize(s.parts.size());
    for (std::size_t i = 0; i < s.parts.size(); ++i) {
        const std::size_t largest = s.parts[i].largest;
        benches_[i].front.assign(planes * Front::padded(s.parts[i].largest) * largest, 0.0);
        benches_[i].scale.assign(largest, 0.0);
        benches_[i].swaps.assign(largest, 0);
        benches_[i].updates.assign(planes * std::size_t(s.parts[i].stack), 0.0);
    }
}

template <class Scalar> template <class Visit> void BlockFactors<Scalar>::for_subtrees(Visit&& visit) {
    const int subtrees = static_cast<int>(structure_->parts.size()) - 1;
    if (threads_ > 1 && subtrees > 1) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_)
        for (int i = 0; i < subtrees; ++i)
            visit(i);
        return;
    }
    for (int i = 0; i < subtrees; ++i)
        visit(i);
}

// The scale of a body's unknown makes its diagonal number about one, that of a row the largest of its G.
template <class Scalar> void BlockFactors<Scalar>::find_scale(std::span<const Scalar> values) {
    const BlockStructure& s = *structure_;
    for (int x = 0; x < s.unknowns; ++x) {
        const double own = s.diagonal[x] < 0 ? 0 : size_of(values[s.diagonal[x]]);
        scale_[x] = own > 0 ? std::ldexp(1.0, -std::ilogb(own) / 2) : 0;
    }
    for (const Front& front : s.fronts)
        s.for_entries(front.entry_start, front.row_end, [&](int place, int col, int slot) {
            double& row = scale_[s.unknown(front, col)];
            row = std::min(row, -scale_[s.unknown(front, place)] * size_of(values[slot]));
        });
    for (double& scale : scale_) // of rows: negative so far
        scale = scale < 0 ? std::ldexp(1.0, -std::ilogb(scale)) : scale > 0 ? scale : 1.0;
}

template <class Scalar>
void BlockFactors<Scalar>::assemble(const Front& front, std::span<const Scalar> values, Bench& bench) const {
    const BlockStructure& s = *structure_;
    const int height = front.height();
    std::copy_n(scale_.begin() + front.first, front.pivots, bench.scale.begin());
    for (int i = 0; i < front.boundary; ++i)
        bench.scale[front.pivots + i] = scale_[s.boundary[front.boundary_start + i]];
    std::fill_n(bench.front.begin(), std::size_t(planes) * height * front.size(), 0.0);
    for (int e = front.entry_start; e < front.entry_end; ++e) {
        const FrontEntries entry = s.entries[e];
        const double* scale = bench.scale.data() + entry.row;
        const Scalar* from = values.data() + entry.slot;
        double* to = bench.front.data() + std::size_t(entry.col) * planes * height + entry.row;
        for (int i = 0; i < entry.count(); ++i) {
            const double factor = scale[i] * bench.scale[entry.col];
            for (int p = 0; p < planes; ++p)
                to[p * height + i] = factor * part_of(from[i], p);
        }
    }
}

template <class Scalar> void BlockFactors<Scalar>::add_children(const Front& front, Bench& bench) const {
    const BlockStructure& s = *structure_;
    const int height = front.height();
    for (int child = front.last_child; child >= 0; child = s.sibling[child]) {
        const Front& from = s.fronts[child];
        const int* place = s.boundary_place.data() + from.boundary_start;
        const double* update = benches_[from.part].updates.data() + planes * from.update_start;
        for (int j = 0; j < from.boundary; ++j)
            for (int p = 0; p < planes; ++p, update += from.boundary) {
                double* to = bench.front.data() + (std::size_t(place[j]) * planes + p) * height;
                for (int i = 0; i < from.boundary; ++i)
                    to[place[i]] += update[i];
            }
    }
}

template <class Scalar>
template <class Stored>
void BlockFactors<Scalar>::keep(const Front& front, std::vector<Stored>& factors, Bench& bench) {
    const int height = front.height(), pivot_height = front.pivot_height();
    const double* f = bench.front.data();
    Stored* to = factors.data() + planes * front.factor_start;
    const std::size_t left = std::size_t(planes) * height * front.pivots;
    std::transform(f, f + left, to, narrowed<Stored>);
    f += left;
    to += left;
    double* update = bench.updates.data() + planes * front.update_start;
    for (int j = 0; j < planes * front.boundary; ++j, f += height) {
        std::transform(f, f + front.pivots, to, narrowed<Stored>);
        std::fill(to + front.pivots, to + pivot_height, Stored(0));
        to += pivot_height;
        std::copy_n(f + front.pivots, front.boundary, update);
        update += front.boundary;
    }
}

template <class Scalar> void BlockFactors<Scalar>::factor_part(int part, std::span<const Scalar> values) {
    const BlockStructure& s = *structure_;
    const BlockKernels::Sweep sweep = block_kernels().sweep[planes - 1];
    Bench& bench = benches_[part];
    bench.quality = {true, 1, -1};
    for (const int k : s.parts[part].fronts) {
        const Front& front = s.fronts[k];
        assemble(front, values, bench);
        add_children(front, bench);
        int column = 0;
        const double pivot = sweep(bench.front.data(), front.size(), front.pivots, front.height(),
                                   bench.swaps.data(), &column);
        if (!(pivot > 0)) {
            bench.quality = {false, 0, s.order[front.first + column]};
            return;
        }
        if (pivot < bench.quality.smallest_pivot) {
            bench.quality.smallest_pivot = pivot;
            bench.quality.column = s.order[front.first + column];
        }
        in_single_ ? keep(front, single_, bench) : keep(front, double_, bench);
    }
}

template <class Scalar> auto BlockFactors<Scalar>::factor(std::span<const Scalar> values) -> Quality {
    find_scale(values);
    Quality quality = factor_once(values);
    if (in_single_ && quality.usable && quality.smallest_pivot < pivot_for_single) {
        in_single_ = false;
        double_.resize(single_.size()); // once, where pivots are small
        quality = factor_once(values);
    } else if (may_be_single_ && !in_single_ && quality.smallest_pivot > back_to_single) {
        in_single_ = true;
        quality = factor_once(values);
    }
    return quality;
}

template <class Scalar> auto BlockFactors<Scalar>::factor_once(std::span<const Scalar> values) -> Quality {
    for_subtrees([&](int part) { factor_part(part, values); });
    Quality worst{true, 1, -1};
    for (std::size_t part = 0; part < benches_.size(); ++part) {
        if (part + 1 == benches_.size())
            factor_part(static_cast<int>(part), values); // the trunk
        const Quality& quality = benches_[part].quality;
        if (!quality.usable)
            return quality;
        if (quality.smallest_pivot < worst.smallest_pivot)
            worst = quality;
    }
    return worst;
}

template <class Scalar> void BlockFactors<Scalar>::reserve_columns(int columns) {
    const BlockStructure& s = *structure_;
    const std::size_t n = std::size_t(planes) * columns;
    if (x_.size() >= n * (s.unknowns + s.sums))
        return;
    x_.resize(n * (s.unknowns + s.sums));
    for (std::size_t i = 0; i < benches_.size(); ++i)
        for (auto* y : {&benches_[i].product, &benches_[i].gathered})
            y->resize(n * Front::padded(s.parts[i].largest));
}

template <class Scalar>
void BlockFactors<Scalar>::load(int first, int last, std::span<const Scalar> rhs, int columns) {
    const BlockStructure& s = *structure_;
    const std::ptrdiff_t n = s.unknowns, stride = n + s.sums;
    for (int c = 0; c < columns; ++c)
        for (int p = 0; p < planes; ++p) {
            double* x = x_.data() + (planes * c + p) * stride;
            const Scalar* b = rhs.data() + c * n;
            for (int i = first; i < last; ++i)
                x[i] = scale_[i] * part_of(b[s.order[i]], p);
        }
}

template <class Scalar>
void BlockFactors<Scalar>::unload(int first, int last, std::span<Scalar> rhs, int columns) const {
    const BlockStructure& s = *structure_;
    const std::ptrdiff_t n = s.unknowns, stride = n + s.sums;
    for (int c = 0; c < columns; ++c) {
        const double* x = x_.data() + planes * c * stride;
        Scalar* b = rhs.data() + c * n;
        for (int i = first; i < last; ++i) {
            if constexpr (planes == 1)
                b[s.order[i]] = scale_[i] * x[i];
            else
                b[s.order[i]] = {scale_[i] * x[i], scale_[i] * x[stride + i]};
        }
    }
}

template <class Scalar>
template <class Stored>
void BlockFactors<Scalar>::forward(int part, const std::vector<Stored>& factors, int columns) {
    const BlockStructure& s = *structure_;
    const auto product = block_kernels().product_of<Stored>(planes);
    const long stride = s.unknowns + s.sums;
    double* y = benches_[part].product.data();
    const std::vector<int>& fronts = s.parts[part].fronts;
    for (std::size_t i = 0; i < fronts.size(); ++i) {
        const Front& front = s.fronts[fronts[i]];
        const int height = front.height();
        if (i + ahead < fronts.size()) {
            const Front& later = s.fronts[fronts[i + ahead]];
            fetch(factors.data() + planes * later.factor_start, long(planes) * later.height() * later.pivots);
        }
        product(factors.data() + planes * front.factor_start, height, front.pivots, x_.data() + front.first,
                planes * stride, stride, y, long(planes) * height, columns);
        const int* place = s.sum_place.data() + front.boundary_start;
        for (int c = 0; c < planes * columns; ++c) {
            const double* from = y + std::ptrdiff_t(c) * height;
            double* x = x_.data() + c * stride;
            std::copy_n(from, front.pivots, x + front.first);
            for (int i = 0; i < front.boundary; ++i)
                x[place[i]] += from[front.pivots + i];
        }
    }
}

template <class Scalar>
template <class Stored>
void BlockFactors<Scalar>::backward(int part, const std::vector<Stored>& factors, int columns) {
    const BlockStructure& s = *structure_;
    const auto product = block_kernels().product_of<Stored>(planes);
    const long stride = s.unknowns + s.sums;
    const std::vector<int>& fronts = s.parts[part].fronts;
    double *y = benches_[part].product.data(), *gathered = benches_[part].gathered.data();
    for (std::size_t i = fronts.size(); i-- > 0;) {
        const Front& front = s.fronts[fronts[i]];
        if (i >= ahead) {
            const Front& later = s.fronts[fronts[i - ahead]];
            fetch(factors.data() + planes * (later.factor_start + long(later.height()) * later.pivots),
                  long(planes) * later.pivot_height() * later.boundary);
        }
        if (front.boundary == 0)
            continue;
        const int height = front.pivot_height();
        const int* boundary = s.boundary.data() + front.boundary_start;
        for (int c = 0; c < planes * columns; ++c)
            for (int b = 0; b < front.boundary; ++b)
                gathered[c * front.boundary + b] = x_[c * stride + boundary[b]];
        product(factors.data() + planes * (front.factor_start + long(front.height()) * front.pivots), height,
                front.boundary, gathered, long(planes) * front.boundary, front.boundary, y,
                long(planes) * height, columns);
        for (int c = 0; c < planes * columns; ++c)
            for (int b = 0; b < front.pivots; ++b)
                x_[c * stride + front.first + b] -= y[c * height + b];
    }
}

template <class Scalar> void BlockFactors<Scalar>::solve(std::span<Scalar> rhs, int columns) {
    in_single_ ? substitute(single_, rhs, columns) : substitute(double_, rhs, columns);
}

template <class Scalar>
template <class Stored>
void BlockFactors<Scalar>::substitute(const std::vector<Stored>& factors, std::span<Scalar> rhs,
                                      int columns) {
    const BlockStructure& s = *structure_;
    const std::ptrdiff_t stride = s.unknowns + s.sums;
    const int trunk = static_cast<int>(s.parts.size()) - 1;
    reserve_columns(columns);
    for (int c = 0; c < planes * columns; ++c)
        std::fill_n(x_.begin() + c * stride + s.unknowns, s.sums, 0.0);
    const auto for_trunk = [&](auto&& visit) {
        for (const int k : s.parts[trunk].fronts)
            visit(s.fronts[k].first, s.fronts[k].first + s.fronts[k].pivots);
    };
    for_subtrees([&](int part) {
        load(s.parts[part].first, s.parts[part].last, rhs, columns);
        forward(part, factors, columns);
    });
    for_trunk([&](int first, int last) { load(first, last, rhs, columns); });
    for (int part = 0; part < trunk; ++part) {
        const Front& root = s.fronts[s.parts[part].root];
        for (int c = 0; c < planes * columns; ++c)
            for (int i = 0; i < root.boundary; ++i)
                x_[c * stride + s.boundary[root.boundary_start + i]] +=
                    x_[c * stride + s.parts[part].sums_start + i];
    }
    forward(trunk, factors, columns);
    backward(trunk, factors, columns);
    for_trunk([&](int first, int last) { unload(first, last, rhs, columns); });
    for_subtrees([&](int part) {
        backward(part, factors, columns);
        unload(s.parts[part].first, s.parts[part].last, rhs, columns);
    });
}

template <class Scalar> double BlockFactors<Scalar>::backward_error(std::span<const Scalar> values) {
    const BlockStructure& s = *structure_;
    std::vector<Scalar> right(s.unknowns, Scalar(0)), x;
    const auto sign = [](int i) { return (unsigned(i) * 2654435761u >> 16) & 1 ? 1.0 : -1.0; };
    std::vector<double> terms(s.unknowns, 0.0);
    const auto for_entries = [&](auto&& visit) {
        for (const Front& front : s.fronts)
            s.for_entries(front.entry_start, front.entry_end, [&](int row, int col, int slot) {
                const int i = s.unknown(front, row), j = s.unknown(front, col);
                visit(s.order[i], s.order[j], scale_[i], scale_[j], values[slot]);
            });
    };
    for_entries(
        [&](int i, int j, double, double scale, Scalar value) { right[i] += value * (scale * sign(j)); });
    x = right;
    solve(x, 1);
    double residual = 0, largest = 0;
    for_entries([&](int i, int j, double scale, double, Scalar value) {
        right[i] -= value * x[j];
        terms[i] += scale * size_of(value * x[j]);
    });
    for (int k = 0; k < s.unknowns; ++k) {
        const int i = s.order[k];
        residual = std::max(residual, scale_[k] * size_of(right[i]));
        largest = std::max(largest, terms[i]);
    }
    return largest > 0 ? residual / largest : 0;
}

template <class Scalar> void BlockFactors<Scalar>::visit(Archive& archive) {
    std::uint64_t order = 14695981039346656037u; // of elimination, as a hash (FNV-1a)
    for (const int x : structure_->order)
        order = (order ^ static_cast<std::uint64_t>(x)) * 1099511628211u;
    archive.same(order, "another order of elimination");
    archive(scale_, in_single_);
    if (in_single_)
        archive(single_);
    else
        archive(double_);
}

template class BlockFactors<double>;
template class BlockFactors<std::complex<double>>;

} // namespace gudgeon
