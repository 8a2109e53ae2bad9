#include "solvers/singular_position.hpp"

#include "solvers/consistent.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace gudgeon {

namespace {
constexpr int iterations = 12;
constexpr std::size_t most_names = 6;
constexpr double named = 0.3;      // of the largest part
constexpr int looks = 16;          // on the way, each four times as far as the one before
constexpr double lost_share = 0.3; // of what the weakest rows resist
constexpr double nearly_singular = 1e-6;
constexpr double unmet_share = 1e-5; // of the accelerations
constexpr double at_rest = 1e-9;     // m/s, rad/s; m/s2, rad/s2
} // namespace

WeakestRows::WeakestRows(const System& system) : system_(system), saddle_(system, Rows::soft) {
    klu_.analyse(saddle_.pattern());
    values_.assign(saddle_.pattern().nonzeros(), 0.0);
    rhs_.assign(static_cast<std::size_t>(saddle_.pattern().cols), 0.0);
    w_ = part_ = VecX::Zero(system.row_count());
    v_ = VecX::Zero(system.velocities());
}

// z becomes M^-1 G^T (N + E)^-2 G z, N = G M^-1 G^T: a part of singular value s grows by s^2/(s^2 + E)^2.
void WeakestRows::apply(VecX& z, const Workspace& ws) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    Eigen::Map<VecX> x(rhs_.data(), n + m);
    rows_times(system_, ws, z, part_);
    for (int pass = 0; pass < 2; ++pass) {
        x.head(n).setZero();
        x.tail(m) = part_;
        klu_.solve(rhs_);
        part_ = -x.tail(m);
    }
    z = x.head(n);
}

bool WeakestRows::find(double t, const VecX& q, const VecX& u, Workspace& ws) {
    sigma_ = 0;
    if (system_.row_count() == 0)
        return false;
    set_motion(system_, q, u, ws);
    evaluate_constraints(system_, t, nullptr, true, ws);
    saddle_.assemble_mass(system_, ws, 1.0, values_);
    if (!klu_.factor(values_).ok())
        return false;
    VecX momentum(v_.size());
    for (Eigen::Index j = 0; j < v_.size(); ++j) // anything that no symmetry of the mechanism shares
        v_[j] = 0.5 +
                static_cast<double>(static_cast<std::uint32_t>(j + 1) * 2654435761u >> 16 & 0xffffu) / 65536;
    for (int i = 0; i < iterations; ++i) {
        apply(v_, ws);
        mass_times(system_, v_, momentum);
        const double length = std::sqrt(v_.dot(momentum));
        if (!(length > 0) || !std::isfinite(length))
            return false;
        v_ /= length;
    }
    rows_times(system_, ws, v_, part_);
    w_ = part_ / part_.norm();
    sigma_ = part_.norm();
    return sigma_ > 0;
}

double WeakestRows::along(double t, const VecX& q, const VecX& u, Workspace& ws) {
    set_motion(system_, q, u, ws);
    evaluate_constraints(system_, t, nullptr, true, ws);
    rows_times(system_, ws, v_, part_);
    return w_.dot(part_);
}

std::string names_of_rows(const System& system, const VecX& number) {
    std::vector<int> rows(static_cast<std::size_t>(number.size()));
    std::iota(rows.begin(), rows.end(), 0);
    std::ranges::stable_sort(rows, std::greater{}, [&](int r) { return std::abs(number[r]); });
    std::string out;
    for (std::size_t k = 0; k < std::min(rows.size(), most_names); ++k) {
        if (std::abs(number[rows[k]]) < named * std::abs(number[rows[0]]))
            break;
        const RowRecord& row = system.rows[rows[k]];
        out += fmt::format("{}'{}' ({})", k ? ", " : "", system.joints[row.joint].name, row.direction);
    }
    return out;
}

std::string singular_rows(const System& system, const State& state, double within) {
    Workspace ws = make_workspace(system);
    ws.angles = state.angles;
    WeakestRows weakest(system);
    if (!weakest.find(state.t, state.q, state.u, ws))
        return {};
    bool near = weakest.sigma() < nearly_singular;
    for (const double way : {within, -within}) {
        for (int k = 0; k < looks && !near; ++k) {
            VecX q = state.q;
            move(system, way * std::pow(0.25, k) * state.u, q);
            near = weakest.along(state.t, q, state.u, ws) < lost_share * weakest.sigma();
        }
    }
    return near ? names_of_rows(system, weakest.rows()) : std::string();
}

std::string undecided_start(const System& system, const State& state) {
    Workspace ws = make_workspace(system);
    ws.remember(state);
    ConsistentSolver consistent(system);
    consistent.soften();
    VecX acceleration, lambda, later;
    if (!consistent.accelerations(state.t, state.q, state.u, ws, acceleration, lambda))
        return {};
    // per s^2; along rows, whose coefficients are about one
    const double pull = 1 + acceleration.cwiseAbs().maxCoeff() + state.u.squaredNorm();
    if (consistent.unmet().cwiseAbs().maxCoeff() > unmet_share * pull)
        return fmt::format("it starts in a singular position with velocities along none of the ways the "
                           "mechanism can go on there; see {}",
                           names_of_rows(system, consistent.unmet()));
    const double fastest = acceleration.cwiseAbs().maxCoeff();
    if (state.u.cwiseAbs().maxCoeff() > at_rest || fastest < at_rest)
        return {};
    const VecX u = acceleration / fastest;
    set_motion(system, state.q, u, ws);
    evaluate_constraints(system, state.t, nullptr, false, ws);
    if (ws.rate.cwiseAbs().maxCoeff() > at_rest) // driven
        return {};
    if (!consistent.accelerations(state.t, state.q, u, ws, later, lambda) ||
        consistent.unmet().cwiseAbs().maxCoeff() <= unmet_share * (1 + later.cwiseAbs().maxCoeff()))
        return {};
    return fmt::format(
        "it starts at rest in a singular position, and the forces drive it along none of the ways it "
        "can go on there: which one follows is not decided; see {}",
        names_of_rows(system, consistent.unmet()));
}

} // namespace gudgeon
