// The insides of AugmentedSolver, which AugmentedPairSolver uses too.
#pragma once

#include "solvers/augmented_saddle.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/gmres.hpp"
#include "solvers/klu_solver.hpp"
#include "solvers/sparse_cholesky.hpp"

#include <algorithm>
#include <vector>

namespace gudgeon {

/// Which factorisations are worth trying with CHOLMOD.
class Patience {
  public:
    static constexpr int most_left_alone = 64; // factorisations that go to KLU unseen after fall-backs

    bool wants_to_try() { return left_ == 0 || --left_ == 0; }
    void failed() {
        span_ = std::min(2 * span_, most_left_alone);
        left_ = span_;
    }
    void served() { span_ = 1; }

  private:
    int span_ = 1, left_ = 0;
};

struct AugmentedSolver::Impl {
    int leading;
    AugmentedOptions options;
    CscPattern pattern;
    SparseCholesky cholesky;
    SaddleParts parts;
    SaddleScaling scaling;
    ScaledSaddle<double> k;
    std::vector<int> a_slot;       // per entry of A: its entry of H
    std::vector<int> product_slot; // per row of G: pairs of its entries
    std::vector<double> weight;    // W
    std::vector<double> original;  // values of K, for KLU
    Gmres<double> single;
    Gmres<std::complex<double>> pair; // two right-hand sides side by side, as real and imaginary part
    Eigen::VectorXd one, one_gz;
    Eigen::VectorXcd two, two_gz;
    KluSolver klu{{.refinements = 0}};
    bool klu_analysed = false, klu_in_use = false, factored = false;
    Patience patience;
    mutable LinearSolverCounts counts;
    LinearSolverCounts own;

    Impl(int n, AugmentedOptions o) : leading(n), options(o) {}

    void find_slots();
    void scale(std::span<const double> values);
    void assemble();
    FactorStatus factor_by_klu();
    void scaled_in(const double* rhs, Eigen::VectorXd& x) const;
    template <class Vector> void pass(const Vector& v, Vector& z, Vector& gz) const;
    bool solve_one(double* rhs);
    bool solve_two(double* first, double* second);
};

// The method of multipliers once: z from the residual v, gz = G z.
template <class Vector> void AugmentedSolver::Impl::pass(const Vector& v, Vector& z, Vector& gz) const {
    using Scalar = typename Vector::Scalar;
    const int n = parts.n;
    z.head(n) = v.head(n);
    for (int r = 0; r < parts.m; ++r) {
        const Scalar push = weight[r] * v[n + r];
        for (int p = parts.g_start[r]; p < parts.g_start[r + 1]; ++p)
            z[parts.g_col[p]] += k.g[p] * push;
    }
    cholesky.solve(z.data());
    for (int r = 0; r < parts.m; ++r) {
        Scalar sum = 0;
        for (int p = parts.g_start[r]; p < parts.g_start[r + 1]; ++p)
            sum += k.g[p] * z[parts.g_col[p]];
        gz[r] = sum;
        z[n + r] = weight[r] * (sum - v[n + r]);
    }
}

} // namespace gudgeon
