#include "solvers/linear_solver.hpp"

#include <stdexcept>

namespace gudgeon {

void check_pattern(const CscPattern& a) {
    if (a.rows < 0 || a.cols < 0 || std::ssize(a.col_start) != a.cols + 1 || a.col_start[0] != 0 ||
        a.col_start[a.cols] != a.nonzeros())
        throw std::invalid_argument("sparse pattern: sizes disagree");
    for (int j = 0; j < a.cols; ++j) {
        if (a.col_start[j + 1] < a.col_start[j] || a.col_start[j + 1] > a.nonzeros())
            throw std::invalid_argument("sparse pattern: column starts must not decrease");
        int last = -1;
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p) {
            if (a.row[p] <= last || a.row[p] >= a.rows)
                throw std::invalid_argument("sparse pattern: rows of a column must increase, within range");
            last = a.row[p];
        }
    }
}

} // namespace gudgeon
