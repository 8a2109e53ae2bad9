#include "solvers/equilibration.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {
constexpr int no_entry = -100000;
constexpr int exponent_limit = 400; // keeps row * col and their product with sane values finite
constexpr int most_sweeps = 6;
constexpr double negligible_diagonal = 1e-6; // such as -E of a saddle point with soft rows
} // namespace

void Equilibration::analyse(const CscPattern& pattern) {
    pattern_ = pattern;
    const int n = pattern.cols;
    diagonal_.assign(n, -1);
    for (int j = 0; j < n; ++j)
        for (int p = pattern.col_start[j]; p < pattern.col_start[j + 1]; ++p)
            if (pattern.row[p] == j)
                diagonal_[j] = p;
    multiplier_.assign(n, 0);
    exponent_.assign(pattern.nonzeros(), 0);
    row_exponent_.assign(n, 0);
    col_exponent_.assign(n, 0);
    row_max_.assign(n, 0);
    col_max_.assign(n, 0);
    row_.assign(n, 1.0);
    col_.assign(n, 1.0);
}

void Equilibration::reset_maxima() {
    std::fill(row_max_.begin(), row_max_.end(), no_entry);
    std::fill(col_max_.begin(), col_max_.end(), no_entry);
}

/// No diagonal entry, or one as small and negative as a regularised saddle point has it: measured by
/// a_ij a_ji / a_jj, which no choice of units changes.
void Equilibration::find_multipliers(std::span<const double> values) {
    const int n = pattern_.cols;
    const auto diagonal = [&](int i) { return diagonal_[i] < 0 ? 0.0 : values[diagonal_[i]]; };
    for (int j = 0; j < n; ++j) {
        const double own = diagonal(j);
        multiplier_[j] = own == 0;
        if (own >= 0)
            continue;
        for (int p = pattern_.col_start[j]; p < pattern_.col_start[j + 1]; ++p)
            if (const double other = diagonal(pattern_.row[p]); other > 0)
                multiplier_[j] |= -own <= negligible_diagonal * values[p] / other * values[p];
    }
}

/// One Ruiz sweep over the block of ordinary unknowns; true when nothing changes any more.
bool Equilibration::sweep() {
    const int n = pattern_.cols;
    reset_maxima();
    for (int j = 0; j < n; ++j) {
        if (multiplier_[j])
            continue;
        for (int p = pattern_.col_start[j]; p < pattern_.col_start[j + 1]; ++p) {
            const int i = pattern_.row[p];
            if (multiplier_[i] || exponent_[p] == no_entry)
                continue;
            const int e = exponent_[p] + row_exponent_[i] + col_exponent_[j];
            row_max_[i] = std::max(row_max_[i], e);
            col_max_[j] = std::max(col_max_[j], e);
        }
    }
    bool settled = true;
    for (int i = 0; i < n; ++i) {
        if (multiplier_[i])
            continue;
        row_exponent_[i] -= row_max_[i] / 2; // towards zero: a remainder of one is left alone
        col_exponent_[i] -= col_max_[i] / 2;
        settled = settled && row_max_[i] / 2 == 0 && col_max_[i] / 2 == 0;
    }
    return settled;
}

void Equilibration::scale_multipliers() {
    const int n = pattern_.cols;
    reset_maxima();
    for (int j = 0; j < n; ++j)
        for (int p = pattern_.col_start[j]; p < pattern_.col_start[j + 1]; ++p) {
            const int i = pattern_.row[p];
            if (exponent_[p] == no_entry || (multiplier_[i] && multiplier_[j]))
                continue;
            if (multiplier_[i])
                row_max_[i] = std::max(row_max_[i], exponent_[p] + col_exponent_[j]);
            if (multiplier_[j])
                col_max_[j] = std::max(col_max_[j], exponent_[p] + row_exponent_[i]);
        }
    for (int i = 0; i < n; ++i)
        if (multiplier_[i]) {
            row_exponent_[i] = row_max_[i] == no_entry ? 0 : -row_max_[i];
            col_exponent_[i] = col_max_[i] == no_entry ? 0 : -col_max_[i];
        }
}

void Equilibration::compute(std::span<const double> values) {
    find_multipliers(values);
    for (std::size_t p = 0; p < exponent_.size(); ++p)
        exponent_[p] = values[p] == 0 ? no_entry : std::ilogb(values[p]);
    std::fill(row_exponent_.begin(), row_exponent_.end(), 0);
    std::fill(col_exponent_.begin(), col_exponent_.end(), 0);
    for (int k = 0; k < most_sweeps; ++k)
        if (sweep())
            break;
    scale_multipliers();
    for (std::size_t i = 0; i < row_.size(); ++i) {
        row_[i] = std::ldexp(1.0, std::clamp(row_exponent_[i], -exponent_limit, exponent_limit));
        col_[i] = std::ldexp(1.0, std::clamp(col_exponent_[i], -exponent_limit, exponent_limit));
    }
}

} // namespace gudgeon
