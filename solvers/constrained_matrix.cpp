#include "solvers/constrained_matrix.hpp"

#include <algorithm>

namespace gudgeon {

// A dependent row and its column keep a unit on the diagonal and nothing else.
ConstrainedMatrix::ConstrainedMatrix(const System& system, const std::vector<int>& dependent)
    : system_(system), saddle_(system), dependent_(dependent) {
    const CscPattern& full = saddle_.pattern();
    const int n = system.velocities();
    std::vector<char> out(full.rows, 0);
    for (const int row : dependent)
        out[n + row] = 1;
    CscPattern pattern;
    pattern.rows = pattern.cols = full.cols;
    pattern.col_start.push_back(0);
    for (int j = 0; j < full.cols; ++j) {
        for (int p = full.col_start[j]; p < full.col_start[j + 1]; ++p) {
            if (out[j] || out[full.row[p]])
                cleared_.push_back(pattern.nonzeros());
            slot_.push_back(pattern.nonzeros());
            pattern.row.push_back(full.row[p]);
        }
        if (out[j]) { // its entries so far are of velocities, which come first
            unit_.push_back(pattern.nonzeros());
            pattern.row.push_back(j);
        }
        pattern.col_start.push_back(pattern.nonzeros());
    }
    values_.assign(full.nonzeros(), 0.0);
    kept_.assign(pattern.nonzeros(), 0.0);
    klu_.analyse(pattern);
}

FactorStatus ConstrainedMatrix::factor_values() {
    for (std::size_t i = 0; i < values_.size(); ++i)
        kept_[slot_[i]] = values_[i];
    for (const int slot : cleared_)
        kept_[slot] = 0;
    for (const int slot : unit_)
        kept_[slot] = 1;
    return klu_.factor(kept_);
}

FactorStatus ConstrainedMatrix::factor(const Workspace& ws, double a, double s) {
    saddle_.assemble(system_, ws, a, s, values_);
    return factor_values();
}

FactorStatus ConstrainedMatrix::factor_mass(const Workspace& ws) {
    saddle_.assemble_mass(system_, ws, 1.0, values_);
    return factor_values();
}

void ConstrainedMatrix::solve(VecX& force, VecX& residual) {
    const auto n = static_cast<std::size_t>(force.size());
    rhs_.resize(n + static_cast<std::size_t>(residual.size()));
    std::copy_n(force.data(), n, rhs_.begin());
    std::copy_n(residual.data(), residual.size(), rhs_.begin() + static_cast<std::ptrdiff_t>(n));
    for (const int row : dependent_)
        rhs_[n + static_cast<std::size_t>(row)] = 0;
    klu_.solve(rhs_);
    std::copy_n(rhs_.begin(), n, force.data());
    std::copy_n(rhs_.begin() + static_cast<std::ptrdiff_t>(n), residual.size(), residual.data());
}

void ConstrainedMatrix::solve(MatX& force) {
    const Eigen::Index n = force.rows(), all = n + system_.row_count();
    rhs_.assign(static_cast<std::size_t>(all * force.cols()), 0.0);
    Eigen::Map<MatX> rhs(rhs_.data(), all, force.cols());
    rhs.topRows(n) = force;
    klu_.solve(rhs_, static_cast<int>(force.cols()));
    force = rhs.topRows(n);
}

} // namespace gudgeon
