#include "solvers/stage_matrix.hpp"

#include "solvers/saddle_ordering.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace gudgeon {

namespace {
// Multipliers that repeat each other make the matrix as bad as 1/softness squared; that is known.
constexpr double largest_condition = 1e300;
} // namespace

StageMatrix::StageMatrix(const System& system, int stages)
    : system_(system), stages_(stages), n_(static_cast<int>(system.velocities())), m_(system.row_count()),
      stage_(stages), momentum_(stages, stages), translation_(stages, stages),
      pose_turn_(static_cast<std::size_t>(stages) * stages * system.moving, Mat3::Zero()),
      rate_turn_(pose_turn_), rhs_(VecX::Zero(2 * stages * (n_ + m_))),
      klu_(std::make_unique<KluSolver>(KluOptions{.largest_condition = largest_condition})) {}

void StageMatrix::set_stage(int stage, const Workspace& ws) {
    Stage& s = stage_[stage];
    s.C = ws.lin.C;
    s.S = ws.lin.S;
    s.rows = ws.rows;
    s.rate_rows = ws.rate_rows;
    s.reactions = ws.lin.reactions;
}

void StageMatrix::couple(const Eigen::MatrixXd& momentum, const Eigen::MatrixXd& translation) {
    momentum_ = momentum;
    translation_ = translation;
}

template <class Put> void StageMatrix::inertia_entries(int i, int j, Put&& put) const {
    const int v = i * n_, w = j * n_, p = (stages_ + i) * n_, r = (stages_ + j) * n_;
    for (int b = 0; b < system_.moving; ++b) {
        const double mass = system_.mass[b];
        const Mat3& inertia = system_.inertia[b];
        const Mat3 of_pose = inertia * pose_turn_[index(i, j, b)];
        const Mat3 of_rate = inertia * rate_turn_[index(i, j, b)];
        for (int k = 6 * b; k < 6 * b + 3; ++k) {
            put(v + k, w + k, momentum_(i, j) * mass);
            put(p + k, w + k, -translation_(i, j) * mass);
            if (i == j)
                put(p + k, r + k, mass);
        }
        for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l) {
                const int row = 6 * b + 3 + k, col = 6 * b + 3 + l;
                put(v + row, w + col, momentum_(i, j) * inertia(k, l));
                put(p + row, w + col, -of_rate(k, l));
                put(p + row, r + col, of_pose(k, l));
            }
    }
}

template <class Put> void StageMatrix::force_entries(int i, Put&& put) const {
    const int v = i * n_, p = (stages_ + i) * n_;
    const BlockLayout& layout = system_.layout;
    for (int id = 0; id < layout.blocks(); ++id) {
        if (!layout.active[id])
            continue;
        const int row = v + 3 * layout.block_row[id], col = 3 * layout.block_col[id];
        for (int l = 0; l < 3; ++l)
            for (int k = 0; k < 3; ++k) {
                const std::size_t at = 9 * static_cast<std::size_t>(id) + 3 * l + k;
                put(row + k, v + col + l, stage_[i].C[at]);
                put(row + k, p + col + l, stage_[i].S[at]);
            }
    }
}

template <class Put> void StageMatrix::row_entries(int i, Put&& put) const {
    const int v = i * n_, p = (stages_ + i) * n_, l = 2 * stages_ * n_ + i * m_, m = l + stages_ * m_;
    const auto each = [&](int r, auto&& f) {
        for (int k = 0; k < 12; ++k) {
            const int body = k < 6 ? system_.rows[r].a : system_.rows[r].b;
            if (body < system_.moving)
                f(k, 6 * body + k % 6);
        }
    };
    for (int r = 0; r < m_; ++r) {
        double size = 0;
        each(r, [&](int k, int u) {
            const std::size_t at = 12 * static_cast<std::size_t>(r) + k;
            if (const double g = stage_[i].rows[at]; system_.rows[r].mask & (1u << k)) {
                put(v + u, l + r, g);
                put(l + r, v + u, g);
                put(p + u, m + r, -g);
                put(m + r, p + u, g);
                const int c = u % 6 - 3;
                size += g * g / (c < 0 ? system_.mass[u / 6] : system_.inertia[u / 6](c, c));
            }
            put(l + r, p + u, stage_[i].rate_rows[at]);
        });
        put(l + r, l + r, size > 0 ? -softness * size / momentum_(i, i) : -1.0);
        put(m + r, m + r, size > 0 ? -softness * size : -1.0);
    }
    for (const Linearisation::ReactionCoupling& reaction : stage_[i].reactions)
        each(reaction.row, [&](int k, int u) {
            if (system_.rows[reaction.row].mask & (1u << k))
                put(v + u, l + reaction.row, reaction.force.part(k / 3)[k % 3]);
        });
}

template <class Put> void StageMatrix::each_entry(Put&& put) const {
    for (int i = 0; i < stages_; ++i) {
        for (int j = 0; j < stages_; ++j)
            inertia_entries(i, j, put);
        force_entries(i, put);
        row_entries(i, put);
    }
}

// The order of the saddle-point matrix, all unknowns of a velocity or a row together.
std::vector<int> StageMatrix::ordering() const {
    std::vector<int> order;
    for (const int k : saddle_ordering(SaddleMatrix(system_).pattern()))
        for (int s = 0; s < 2 * stages_; ++s)
            order.push_back(k < n_ ? s * n_ + k : 2 * stages_ * n_ + s * m_ + k - n_);
    return order;
}

void StageMatrix::analyse() {
    std::vector<std::int64_t> key;
    const std::int64_t size = rhs_.size();
    each_entry([&](int row, int col, double) { key.push_back(col * size + row); });
    std::vector<std::int64_t> entry = key;
    std::sort(entry.begin(), entry.end());
    entry.erase(std::unique(entry.begin(), entry.end()), entry.end());
    for (const std::int64_t k : key)
        slot_.push_back(static_cast<int>(std::lower_bound(entry.begin(), entry.end(), k) - entry.begin()));
    pattern_.rows = pattern_.cols = static_cast<int>(size);
    pattern_.col_start.assign(size + 1, 0);
    for (const std::int64_t k : entry) {
        pattern_.row.push_back(static_cast<int>(k % size));
        ++pattern_.col_start[k / size + 1];
    }
    for (std::int64_t c = 0; c < size; ++c)
        pattern_.col_start[c + 1] += pattern_.col_start[c];
    values_.assign(pattern_.nonzeros(), 0.0);
    klu_->set_ordering(ordering());
    klu_->analyse(pattern_);
}

FactorStatus StageMatrix::factor() {
    if (slot_.empty())
        analyse();
    std::fill(values_.begin(), values_.end(), 0.0);
    const int* slot = slot_.data();
    each_entry([&](int, int, double value) { values_[*slot++] += value; });
    return klu_->factor(values_);
}

void StageMatrix::drift(int stage, const Eigen::Ref<const VecX>& x, VecX& out) const {
    out.setZero(n_);
    for (int r = 0; r < m_; ++r)
        for (int k = 0; k < 12; ++k) {
            const int body = k < 6 ? system_.rows[r].a : system_.rows[r].b;
            if (body < system_.moving)
                out[6 * body + k % 6] += stage_[stage].rows[12 * static_cast<std::size_t>(r) + k] * x[r];
        }
    inverse_mass_times(system_, out, out);
}

} // namespace gudgeon
