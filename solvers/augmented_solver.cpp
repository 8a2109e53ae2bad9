#include "solvers/augmented_solver_impl.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gudgeon {

namespace {

using Complex = std::complex<double>;
using RealVector = Eigen::VectorXd;

double power_of_two(double square) { return square > 0 ? std::ldexp(1.0, -std::ilogb(square) / 2) : 1.0; }

/// Pattern of H: both triangles of A and the pairs of each row of G.
CscPattern augmented_pattern(const CscPattern& k, int n) {
    std::vector<std::vector<int>> columns(n), rows(k.cols - n);
    for (int j = 0; j < n; ++j) {
        columns[j].push_back(j);
        for (int p = k.col_start[j]; p < k.col_start[j + 1]; ++p) {
            if (k.row[p] >= n) {
                rows[k.row[p] - n].push_back(j);
            } else {
                columns[j].push_back(k.row[p]);
                columns[k.row[p]].push_back(j);
            }
        }
    }
    for (const std::vector<int>& row : rows)
        for (const int i : row)
            for (const int j : row)
                columns[j].push_back(i);
    CscPattern out{n, n, {0}, {}};
    for (std::vector<int>& c : columns) {
        std::sort(c.begin(), c.end());
        c.erase(std::unique(c.begin(), c.end()), c.end());
        out.row.insert(out.row.end(), c.begin(), c.end());
        out.col_start.push_back(out.nonzeros());
    }
    return out;
}

} // namespace

void AugmentedSolver::Impl::find_slots() {
    a_slot.clear();
    product_slot.clear();
    for (int j = 0; j < parts.n; ++j)
        for (int p = parts.a_start[j]; p < parts.a_start[j + 1]; ++p)
            a_slot.push_back(cholesky.slot(parts.a_row[p], j));
    for (int r = 0; r < parts.m; ++r)
        for (int p = parts.g_start[r]; p < parts.g_start[r + 1]; ++p)
            for (int q = p; q < parts.g_start[r + 1]; ++q)
                product_slot.push_back(cholesky.slot(parts.g_col[p], parts.g_col[q]));
}

void AugmentedSolver::Impl::scale(std::span<const double> values) {
    for (int j = 0; j < parts.n; ++j) {
        double diagonal = 0;
        for (int p = parts.a_start[j]; p < parts.a_start[j + 1]; ++p)
            if (parts.a_row[p] == j)
                diagonal = std::abs(values[parts.a_at[p]]);
        scaling.unknown[j] = power_of_two(diagonal);
    }
    for (int r = 0; r < parts.m; ++r) {
        double square = 0;
        for (int p = parts.g_start[r]; p < parts.g_start[r + 1]; ++p) {
            const double g = values[parts.g_at[p]] * scaling.unknown[parts.g_col[p]];
            square += g * g;
        }
        scaling.multiplier[r] = power_of_two(square);
    }
}

void AugmentedSolver::Impl::assemble() {
    std::vector<double>& h = cholesky.values();
    std::fill(h.begin(), h.end(), 0.0);
    for (int j = 0; j < parts.n; ++j)
        for (int p = parts.a_start[j]; p < parts.a_start[j + 1]; ++p)
            h[a_slot[p]] += parts.a_row[p] == j ? k.a[p] : 0.5 * k.a[p];
    std::size_t next = 0;
    for (int r = 0; r < parts.m; ++r) {
        weight[r] = 1 / (std::max(k.e[r], 0.0) + 1 / options.penalty);
        for (int p = parts.g_start[r]; p < parts.g_start[r + 1]; ++p) {
            const double g = weight[r] * k.g[p];
            for (int q = p; q < parts.g_start[r + 1]; ++q)
                h[product_slot[next++]] += g * k.g[q];
        }
    }
}

FactorStatus AugmentedSolver::Impl::factor_by_klu() {
    if (!klu_analysed)
        klu.analyse(pattern);
    klu_analysed = true;
    const FactorStatus status = klu.factor(original);
    klu_in_use = status.ok();
    own.klu_fallbacks += klu_in_use;
    return status;
}

