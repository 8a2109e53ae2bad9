// Pattern and slots of the saddle-point matrix.

#include "core/assembly.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace gudgeon {

namespace {

constexpr std::ptrdiff_t parallel_rows = 8192, parallel_blocks = 1024, parallel_bodies = 256;

// Entries of a CSR list: items of group g are item[start[g] .. start[g+1]).
struct Groups {
    std::vector<int> start, item;
};

template <class GroupOf> Groups group(int groups, int items, GroupOf&& group_of) {
    Groups g;
    g.start.assign(groups + 1, 0);
    for (int i = 0; i < items; ++i)
        if (const int k = group_of(i); k >= 0)
            ++g.start[k + 1];
    for (int k = 0; k < groups; ++k)
        g.start[k + 1] += g.start[k];
    g.item.resize(g.start.back());
    std::vector<int> next(g.start.begin(), g.start.end() - 1);
    for (int i = 0; i < items; ++i)
        if (const int k = group_of(i); k >= 0)
            g.item[next[k]++] = i;
    return g;
}

std::size_t count_entries(const System& system, Rows rows) {
    const BlockLayout& layout = system.layout;
    std::size_t count = 0;
    for (int id = 0; id < layout.blocks(); ++id)
        count += layout.active[id] ? 9 : id < 4 * system.moving && id % 4 == 0 ? 3 : 0;
    for (const RowRecord& row : system.rows) {
        for (const int side : {0, 1})
            if ((side ? row.b : row.a) < system.moving)
                count += 2 * std::size_t(std::popcount(row.mask >> (6 * side) & 0x3fu));
        count += rows == Rows::soft;
    }
    return count;
}

} // namespace

SaddleMatrix::SaddleMatrix(const System& system, Rows rows) { build_pattern(system, rows); }

void SaddleMatrix::build_pattern(const System& system, Rows rows) {
    const BlockLayout& layout = system.layout;
    const int n = system.velocities(), m = system.row_count();
    block_slot_.assign(3 * std::size_t(layout.blocks()), -1);
    mass_slot_.assign(3 * std::size_t(system.moving), -1);
    lower_.assign(12 * std::size_t(m), -1);
    upper_.assign(12 * std::size_t(m), -1);
    pattern_.rows = pattern_.cols = n + m;
    pattern_.leading = n;
    pattern_.col_start.assign(1, 0);

    Groups blocks = group(2 * system.moving, layout.blocks(), [&](int id) { return layout.block_col[id]; });
    for (int c = 0; c < 2 * system.moving; ++c)
        std::sort(blocks.item.begin() + blocks.start[c], blocks.item.begin() + blocks.start[c + 1],
                  [&](int x, int y) { return layout.block_row[x] < layout.block_row[y]; });
    // row sides: 2 r for a, 2 r + 1 for b
    const Groups sides = group(system.moving, 2 * m, [&](int side) {
        const RowRecord& row = system.rows[side / 2];
        const int body = side % 2 ? row.b : row.a;
        return body < system.moving ? body : -1;
    });
    pattern_.col_start.reserve(std::size_t(n + m) + 1);
    pattern_.row.reserve(count_entries(system, rows));
    const auto slot = [&] { return pattern_.nonzeros(); };
    for (int col = 0; col < n; ++col) {
        const int body = col / 6, part = col % 6 / 3, k = col % 3, block_col = 2 * body + part;
        for (int i = blocks.start[block_col]; i < blocks.start[block_col + 1]; ++i) {
            const int id = blocks.item[i], row = 3 * layout.block_row[id];
            const bool mass_block = id == 4 * body && part == 0;
            if (layout.active[id]) {
                block_slot_[3 * std::size_t(id) + k] = slot();
                if (mass_block)
                    mass_slot_[3 * std::size_t(body) + k] = slot() + k;
                for (int r = 0; r < 3; ++r)
                    pattern_.row.push_back(row + r);
            } else if (mass_block) {
                mass_slot_[3 * std::size_t(body) + k] = slot();
                pattern_.row.push_back(row + k);
            }
        }
        for (int i = sides.start[body]; i < sides.start[body + 1]; ++i) {
            const int r = sides.item[i] / 2, coefficient = 6 * (sides.item[i] % 2) + 3 * part + k;
            if (!(system.rows[r].mask & (1u << coefficient)))
                continue;
            lower_[12 * std::size_t(r) + coefficient] = slot();
            pattern_.row.push_back(n + r);
        }
        pattern_.col_start.push_back(slot());
    }
    for (int r = 0; r < m; ++r) {
        const RowRecord& row = system.rows[r];
        const int first = row.a < row.b ? 0 : 1;
        for (const int side : {first, 1 - first}) {
            const int body = side ? row.b : row.a;
            if (body >= system.moving)
                continue;
            for (int k = 0; k < 6; ++k) {
                if (!(row.mask & (1u << (6 * side + k))))
                    continue;
                upper_[12 * std::size_t(r) + 6 * side + k] = slot();
                pattern_.row.push_back(6 * body + k);
            }
        }
        if (rows == Rows::soft) {
            soft_slot_.push_back(slot());
            pattern_.row.push_back(n + r);
        }
        pattern_.col_start.push_back(slot());
    }
}

