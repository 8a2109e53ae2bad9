// Which rows of a sparse matrix repeat others: redundant constraints.
#pragma once

#include "core/archive.hpp"
#include "core/sparse.hpp"

#include <utility>
#include <vector>

namespace gudgeon {

struct RankReport {
    int rank = 0;
    struct Dependence {
        int row = 0; // a combination of earlier rows
        /// (row, coefficient), rows increasing, the dependent row last with coefficient 1:
        /// sum of coefficient * row = 0. Coefficients refer to the rows as given, not scaled.
        std::vector<std::pair<int, double>> combination;
        void visit(Archive& archive);
    };
    std::vector<Dependence> dependent; // rows increasing; rank + dependent.size() = rows
};

/// Rank of the rows of g (m x n) by sparse QR of G^T that sets dependent columns aside, rows scaled to unit
/// length.
///
/// tolerance: a unit row whose part outside the span of the others is shorter than this is dependent
/// (1e-9 suits constraint rows known to round-off). The dependent rows are the latest ones possible: a row is
/// listed exactly if it depends on rows before it. Their combinations contain, besides, independent
/// rows only; terms below 1e-9 of the largest, measured on unit rows, are dropped. A zero row depends on
/// nothing: its combination is itself. Uses Givens rotations (George & Heath 1980, Heath 1982), or SPQR (GPL)
/// when built with GUDGEON_HAVE_SPQR. The result does not depend on which, apart from rounding. Throws
/// std::invalid_argument for a malformed pattern, a non-finite value or a tolerance outside (0, 1).
RankReport rank_of_rows(const CscMatrix& g, double tolerance = 1e-9);

} // namespace gudgeon
