// Sparse L D L^T of symmetric positive definite matrices by CHOLMOD (Davis), simplicial.
#pragma once

#include "core/sparse.hpp"

#include <complex>
#include <memory>
#include <span>
#include <vector>

namespace gudgeon {

/// The unknowns are ordered by minimum degree once; everything here is numbered in that order:
/// place()[i] is where unknown i went. The upper triangle is filled by the caller into values().
/// After the first factor() nothing allocates.
class SparseCholesky {
  public:
    SparseCholesky();
    ~SparseCholesky();
    SparseCholesky(const SparseCholesky&) = delete;
    SparseCholesky& operator=(const SparseCholesky&) = delete;

    /// full: n x n pattern, both triangles and the diagonal; symmetric.
    void analyse(const CscPattern& full);

    const std::vector<int>& place() const;
    /// Number in values() of an entry, either triangle; i and j as placed. -1: not in the pattern.
    int slot(int i, int j) const;
    std::vector<double>& values();

    /// False: the matrix in values() is not positive definite, or holds what is no number.
    bool factor();
    /// In place, as placed. Only after factor() was true.
    void solve(double* x) const;
    void solve(std::complex<double>* x) const;

    /// Entries of L, diagonal included; known after analyse().
    long factor_nonzeros() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