template <class Scalar>
void SaddleMatrix::place_rows(const System& system, std::span<const double> rows, int threads,
                              std::span<Scalar> values) const {
    const auto count = static_cast<std::ptrdiff_t>(12 * system.rows.size());
    parallel_for(threads, 0, count, parallel_rows, [&](std::ptrdiff_t i) {
        if (lower_[i] >= 0)
            values[lower_[i]] = rows[i];
        if (upper_[i] >= 0)
            values[upper_[i]] = rows[i];
    });
}

int SaddleMatrix::diagonal_slot(int body, int k) const {
    return k < 3 ? mass_slot_[3 * std::size_t(body) + k]
                 : block_slot_[3 * (4 * std::size_t(body) + 3) + k - 3] + k - 3;
}

template <class Scalar> void SaddleMatrix::soften(const System& system, std::span<Scalar> values) const {
    for (std::size_t r = 0; r < soft_slot_.size(); ++r) {
        double sum = 0;
        for (int k = 0; k < 12; ++k) {
            const int slot = upper_[12 * r + k];
            if (slot < 0 || values[slot] == Scalar(0))
                continue;
            const int body = k < 6 ? system.rows[r].a : system.rows[r].b;
            sum += std::norm(values[slot]) / std::abs(values[diagonal_slot(body, k % 6)]);
        }
        values[soft_slot_[r]] = sum > 0 ? -softness * sum : -1.0; // a row between fixed bodies
    }
}

void SaddleMatrix::scale_softness(double factor, std::span<double> values) const {
    for (const int slot : soft_slot_)
        values[slot] *= factor;
}

void SaddleMatrix::soft_times(std::span<const double> values, const VecX& x, Eigen::Ref<VecX> out) const {
    out.setZero();
    for (std::size_t r = 0; r < soft_slot_.size(); ++r)
        out[static_cast<Eigen::Index>(r)] = -values[soft_slot_[r]] * x[static_cast<Eigen::Index>(r)];
}

template <class Scalar>
void SaddleMatrix::assemble_scalars(const System& system, const Workspace& ws, Scalar a, Scalar s,
                                    std::span<Scalar> values) const {
    const int blocks = system.layout.blocks();
    const bool joined = ws.lin.joined != 0;
    parallel_for(ws.threads, 0, blocks, parallel_blocks, [&](std::ptrdiff_t id) {
        if (!system.layout.active[id])
            return;
        const double* c = ws.lin.C.data() + 9 * std::size_t(id);
        const double* k = ws.lin.S.data() + 9 * std::size_t(id);
        for (int col = 0; col < 3; ++col) {
            Scalar* v = values.data() + block_slot_[3 * std::size_t(id) + col];
            if (joined) {
                for (int row = 0; row < 3; ++row)
                    v[row] = c[3 * col + row];
                continue;
            }
            for (int row = 0; row < 3; ++row)
                v[row] = c[3 * col + row] + s * k[3 * col + row];
        }
    });
    for (const Linearisation::StateCoupling& state : ws.lin.states) {
        const Scalar factor = -1.0 / (a + state.decay);
        const PairBlocks& pair = ws.lin.pairs[state.pair];
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                for (int col = 0; pair.id[i][j] >= 0 && col < 3; ++col) {
                    Scalar* v = values.data() + block_slot_[3 * std::size_t(pair.id[i][j]) + col];
                    for (int row = 0; row < 3; ++row)
                        v[row] += factor * (state.force.part(i)[row] * state.rate.part(j)[col]);
                }
    }
    parallel_for(ws.threads, 0, system.moving, parallel_bodies, [&](std::ptrdiff_t i) {
        const bool full = system.layout.active[4 * std::size_t(i)];
        for (int k = 0; k < 3; ++k) {
            Scalar& diagonal = values[mass_slot_[3 * std::size_t(i) + k]];
            diagonal = (full ? diagonal : Scalar(0)) + a * system.mass[i];
            Scalar* v = values.data() + block_slot_[3 * (4 * std::size_t(i) + 3) + k];
            for (int row = 0; row < 3; ++row)
                v[row] += a * system.inertia[i](row, k);
        }
    });
    place_rows(system, ws.rows, ws.threads, values);
    soften(system, values);
    for (const Linearisation::ReactionCoupling& reaction : ws.lin.reactions)
        for (int k = 0; k < 12; ++k)
            if (const int slot = upper_[12 * std::size_t(reaction.row) + k]; slot >= 0)
                values[slot] += reaction.force.part(k / 3)[k % 3];
}

void SaddleMatrix::assemble(const System& system, const Workspace& ws, double a, double s,
                            std::span<double> values) const {
    assemble_scalars(system, ws, a, s, values);
}

void SaddleMatrix::assemble(const System& system, const Workspace& ws, std::complex<double> a,
                            std::complex<double> s, std::span<std::complex<double>> values) const {
    assemble_scalars(system, ws, a, s, values);
}

void SaddleMatrix::assemble_mass(const System& system, const Workspace& ws, double a,
                                 std::span<double> values) const {
    std::fill(values.begin(), values.end(), 0.0);
    for (int i = 0; i < system.moving; ++i)
        for (int k = 0; k < 3; ++k) {
            values[mass_slot_[3 * std::size_t(i) + k]] = a * system.mass[i];
            double* v = values.data() + block_slot_[3 * (4 * std::size_t(i) + 3) + k];
            for (int row = 0; row < 3; ++row)
                v[row] = a * system.inertia[i](row, k);
        }
    place_rows(system, ws.rows, ws.threads, values);
    soften(system, values);
}

} // namespace gudgeon
