// A saddle-point matrix K = [A U; G -E] taken apart for iterations on its true residual: scaled by powers of
// two, unknowns of the leading block in the order of a factorisation.
#pragma once

#include "core/sparse.hpp"

#include <Eigen/Core>

#include <complex>
#include <span>
#include <vector>

namespace gudgeon {

/// Where the parts of K stand in the values of its pattern. place[i]: the new number of leading unknown i.
struct SaddleParts {
    int n = 0, m = 0;                      // leading unknowns, rows of G
    std::vector<int> place;                // leading unknowns
    std::vector<int> a_start, a_row, a_at; // columns of A
    std::vector<int> g_start, g_col, g_at; // rows of G
    std::vector<int> u_start, u_row, u_at; // columns of U
    std::vector<int> e_at;                 // per row: the diagonal entry -E, -1: none

    SaddleParts() = default;
    SaddleParts(const CscPattern& k, int leading, std::vector<int> places);
};

/// Powers of two: leading unknowns (as placed) so that the symmetric part of A has a diagonal near one, then
/// multipliers so that the rows of G have lengths near one. K scaled is D K D.
struct SaddleScaling {
    std::vector<double> unknown, multiplier;
};

inline double product(double a, double b) { return a * b; }
inline std::complex<double> product(double a, const std::complex<double>& b) { return a * b; }
/// Without the library's search for infinities.
inline std::complex<double> product(const std::complex<double>& a, const std::complex<double>& b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

template <class Scalar> struct ScaledSaddle {
    std::vector<Scalar> a, u;
    std::vector<double> g, e; // e >= 0 where rows are soft

    void resize(const SaddleParts& k) {
        a.resize(k.a_at.size());
        u.resize(k.u_at.size());
        g.resize(k.g_at.size());
        e.resize(k.m);
    }

    void load(const SaddleParts& k, const SaddleScaling& d, std::span<const Scalar> values) {
        for (int j = 0; j < k.n; ++j)
            for (int p = k.a_start[j]; p < k.a_start[j + 1]; ++p)
                a[p] = values[k.a_at[p]] * (d.unknown[k.a_row[p]] * d.unknown[j]);
        for (int r = 0; r < k.m; ++r) {
            for (int p = k.g_start[r]; p < k.g_start[r + 1]; ++p)
                g[p] = std::real(values[k.g_at[p]]) * (d.multiplier[r] * d.unknown[k.g_col[p]]);
            for (int p = k.u_start[r]; p < k.u_start[r + 1]; ++p)
                u[p] = values[k.u_at[p]] * (d.multiplier[r] * d.unknown[k.u_row[p]]);
            e[r] = k.e_at[r] < 0 ? 0.0 : -std::real(values[k.e_at[r]]) * d.multiplier[r] * d.multiplier[r];
        }
    }

    /// w = K z; gz = G z of the leading unknowns is known already.
    template <class Vector>
    void times(const SaddleParts& k, const Vector& z, const Vector& gz, Vector& w) const {
        w.head(k.n).setZero();
        for (int j = 0; j < k.n; ++j) {
            const auto zj = z[j];
            for (int p = k.a_start[j]; p < k.a_start[j + 1]; ++p)
                w[k.a_row[p]] += product(a[p], zj);
        }
        for (int r = 0; r < k.m; ++r) {
            const auto zr = z[k.n + r];
            for (int p = k.u_start[r]; p < k.u_start[r + 1]; ++p)
                w[k.u_row[p]] += product(u[p], zr);
            w[k.n + r] = gz[r] - e[r] * zr;
        }
    }
};

} // namespace gudgeon
