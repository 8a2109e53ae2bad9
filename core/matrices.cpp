#include "core/matrices.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

struct Entry {
    int row, col;
    double value;
};

// Entries of distinct places, any order.
CscMatrix from_entries(int rows, int cols, std::vector<Entry> entries) {
    std::sort(entries.begin(), entries.end(),
              [](const Entry& x, const Entry& y) { return x.col != y.col ? x.col < y.col : x.row < y.row; });
    CscMatrix m;
    m.pattern.rows = rows;
    m.pattern.cols = cols;
    m.pattern.col_start.assign(cols + 1, 0);
    for (const Entry& e : entries) {
        ++m.pattern.col_start[e.col + 1];
        m.pattern.row.push_back(e.row);
        m.values.push_back(e.value);
    }
    for (int c = 0; c < cols; ++c)
        m.pattern.col_start[c + 1] += m.pattern.col_start[c];
    return m;
}

} // namespace

CscMatrix rows_as_matrix(const System& system, const Workspace& ws) {
    std::vector<Entry> entries;
    for (int r = 0; r < system.row_count(); ++r) {
        const RowRecord& row = system.rows[r];
        for (int k = 0; k < 12; ++k) {
            const int body = k < 6 ? row.a : row.b;
            if (body < system.moving && (row.mask & (1u << k)))
                entries.push_back({r, 6 * body + k % 6, ws.rows[12 * std::size_t(r) + k]});
        }
    }
    return from_entries(system.row_count(), system.velocities(), std::move(entries));
}

CscMatrix mass_matrix(const System& system) {
    std::vector<Entry> entries;
    for (int i = 0; i < system.moving; ++i)
        for (int k = 0; k < 3; ++k) {
            entries.push_back({6 * i + k, 6 * i + k, system.mass[i]});
            for (int j = 0; j < 3; ++j)
                if (system.inertia[i](j, k) != 0)
                    entries.push_back({6 * i + 3 + j, 6 * i + 3 + k, system.inertia[i](j, k)});
        }
    return from_entries(system.velocities(), system.velocities(), std::move(entries));
}

CscMatrix blocks_as_matrix(const System& system, const std::vector<double>& blocks) {
    std::vector<Entry> entries;
    const BlockLayout& layout = system.layout;
    for (int id = 0; id < layout.blocks(); ++id) {
        if (!layout.active[id])
            continue;
        for (int col = 0; col < 3; ++col)
            for (int row = 0; row < 3; ++row)
                entries.push_back({3 * layout.block_row[id] + row, 3 * layout.block_col[id] + col,
                                   blocks[9 * std::size_t(id) + 3 * col + row]});
    }
    return from_entries(system.velocities(), system.velocities(), std::move(entries));
}

} // namespace gudgeon
