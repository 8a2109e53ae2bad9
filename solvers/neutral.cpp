// Directions without stiffness: inverse iteration on blocks, Ritz values, and their names.

#include "solvers/rest_point.hpp"
#include "solvers/statics.hpp"

#include "core/matrices.hpp"
#include "solvers/redundancy.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr double shift = 1e-3;       // of the stiffness scale
constexpr double zero_share = 1e-11; // of the stiffnesses that cancel in a Ritz value
constexpr double zero_scale = 1e-6;  // of the stiffness scale
constexpr int block = 12, sweeps = 16;
constexpr double same_direction = 1e-4; // part outside the neutral space of a motion that counts as inside
constexpr double takes_part = 0.05;     // of the largest move

using Sparse = Eigen::SparseMatrix<double>;

Sparse to_sparse(const CscMatrix& m) {
    return Eigen::Map<const Sparse>(m.pattern.rows, m.pattern.cols, m.pattern.nonzeros(),
                                    m.pattern.col_start.data(), m.pattern.row.data(), m.values.data());
}

struct Ritz {
    MatX vectors; // M-orthonormal
    VecX values;  // 1/s2
    VecX noise;   // values below this are zero
};

class NeutralSearch {
  public:
    NeutralSearch(const System& system, const State& state, const std::vector<int>& dependent)
        : system_(system), point_(system, state, dependent) {
        point_.evaluate(state.q);
        point_.linearise();
    }

    MatX neutral() {
        const double sigma = shift * point_.stiffness_scale();
        const auto n = static_cast<int>(system_.velocities());
        for (int columns = std::min(block, n); factor(sigma); columns = std::min(2 * columns, n)) {
            const Ritz ritz = iterate(columns);
            std::vector<Eigen::Index> zero;
            for (Eigen::Index k = 0; k < ritz.values.size(); ++k)
                if (std::abs(ritz.values[k]) <= ritz.noise[k])
                    zero.push_back(k);
            if (std::ssize(zero) < columns || columns == n) // else there may be more
                return ritz.vectors(Eigen::all, zero);
        }
        return MatX(system_.velocities(), 0);
    }

    /// Eigenvalues below zero of the constrained stiffness: those of S + alpha G^T G + sigma M, alpha large
    /// (Debreu 1952), by the signs of its LDL^T (Sylvester).
    int unstable() const {
        const Workspace& ws = point_.workspace();
        const Sparse k = to_sparse(blocks_as_matrix(system_, ws.lin.S)), m = to_sparse(mass_matrix(system_));
        const Sparse g = to_sparse(rows_as_matrix(system_, ws));
        const Sparse symmetric = 0.5 * (k + Sparse(k.transpose()));
        double stiffest = point_.stiffness_scale();
        for (int i = 0; i < symmetric.outerSize(); ++i)
            stiffest = std::max(stiffest, std::abs(symmetric.coeff(i, i)));
        for (double mass : system_.mass)
            stiffest = std::max(stiffest, mass * point_.stiffness_scale());
        const Sparse full = symmetric + 10 * shift * point_.stiffness_scale() * m +
                            100 * stiffest * Sparse(g.transpose() * g);
        const Eigen::SimplicialLDLT<Sparse> ldlt(full);
        if (ldlt.info() != Eigen::Success)
            return 0;
        return static_cast<int>((ldlt.vectorD().array() < 0).count());
    }

  private:
    bool factor(double sigma) { return point_.factor(sigma).ok(); }

    MatX mass_of(const MatX& x) const {
        MatX out(x.rows(), x.cols());
        VecX y(x.rows());
        for (Eigen::Index k = 0; k < x.cols(); ++k) {
            y = x.col(k);
            mass_times(system_, y, y);
            out.col(k) = y;
        }
        return out;
    }

    // Gram-Schmidt in the mass norm, twice; what vanishes is left out.
    MatX orthonormal(const MatX& x) const {
        MatX out(x.rows(), x.cols());
        Eigen::Index kept = 0;
        for (Eigen::Index k = 0; k < x.cols(); ++k) {
            VecX v = x.col(k);
            const double before = std::sqrt(v.dot(VecX(mass_of(v))));
            for (int pass = 0; pass < 2 && kept > 0; ++pass)
                v -= out.leftCols(kept) * (out.leftCols(kept).transpose() * mass_of(v));
            const double length = std::sqrt(v.dot(VecX(mass_of(v))));
            if (length > 1e-12 * before)
                out.col(kept++) = v / length;
        }
        return out.leftCols(kept);
    }

    Ritz iterate(int columns) {
        MatX x(system_.velocities(), columns);
        unsigned seed = 12345; // the same start every time
        for (Eigen::Index i = 0; i < x.size(); ++i) {
            seed = seed * 1664525u + 1013904223u;
            x.data()[i] = static_cast<double>(seed >> 8) / 16777216.0 - 0.5;
        }
        for (int k = 0; k < sweeps; ++k) {
            x = mass_of(x);
            point_.solve(x);
            x = orthonormal(x);
        }
        if (x.cols() == 0)
            return {x, VecX(), VecX()}; // nothing can move
        MatX sx(x.rows(), x.cols());
        VecX out(x.rows());
        for (Eigen::Index k = 0; k < x.cols(); ++k) {
            point_.stiffness_times(x.col(k), out);
            sx.col(k) = out;
        }
        const MatX t = x.transpose() * sx;
        const Eigen::SelfAdjointEigenSolver<MatX> eigen(0.5 * (t + t.transpose()));
        Ritz ritz{x * eigen.eigenvectors(), eigen.eigenvalues(), {}};
        ritz.noise = VecX::Constant(x.cols(), zero_scale * point_.stiffness_scale());
        for (Eigen::Index k = 0; k < x.cols(); ++k)
            ritz.noise[k] +=
                zero_share * cancelling_stiffness(system_, point_.workspace(), ritz.vectors.col(k));
        return ritz;
    }

