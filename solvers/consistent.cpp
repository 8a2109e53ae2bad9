#include "solvers/consistent.hpp"

#include "core/assembly.hpp"
#include "core/matrices.hpp"
#include "solvers/rank.hpp"
#include "solvers/redundancy.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace gudgeon {

namespace {
constexpr double smallest_pivot = 1e-13; // of N's largest
constexpr int most_iterations = 25;
constexpr int most_reaction_passes = 60;
constexpr double as_closed =
    1e-10;                        // as an integrator leaves them: near singular positions no solve does more
constexpr double softness = 1e-8; // of N's diagonal
constexpr int idle_powers = 3, idle_passes = 2;
constexpr double repeated_pivot = 100;       // times E: a row without a pivot of its own
constexpr int positions = 0, velocities = 6; // where the bits of held coordinates begin
} // namespace

ConsistentSolver::ConsistentSolver(const System& system)
    : system_(system), hold_(system.moving, 0u), nu_(VecX::Zero(system.row_count())),
      step_(VecX::Zero(system.velocities())), gamma_(VecX::Zero(system.row_count())),
      scale_(VecX::Ones(system.row_count())), unmet_(VecX::Zero(system.row_count())) {
    root_.reserve(system.inverse_inertia.size());
    for (int i = 0; i < system.moving; ++i)
        root_.push_back(system.inverse_inertia[i].llt().matrixL());
    normal_.analyse(build_pattern());
}

// Columns of B are velocities, entries by body; rotation parts are full because of the root.
CscPattern ConsistentSolver::build_pattern() {
    const System& s = system_;
    CscPattern pattern;
    pattern.rows = s.row_count();
    pattern.cols = s.velocities();
    slot_.assign(12 * s.rows.size(), -1);
    std::vector<std::vector<int>> sides(s.moving); // 2 r for side a, 2 r + 1 for side b
    for (int r = 0; r < s.row_count(); ++r) {
        if (s.rows[r].a < s.moving)
            sides[s.rows[r].a].push_back(2 * r);
        if (s.rows[r].b < s.moving)
            sides[s.rows[r].b].push_back(2 * r + 1);
    }
    pattern.col_start.reserve(std::size_t(pattern.cols + pattern.rows) + 1);
    pattern.col_start.push_back(0);
    for (int i = 0; i < s.moving; ++i)
        for (int k = 0; k < 6; ++k) {
            for (const int side : sides[i]) {
                const int r = side / 2, coefficient = 6 * (side % 2) + k;
                const unsigned part = k < 3 ? 1u << coefficient : 0b111u << (6 * (side % 2) + 3);
                if (!(s.rows[r].mask & part))
                    continue;
                slot_[12 * std::size_t(r) + coefficient] = pattern.nonzeros();
                pattern.row.push_back(r);
            }
            pattern.col_start.push_back(pattern.nonzeros());
        }
    soft_slot_.clear();
    for (int r = 0; soft() && r < s.row_count(); ++r) { // a column for each row
        soft_slot_.push_back(pattern.nonzeros());
        pattern.row.push_back(r);
        pattern.col_start.push_back(pattern.nonzeros());
        ++pattern.cols;
    }
    values_.assign(pattern.nonzeros(), 0.0);
    return pattern;
}

void ConsistentSolver::soften() {
    if (soft())
        return;
    const double length = reaction_length(system_);
    for (const RowRecord& row : system_.rows)
        soft_weight_.push_back(is_moment_row(row) ? 1 / (length * length) : 1.0);
    E_.assign(soft_weight_.size(), 0.0);
    idle_ = VecX::Zero(system_.row_count());
    normal_.analyse(build_pattern());
}

// E is one number times the measure of the multipliers, so that what it leaves of them is the least in that
// measure; large enough for the row of the largest N.
void ConsistentSolver::place_softness() {
    double size = 0;
    for (int r = 0; r < system_.row_count(); ++r)
        size = std::max(size, 1 / (scale_[r] * scale_[r] * soft_weight_[r]));
    for (std::size_t r = 0; r < soft_slot_.size(); ++r) {
        E_[r] = softness * size * soft_weight_[r];
        values_[soft_slot_[r]] = scale_[static_cast<Eigen::Index>(r)] * std::sqrt(E_[r]);
    }
}

int ConsistentSolver::deficiency() const {
    int count = 0;
    for (std::size_t r = 0; r < E_.size(); ++r) {
        const double scale = scale_[static_cast<Eigen::Index>(r)];
        count += normal_.pivot(static_cast<int>(r)) <= repeated_pivot * scale * scale * E_[r];
    }
    return count;
}