// x = D rhs, leading unknowns as placed
void AugmentedSolver::Impl::scaled_in(const double* rhs, RealVector& x) const {
    for (int i = 0; i < parts.n; ++i)
        x[parts.place[i]] = scaling.unknown[parts.place[i]] * rhs[i];
    for (int r = 0; r < parts.m; ++r)
        x[parts.n + r] = scaling.multiplier[r] * rhs[parts.n + r];
}

bool AugmentedSolver::Impl::solve_one(double* rhs) {
    scaled_in(rhs, one);
    const auto result = single.solve(one, options.tolerance, [&](const auto& v, auto& z, auto& w) {
        pass(v, z, one_gz);
        k.times(parts, z, one_gz, w);
    });
    ++own.cholmod_solves;
    own.cholmod_iterations += result.iterations;
    if (!result.converged && factor_by_klu().ok())
        return false;
    for (int i = 0; i < parts.n; ++i)
        rhs[i] = scaling.unknown[parts.place[i]] * one[parts.place[i]];
    for (int r = 0; r < parts.m; ++r)
        rhs[parts.n + r] = scaling.multiplier[r] * one[parts.n + r];
    return true;
}

// K is real: the real and imaginary part of one complex right-hand side are two real ones.
bool AugmentedSolver::Impl::solve_two(double* first, double* second) {
    for (int i = 0; i < parts.n; ++i)
        two[parts.place[i]] = scaling.unknown[parts.place[i]] * Complex(first[i], second[i]);
    for (int r = parts.n; r < parts.n + parts.m; ++r)
        two[r] = scaling.multiplier[r - parts.n] * Complex(first[r], second[r]);
    const double first_size = two.real().norm(), second_size = two.imag().norm();
    if (first_size == 0 || second_size == 0) {
        double* const other = first_size == 0 ? second : first;
        return std::max(first_size, second_size) == 0 || solve_one(other);
    }
    for (Complex& x : two)
        x = {x.real() / first_size, x.imag() / second_size};
    const auto result = pair.solve(two, options.tolerance, [&](const auto& v, auto& z, auto& w) {
        pass(v, z, two_gz);
        k.times(parts, z, two_gz, w);
    });
    own.cholmod_solves += 2;
    own.cholmod_iterations += result.iterations;
    if (!result.converged && factor_by_klu().ok())
        return false;
    const auto out = [&](double scale, int i, int at) {
        first[i] = first_size * scale * two[at].real();
        second[i] = second_size * scale * two[at].imag();
    };
    for (int i = 0; i < parts.n; ++i)
        out(scaling.unknown[parts.place[i]], i, parts.place[i]);
    for (int r = 0; r < parts.m; ++r)
        out(scaling.multiplier[r], parts.n + r, parts.n + r);
    return true;
}

AugmentedSolver::AugmentedSolver(int leading, AugmentedOptions options)
    : impl_(std::make_unique<Impl>(leading, options)) {}
AugmentedSolver::~AugmentedSolver() = default;

void AugmentedSolver::analyse(const CscPattern& pattern) {
    check_pattern(pattern);
    Impl& s = *impl_;
    if (pattern.rows != pattern.cols || s.leading < 0 || s.leading > pattern.cols)
        throw std::invalid_argument("a square pattern, no smaller than its leading block, is needed");
    s.pattern = pattern;
    s.klu_analysed = s.klu_in_use = s.factored = false;
    s.cholesky.analyse(augmented_pattern(pattern, s.leading));
    s.parts = SaddleParts(pattern, s.leading, s.cholesky.place());
    s.find_slots();
    s.scaling.unknown.assign(s.parts.n, 1.0);
    s.scaling.multiplier.assign(s.parts.m, 1.0);
    s.k.resize(s.parts);
    s.weight.assign(s.parts.m, 0.0);
    s.original.assign(pattern.nonzeros(), 0.0);
    s.single.resize(pattern.cols, s.options.most_passes);
    s.pair.resize(pattern.cols, s.options.most_passes);
    s.one.setZero(pattern.cols);
    s.two.setZero(pattern.cols);
    s.one_gz.setZero(s.parts.m);
    s.two_gz.setZero(s.parts.m);
    ++s.own.analyses;
}

