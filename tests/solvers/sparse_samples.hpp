// Random matrices for the tests of the linear solvers. Own generator: the same numbers everywhere.
#pragma once

#include "core/sparse.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstdint>

namespace gudgeon::samples {

class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 2654435761u + 88172645463325252u) {}
    /// Uniform in (-1, 1).
    double uniform() {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return static_cast<double>(state_ >> 11) / 9007199254740992.0 * 2 - 1;
    }
    int below(int n) { return static_cast<int>((uniform() + 1) / 2 * n) % n; }

  private:
    std::uint64_t state_;
};

/// Entries that are exactly zero are left out of the pattern.
inline CscMatrix sparse(const Eigen::MatrixXd& a) {
    CscMatrix out;
    out.pattern.rows = static_cast<int>(a.rows());
    out.pattern.cols = static_cast<int>(a.cols());
    out.pattern.col_start.push_back(0);
    for (int j = 0; j < a.cols(); ++j) {
        for (int i = 0; i < a.rows(); ++i)
            if (a(i, j) != 0) {
                out.pattern.row.push_back(i);
                out.values.push_back(a(i, j));
            }
        out.pattern.col_start.push_back(out.pattern.nonzeros());
    }
    return out;
}

inline Eigen::MatrixXd dense(const CscMatrix& a) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(a.pattern.rows, a.pattern.cols);
    for (int j = 0; j < a.pattern.cols; ++j)
        for (int p = a.pattern.col_start[j]; p < a.pattern.col_start[j + 1]; ++p)
            out(a.pattern.row[p], j) = a.values[p];
    return out;
}

/// [A G^T; G 0]: A dominated by its diagonal and slightly unsymmetric, m constraint rows between neighbours.
inline Eigen::MatrixXd saddle_point(int n, int m, std::uint64_t seed) {
    Random random(seed);
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n + m, n + m);
    for (int i = 0; i < n; ++i) {
        k(i, i) = 4 + random.uniform();
        for (int j = i - 2; j < i; ++j)
            if (j >= 0) {
                k(i, j) = random.uniform();
                k(j, i) = random.uniform();
            }
    }
    for (int r = 0; r < m; ++r) {
        const int own = r * n / m; // rows start at different unknowns: full rank
        k(n + r, own) = 1 + 0.2 * random.uniform();
        for (int c = 0; c < 3; ++c) {
            const int other = own + 1 + random.below(6);
            if (other < n)
                k(n + r, other) = 0.3 * random.uniform();
        }
    }
    k.topRightCorner(n, m) = k.bottomLeftCorner(m, n).transpose();
    return k;
}

/// D K D with D drawn over the given number of orders of magnitude (so the entries span twice as many).
inline Eigen::MatrixXd badly_scaled(const Eigen::MatrixXd& k, double orders, std::uint64_t seed) {
    Random random(seed);
    Eigen::VectorXd d(k.rows());
    for (auto& x : d)
        x = std::pow(10.0, 0.5 * orders * random.uniform());
    return d.asDiagonal() * k * d.asDiagonal();
}

inline Eigen::MatrixXd random_columns(int n, int columns, std::uint64_t seed) {
    Random random(seed);
    Eigen::MatrixXd out(n, columns);
    for (auto& x : out.reshaped())
        x = random.uniform();
    return out;
}

/// Largest componentwise backward error |b - A x| / (|A| |x| + |b|) of all columns.
inline double backward_error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& x, const Eigen::MatrixXd& b) {
    const Eigen::ArrayXXd residual = (b - a * x).array().abs();
    const Eigen::ArrayXXd size = (a.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs()).array();
    return (residual / (size + 1e-300)).maxCoeff();
}

} // namespace gudgeon::samples
