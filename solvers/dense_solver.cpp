#include "solvers/dense_solver.hpp"

#include "solvers/equilibration.hpp"

#include <Eigen/LU>

#include <cmath>
#include <stdexcept>

namespace gudgeon {

struct DenseSolver::Impl {
    CscPattern pattern;
    Equilibration scaling;
    Eigen::MatrixXd scaled;
    Eigen::FullPivLU<Eigen::MatrixXd> lu;
    bool factored = false;
    LinearSolverCounts counts;
};

DenseSolver::DenseSolver() : impl_(std::make_unique<Impl>()) {}
DenseSolver::~DenseSolver() = default;

void DenseSolver::analyse(const CscPattern& pattern) {
    check_pattern(pattern);
    if (pattern.rows != pattern.cols)
        throw std::invalid_argument("a square matrix is needed");
    impl_->pattern = pattern;
    impl_->scaling.analyse(pattern);
    impl_->factored = false;
    ++impl_->counts.analyses;
}

FactorStatus DenseSolver::factor(std::span<const double> values) {
    const CscPattern& a = impl_->pattern;
    if (std::ssize(values) != a.nonzeros())
        throw std::invalid_argument("one value per pattern entry is needed");
    impl_->factored = false;
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            if (!std::isfinite(values[p]))
                return {FactorStatus::Kind::non_finite, j};
    ++impl_->counts.factorisations;
    impl_->factored = true;
    if (a.cols == 0)
        return {};
    impl_->scaling.compute(values);
    const auto& row = impl_->scaling.row();
    const auto& col = impl_->scaling.col();
    impl_->scaled.setZero(a.rows, a.cols);
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            impl_->scaled(a.row[p], j) = row[a.row[p]] * values[p] * col[j];
    impl_->lu.setThreshold(1e-14 * a.cols);
    impl_->lu.compute(impl_->scaled);
    if (impl_->lu.rank() == a.cols)
        return {};
    impl_->factored = false;
    return {FactorStatus::Kind::singular, impl_->lu.permutationQ().indices()(impl_->lu.rank())};
}

void DenseSolver::solve(std::span<double> rhs, int columns) {
    if (!impl_->factored)
        throw std::logic_error("solve without factors");
    const int n = impl_->pattern.cols;
    if (std::ssize(rhs) != static_cast<std::ptrdiff_t>(n) * columns)
        throw std::invalid_argument("right-hand side of another size");
    impl_->counts.solves += columns;
    if (n == 0 || columns == 0)
        return;
    Eigen::Map<const Eigen::VectorXd> row(impl_->scaling.row().data(), n),
        col(impl_->scaling.col().data(), n);
    Eigen::Map<Eigen::MatrixXd> x(rhs.data(), n, columns);
    const Eigen::MatrixXd scaled = row.asDiagonal() * x;
    Eigen::MatrixXd y = impl_->lu.solve(scaled);
    y += impl_->lu.solve(scaled - impl_->scaled * y).eval(); // one refinement
    x = col.asDiagonal() * y;
}

const LinearSolverCounts& DenseSolver::counts() const { return impl_->counts; }

long DenseSolver::factor_nonzeros() const {
    const long n = impl_->pattern.cols;
    return impl_->counts.factorisations == 0 ? 0 : n * n + n;
}

} // namespace gudgeon