    const System& system_;
    RestPoint point_;
};

/// Names a neutral space, motion by motion.
class Namer {
  public:
    Namer(const System& system, const State& state) : system_(system), ws_(make_workspace(system)) {
        set_motion(system, state.q, VecX::Zero(system.velocities()), ws_);
    }

    std::vector<NeutralDirection> name(MatX space) const {
        std::vector<NeutralDirection> out;
        const auto try_motion = [&](VecX motion, const std::string& words) {
            if (space.cols() == 0)
                return;
            motion /= length(motion);
            const VecX shares = space.transpose() * mass(motion);
            if (length(motion - space * shares) > same_direction)
                return;
            out.push_back({motion, words});
            remove(shares, space);
        };
        for (int k = 0; k < 3; ++k)
            try_motion(all_move(Vec3::Unit(k)), fmt::format("everything moves along {}", axis(k)));
        for (int k = 0; k < 3; ++k)
            try_motion(all_turn(Vec3::Unit(k)), fmt::format("everything turns about {}", axis(k)));
        for (int i = 0; i < system_.moving; ++i)
            for (int k = 0; k < 6; ++k)
                try_motion(VecX::Unit(system_.velocities(), 6 * i + k),
                           k < 3 ? fmt::format("body '{}' moves along {}", system_.body_names[i], axis(k))
                                 : fmt::format("body '{}' turns about its own {}", system_.body_names[i],
                                               axis(k - 3)));
        for (Eigen::Index k = 0; k < space.cols(); ++k)
            out.push_back({space.col(k), describe(space.col(k))});
        return out;
    }

  private:
    static char axis(int k) { return "xyz"[k]; }
    VecX mass(const VecX& x) const {
        VecX out(x.size());
        mass_times(system_, x, out);
        return out;
    }
    double length(const VecX& x) const { return std::sqrt(x.dot(mass(x))); }

    // Takes the combination with these shares out of the space, and keeps the rest orthonormal.
    static void remove(const VecX& shares, MatX& space) {
        const Eigen::HouseholderQR<MatX> qr(MatX(shares / shares.norm()));
        const MatX turn = qr.householderQ() * MatX::Identity(shares.size(), shares.size());
        space = (space * turn).rightCols(space.cols() - 1).eval();
    }

    VecX all_move(const Vec3& direction) const {
        VecX x = VecX::Zero(system_.velocities());
        for (int i = 0; i < system_.moving; ++i)
            x.segment<3>(6 * i) = direction;
        return x;
    }

    VecX all_turn(const Vec3& direction) const {
        VecX x = VecX::Zero(system_.velocities());
        Vec3 centre = Vec3::Zero();
        double sum = 0;
        for (int i = 0; i < system_.moving; ++i) {
            centre += system_.mass[i] * ws_.motion[i].r;
            sum += system_.mass[i];
        }
        for (int i = 0; i < system_.moving; ++i) {
            const BodyMotion& m = ws_.motion[i];
            x.segment<3>(6 * i) = direction.cross(m.r - centre / sum);
            x.segment<3>(6 * i + 3) = m.A.transpose() * direction;
        }
        return x;
    }

    // Bodies that take part, the one that moves most first.
    std::string describe(const VecX& x) const {
        double most_shift = 0, most_turn = 0;
        for (int i = 0; i < system_.moving; ++i) {
            most_shift = std::max(most_shift, x.segment<3>(6 * i).norm());
            most_turn = std::max(most_turn, x.segment<3>(6 * i + 3).norm());
        }
        std::string text;
        int listed = 0, more = 0;
        for (int i = 0; i < system_.moving; ++i) {
            const Vec3 shift = x.segment<3>(6 * i), turn = ws_.motion[i].A * x.segment<3>(6 * i + 3);
            const bool shifts = shift.norm() > takes_part * most_shift && most_shift > 1e-9 * most_turn;
            const bool turns = turn.norm() > takes_part * most_turn && most_turn > 1e-9 * most_shift;
            if (!shifts && !turns)
                continue;
            if (++listed > 6) {
                ++more;
                continue;
            }
            text += fmt::format("{}body '{}'", listed > 1 ? ", " : "", system_.body_names[i]);
            if (turns)
                text += fmt::format(" turns about {}", words(turn));
            if (shifts)
                text += fmt::format("{} moves along {}", turns ? " and" : "", words(shift));
        }
        return more ? text + fmt::format(" and {} more", more) : text;
    }

    static std::string words(const Vec3& v) {
        Vec3 d = v.normalized();
        Eigen::Index first;
        d.cwiseAbs().maxCoeff(&first);
        if (d[first] < 0)
            d = -d;
        for (int k = 0; k < 3; ++k)
            if (std::abs(d[k]) < 5e-4)
                d[k] = 0; // no -0
        return fmt::format("({:.3g}, {:.3g}, {:.3g})", d.x(), d.y(), d.z());
    }

    const System& system_;
    Workspace ws_;
};

} // namespace

std::vector<NeutralDirection> neutral_directions(const System& system, const State& state, int* unstable) {
    if (unstable)
        *unstable = 0;
    if (system.moving == 0)
        return {};
    NeutralSearch search(system, state, dependent_rows(system, state));
    if (unstable)
        *unstable = search.unstable();
    return Namer(system, state).name(search.neutral());
}

} // namespace gudgeon
