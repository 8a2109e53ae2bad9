#include "solvers/augmented_saddle.hpp"

#include "solvers/linear_solver.hpp"

#include <utility>

namespace gudgeon {

SaddleParts::SaddleParts(const CscPattern& k, int leading, std::vector<int> places)
    : n(leading), m(k.cols - leading), place(std::move(places)), e_at(m, -1) {
    std::vector<int> old(n);
    for (int i = 0; i < n; ++i)
        old[place[i]] = i;
    a_start.push_back(0);
    std::vector<std::vector<std::pair<int, int>>> rows(m); // column, entry
    for (int j = 0; j < n; ++j) {
        for (int p = k.col_start[old[j]]; p < k.col_start[old[j] + 1]; ++p) {
            if (k.row[p] >= n) {
                rows[k.row[p] - n].emplace_back(j, p);
                continue;
            }
            a_row.push_back(place[k.row[p]]);
            a_at.push_back(p);
        }
        a_start.push_back(static_cast<int>(a_at.size()));
    }
    g_start.push_back(0);
    u_start.push_back(0);
    for (int r = 0; r < m; ++r) {
        for (const auto& [column, entry] : rows[r]) {
            g_col.push_back(column);
            g_at.push_back(entry);
        }
        for (int p = k.col_start[n + r]; p < k.col_start[n + r + 1]; ++p) {
            if (k.row[p] == n + r)
                e_at[r] = p;
            if (k.row[p] >= n)
                continue;
            u_row.push_back(place[k.row[p]]);
            u_at.push_back(p);
        }
        g_start.push_back(static_cast<int>(g_at.size()));
        u_start.push_back(static_cast<int>(u_at.size()));
    }
}

} // namespace gudgeon