// Rows that turn out to repeat each other are soft from then on. Masses of many orders of magnitude make
// pivots as small with rows that are independent: those pivots serve, since every solve is refined.
bool ConsistentSolver::factor(const Workspace& ws, int held_shift, double beta) {
    FactorStatus status = factor_once(ws, held_shift, beta, smallest_pivot);
    if (status.kind != FactorStatus::Kind::singular || soft() || beta > 0)
        return status.ok();
    if (rank_of_rows(rows_as_matrix(system_, ws)).dependent.empty() &&
        factor_once(ws, held_shift, beta, 0).ok())
        return true;
    soften();
    return factor_once(ws, held_shift, beta, smallest_pivot).ok();
}

// B = D G W^{1/2} with D such that its rows have unit length.
FactorStatus ConsistentSolver::factor_once(const Workspace& ws, int held_shift, double beta,
                                           double smallest) {
    if (system_.row_count() == 0)
        return {};
    for (int r = 0; r < system_.row_count(); ++r) {
        const RowRecord& row = system_.rows[r];
        Eigen::Matrix<double, 12, 1> b = Eigen::Matrix<double, 12, 1>::Zero();
        for (const int side : {0, 1}) {
            const int body = side ? row.b : row.a;
            if (body >= system_.moving)
                continue;
            Eigen::Matrix<double, 6, 1> g = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
                ws.rows.data() + 12 * std::size_t(r) + 6 * side);
            for (int k = 0; k < 6; ++k)
                if (hold_[body] >> (held_shift + k) & 1u)
                    g[k] = 0;
            b.segment<3>(6 * side) = g.head<3>() / std::sqrt(system_.mass[body]);
            b.segment<3>(6 * side + 3) = held_root(body, held_shift).transpose() * g.tail<3>();
        }
        const double length = b.norm();
        scale_[r] = length > 0 ? 1 / length : 1.0;
        for (int k = 0; k < 12; ++k)
            if (const int slot = slot_[12 * std::size_t(r) + k]; slot >= 0)
                values_[slot] = scale_[r] * b[k];
    }
    if (soft())
        place_softness();
    return normal_.factor(values_, soft() ? 0 : beta, smallest);
}

void ConsistentSolver::solve_normal(VecX& x) {
    x = x.cwiseProduct(scale_).eval();
    normal_.solve({x.data(), static_cast<std::size_t>(x.size())});
    x = x.cwiseProduct(scale_).eval();
}

// Multipliers without their part that moves nothing (N x = 0): P = (N + E)^-1 E is one on that part and small
// on the rest, P^k smaller; the second pass takes round-off out.
void ConsistentSolver::drop_idle_part(VecX& lambda) {
    for (int pass = 0; pass < idle_passes; ++pass) {
        idle_ = lambda;
        for (int k = 0; k < idle_powers; ++k) {
            idle_ = idle_.cwiseProduct(Eigen::Map<const VecX>(E_.data(), idle_.size())).eval();
            solve_normal(idle_);
        }
        lambda -= idle_;
    }
}

// Root of the inverse inertia over the free rotations only.
Mat3 ConsistentSolver::held_root(int body, int held_shift) const {
    const unsigned held = hold_[body] >> (held_shift + 3) & 7u;
    if (!held)
        return root_[body];
    Mat3 inverse = Mat3::Zero();
    std::array<int, 3> free{};
    int n = 0;
    for (int k = 0; k < 3; ++k)
        if (!(held >> k & 1u))
            free[n++] = k;
    if (n == 0)
        return inverse;
    MatX part(n, n);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            part(i, j) = system_.inertia[body](free[i], free[j]);
    const MatX root = MatX(part.inverse()).llt().matrixL();
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j)
            inverse(free[i], free[j]) = root(i, j);
    return inverse;
}

void ConsistentSolver::apply_inverse_mass(int held_shift, VecX& x) const {
    for (int i = 0; i < system_.moving; ++i) {
        x.segment<3>(6 * i) /= system_.mass[i];
        for (int k = 0; k < 3; ++k)
            if (hold_[i] >> (held_shift + k) & 1u)
                x[6 * i + k] = 0;
        const Mat3 root = held_root(i, held_shift);
        x.segment<3>(6 * i + 3) = (root * (root.transpose() * x.segment<3>(6 * i + 3))).eval();
    }
}

// step = W G^T N^-1 residual
void ConsistentSolver::solve_step(const Workspace& ws, const VecX& residual, int held_shift) {
    nu_ = residual;
    solve_normal(nu_);
    step_.setZero();
    add_transposed_rows(system_, ws, nu_, 1.0, step_);
    apply_inverse_mass(held_shift, step_);
}

