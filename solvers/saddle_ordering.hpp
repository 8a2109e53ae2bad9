// Order of elimination for saddle-point matrices with pivots on the diagonal.
#pragma once

#include "core/sparse.hpp"

#include <vector>

namespace gudgeon {

/// Approximate minimum degree (Amestoy, Davis & Duff 1996) on A + A^T, blind to zeros on the diagonal:
/// perm[k] is the unknown eliminated k-th. A is square.
std::vector<int> minimum_degree_ordering(const CscPattern& a);

/// The same on pairs. Multipliers (CscPattern::leading; their diagonal is zero or, of soft rows, small) are
/// matched with unknowns they are coupled to, the pairs become single nodes of the graph of A + A^T, the
/// graph is ordered by minimum degree, and a pair is eliminated multiplier last, so that its pivot exists on
/// the diagonal (Duff & Pralet 2005).
std::vector<int> saddle_ordering(const CscPattern& a);

/// Orderings worth a trial factorisation: the saddle ordering, and up to 4000 unknowns plain minimum degree,
/// which may lose its ordering to pivoting; its trial then grows with the square of the size.
std::vector<std::vector<int>> ordering_candidates(const CscPattern& a);

} // namespace gudgeon
