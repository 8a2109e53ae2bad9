// Compressed sparse column matrices: the pattern is fixed once, values live in flat arrays.
#pragma once

#include <vector>

namespace gudgeon {

/// Pattern of a rows x cols matrix; row indices sorted and unique in each column.
struct CscPattern {
    int rows = 0;
    int cols = 0;
    std::vector<int> col_start; // cols + 1
    std::vector<int> row;       // one per entry
    /// Of a saddle-point matrix: unknowns before the multipliers. -1: those without an entry on the diagonal
    /// are the multipliers.
    int leading = -1;
    int nonzeros() const { return static_cast<int>(row.size()); }
};

struct CscMatrix {
    CscPattern pattern;
    std::vector<double> values;
};

} // namespace gudgeon