bool ConsistentSolver::project_positions(double t, VecX& q, const VecX& u, Workspace& ws, double tolerance) {
    worst_position_ = 0;
    if (system_.row_count() == 0) {
        set_motion(system_, q, u, ws);
        return true;
    }
    double last = 0;
    bool fresh = false;
    for (int i = 0; i < most_iterations; ++i) {
        set_motion(system_, q, u, ws);
        evaluate_constraints(system_, t, nullptr, !fresh, ws);
        worst_position_ = ws.phi.cwiseAbs().maxCoeff();
        if (!std::isfinite(worst_position_))
            return false;
        // round-off of long coordinates sets a floor: stop when a step no longer helps there
        const double floor = 4e-16 * (1 + q.cwiseAbs().maxCoeff());
        if (worst_position_ <= std::max(tolerance, 0.0) || (i > 0 && worst_position_ <= 64 * floor))
            return true;
        if (!fresh || worst_position_ > 0.01 * last) {
            evaluate_constraints(system_, t, nullptr, true, ws);
            if (!factor(ws, positions, beta_))
                return false;
            fresh = true;
        }
        last = worst_position_;
        solve_step(ws, ws.phi, positions);
        const double longest = step_.cwiseAbs().maxCoeff();
        if (longest > largest_move_)
            step_ *= largest_move_ / longest;
        move(system_, -step_, q);
    }
    return worst_position_ <= std::max(tolerance, soft() ? as_closed : 1e-12);
}

bool ConsistentSolver::project_velocities(double t, const VecX& q, VecX& u, Workspace& ws) {
    worst_velocity_ = 0;
    set_motion(system_, q, u, ws);
    if (system_.row_count() == 0)
        return true;
    evaluate_constraints(system_, t, nullptr, true, ws);
    if (!factor(ws, velocities, beta_))
        return false;
    double last = 1e300;
    for (int i = 0; i < most_iterations; ++i) {
        worst_velocity_ = ws.rate.cwiseAbs().maxCoeff();
        if (worst_velocity_ > 0.5 * std::exchange(last, worst_velocity_)) // round-off
            break;
        const double floor = 1e-14 * (1 + u.cwiseAbs().maxCoeff());
        if (worst_velocity_ <= floor)
            return true;
        if (i > 0 && beta_ == 0 && !soft())
            return worst_velocity_ <= 1e3 * floor;
        solve_step(ws, ws.rate, velocities);
        u -= step_;
        set_motion(system_, q, u, ws);
        evaluate_constraints(system_, t, nullptr, false, ws);
    }
    return worst_velocity_ <= (soft() ? 10 * as_closed : 1e-11) * (1 + u.cwiseAbs().maxCoeff());
}

bool ConsistentSolver::accelerations(double t, const VecX& q, const VecX& u, Workspace& ws,
                                     VecX& acceleration, VecX& lambda) {
    set_motion(system_, q, u, ws);
    evaluate_forces(system_, t, ws);
    acceleration.resize(system_.velocities());
    lambda.resize(system_.row_count());
    if (system_.row_count() == 0) {
        inverse_mass_times(system_, ws.f, acceleration);
        return true;
    }
    evaluate_constraints(system_, t, nullptr, true, ws);
    const std::vector<unsigned> held = std::exchange(hold_, std::vector<unsigned>(system_.moving, 0u));
    const bool regular = factor(ws, positions, 0);
    if (regular)
        solve_accelerations(t, ws, acceleration, lambda);
    hold_ = held;
    return regular && acceleration.allFinite() && lambda.allFinite();
}

// The second pass takes round-off out; friction that reactions press on converges with them, and so do the
// residuals of soft rows.
void ConsistentSolver::solve_accelerations(double t, Workspace& ws, VecX& acceleration, VecX& lambda) {
    const Evaluation e = evaluation(system_, ws, t);
    for (const auto& batch : system_.constraints)
        batch->acceleration_rhs(e, gamma_.data());
    lambda.setZero();
    VecX& residual = ws.rate;
    const bool friction = system_.reaction_friction;
    double last = 1e300;
    for (int pass = 0; pass < (friction || soft() ? most_reaction_passes : 6); ++pass) {
        if (pass > 0 && friction) {
            ws.lambda = lambda;
            evaluate_forces(system_, t, ws);
        }
        acceleration = ws.f;
        add_transposed_rows(system_, ws, lambda, -1.0, acceleration);
        inverse_mass_times(system_, acceleration, acceleration);
        rows_times(system_, ws, acceleration, residual);
        residual -= gamma_;
        solve_step(ws, residual, positions);
        unmet_ = residual; // that solving once more makes no smaller
        lambda += nu_;
        acceleration -= step_;
        const double change = soft() ? step_.cwiseAbs().maxCoeff() : nu_.cwiseAbs().maxCoeff();
        const double size = soft() ? acceleration.cwiseAbs().maxCoeff() : lambda.cwiseAbs().maxCoeff();
        if (soft() && friction)
            drop_idle_part(lambda);
        if (pass > 0 && (change <= 1e-14 * size || (soft() && !friction && change > 0.5 * last)))
            break;
        last = change;
    }
    if (soft() && !friction)
        drop_idle_part(lambda);
}

} // namespace gudgeon