FactorStatus AugmentedSolver::factor(std::span<const double> values) {
    Impl& s = *impl_;
    if (std::ssize(values) != s.pattern.nonzeros() || s.own.analyses == 0)
        throw std::invalid_argument("one value per pattern entry is needed");
    if (s.factored && !s.klu_in_use)
        s.patience.served();
    s.factored = s.klu_in_use = false;
    for (int j = 0; j < s.pattern.cols; ++j)
        for (int p = s.pattern.col_start[j]; p < s.pattern.col_start[j + 1]; ++p)
            if (!std::isfinite(values[p]))
                return {FactorStatus::Kind::non_finite, j};
    std::copy(values.begin(), values.end(), s.original.begin());
    if (s.patience.wants_to_try()) {
        s.scale(values);
        s.k.load(s.parts, s.scaling, values);
        s.assemble();
        ++s.own.cholmod_factorisations;
        s.factored = s.cholesky.factor();
        if (s.factored)
            return {};
        s.patience.failed();
    }
    const FactorStatus status = s.factor_by_klu();
    s.factored = status.ok();
    return status;
}

void AugmentedSolver::solve(std::span<double> rhs, int columns) {
    Impl& s = *impl_;
    if (!s.factored)
        throw std::logic_error("solve without factors");
    const auto size = static_cast<std::size_t>(s.pattern.cols);
    if (columns < 0 || rhs.size() != size * static_cast<std::size_t>(columns))
        throw std::invalid_argument("right-hand side of another size");
    s.own.solves += columns;
    for (int c = 0; c < columns && size > 0;) {
        double* const first = rhs.data() + size * static_cast<std::size_t>(c);
        const int together = std::min(2, columns - c);
        const bool before = s.klu_in_use;
        if (before || !(together == 2 ? s.solve_two(first, first + size) : s.solve_one(first))) {
            if (!before)
                s.patience.failed();
            s.klu.solve({first, size * static_cast<std::size_t>(together)}, together);
        }
        c += together;
    }
}

void AugmentedSolver::pass(std::span<double> rhs) {
    Impl& s = *impl_;
    if (!factored_by_cholmod())
        throw std::logic_error("a pass without a positive definite factor");
    if (std::ssize(rhs) != s.pattern.cols)
        throw std::invalid_argument("right-hand side of another size");
    s.scaled_in(rhs.data(), s.one);
    RealVector& z = s.single.scratch();
    s.pass(s.one, z, s.one_gz);
    ++s.own.cholmod_solves;
    ++s.own.cholmod_iterations;
    for (int i = 0; i < s.parts.n; ++i)
        rhs[i] = s.scaling.unknown[s.parts.place[i]] * z[s.parts.place[i]];
    for (int r = 0; r < s.parts.m; ++r)
        rhs[s.parts.n + r] = s.scaling.multiplier[r] * z[s.parts.n + r];
}

bool AugmentedSolver::factored_by_cholmod() const { return impl_->factored && !impl_->klu_in_use; }

const LinearSolverCounts& AugmentedSolver::counts() const {
    const Impl& s = *impl_;
    const LinearSolverCounts& klu = s.klu.counts();
    s.counts = s.own;
    s.counts.factorisations = std::min(1L, s.own.cholmod_factorisations) + klu.factorisations;
    s.counts.refactorisations =
        s.own.cholmod_factorisations - std::min(1L, s.own.cholmod_factorisations) + klu.refactorisations;
    s.counts.off_diagonal_pivots = klu.off_diagonal_pivots;
    return s.counts;
}

long AugmentedSolver::factor_nonzeros() const {
    return impl_->klu_in_use ? impl_->klu.factor_nonzeros() : impl_->cholesky.factor_nonzeros();
}

} // namespace gudgeon
