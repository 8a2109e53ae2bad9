// Row and column scaling by powers of two: exact in floating point, so it adds no rounding.
#pragma once

#include "core/archive.hpp"
#include "core/sparse.hpp"

#include <span>
#include <vector>

namespace gudgeon {

/// Scaled matrix: row[i] * a_ij * col[j].
///
/// Made for saddle-point matrices [A G^T; G 0]. Unknowns with a diagonal entry are scaled first, among
/// themselves, to a largest entry near one (Ruiz 2001, square roots of row and column maxima, a few
/// sweeps); then the multipliers (no diagonal entry, or a small negative one) so that the largest entry of G
/// is near one in each of their rows. So a light body between stiff constraints keeps a pivot of order one on
/// the diagonal. A matrix of symmetric magnitudes is scaled symmetrically.
class Equilibration {
  public:
    void analyse(const CscPattern& pattern);
    /// Finite values only. No allocation after analyse().
    void compute(std::span<const double> values);
    /// The scaling alone: compute() needs nothing else of the past.
    void visit(Archive& archive) { archive(row_, col_); }
    const std::vector<double>& row() const { return row_; }
    const std::vector<double>& col() const { return col_; }

  private:
    void find_multipliers(std::span<const double> values);
    void reset_maxima();
    bool sweep();
    void scale_multipliers();

    CscPattern pattern_;
    std::vector<int> diagonal_; // position of the diagonal entry, -1 if absent
    std::vector<char> multiplier_;
    std::vector<int> exponent_; // of each value
    std::vector<int> row_exponent_, col_exponent_;
    std::vector<int> row_max_, col_max_;
    std::vector<double> row_, col_;
};

} // namespace gudgeon
