#include "solvers/rest_point.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr double size_of_a_point = 0.1; // m, where no length is known
constexpr double any_speed = 1;         // m/s: at rest laws push elastically for every starting speed

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

} // namespace

double mechanism_size(const System& system) {
    double size = 0;
    for (int i = 0; i < system.moving; ++i)
        for (int j : {0, system.moving - 1})
            size = std::max(size, (system.start[i].r - system.start[j].r).norm());
    for (const JointRecord& j : system.joints)
        size = std::max({size, j.a.body < system.moving ? j.a.point.norm() : 0.0,
                         j.b.body < system.moving ? j.b.point.norm() : 0.0});
    return size > 0 ? size : size_of_a_point;
}

double body_size(const System& system) {
    std::vector<double> reach(system.moving, 0.0);
    for (const JointRecord& j : system.joints)
        for (const Anchor& side : {j.a, j.b})
            if (side.body < system.moving)
                reach[side.body] = std::max(reach[side.body], side.point.norm());
    std::erase(reach, 0.0);
    if (reach.empty())
        return mechanism_size(system);
    std::ranges::sort(reach);
    return reach[reach.size() / 2];
}

RestPoint::RestPoint(const System& system, const State& state, const std::vector<int>& dependent)
    : left(VecX::Zero(system.velocities())), lambda(VecX::Zero(system.row_count())), system_(system),
      ws_(make_workspace(system)), mass_(system, dependent), matrix_(system, dependent),
      rest_(VecX::Zero(system.velocities())), acceleration_(rest_), residual_(lambda), t_(state.t),
      size_(mechanism_size(system)) {
    ws_.angles = state.angles;
    ws_.angles.rate.setZero();
    ws_.angles.t = t_;
    ws_.contacts.start_speed.setConstant(any_speed);
    ws_.frozen = true;
    find_scales(state);
}

void RestPoint::find_scales(const State& state) {
    if (!evaluate(state.q))
        return;
    double acceleration = system_.gravity.norm();
    for (int i = 0; i < system_.moving; ++i)
        acceleration = std::max(acceleration, ws_.f.segment<3>(6 * i).norm() / system_.mass[i]);
    if (acceleration > 0)
        stiffness_scale_ = acceleration / size_;
}

bool RestPoint::evaluate(const VecX& q) {
    set_motion(system_, q, rest_, ws_);
    evaluate_forces(system_, t_, ws_);
    evaluate_constraints(system_, t_, nullptr, true, ws_);
    if (!ws_.f.allFinite() || !ws_.phi.allFinite() || !mass_.factor_mass(ws_).ok())
        return false;
    lambda.setZero();
    for (int pass = 0; pass < 2; ++pass) { // the second takes round-off out
        left = ws_.f;
        add_transposed_rows(system_, ws_, lambda, -1.0, left);
        acceleration_ = left;
        rows_times(system_, ws_, rest_, residual_);
        mass_.solve(acceleration_, residual_);
        lambda += residual_;
    }
    left = ws_.f;
    add_transposed_rows(system_, ws_, lambda, -1.0, left);
    return left.allFinite();
}

double RestPoint::largest_stiffness() const {
    double largest = 0;
    for (const double s : ws_.lin.S)
        largest = std::max(largest, std::abs(s));
    return largest;
}

double RestPoint::force_scale() const {
    double scale = 0;
    for (int i = 0; i < system_.moving; ++i)
        scale = std::max(scale, system_.mass[i] * system_.gravity.cwiseAbs().maxCoeff());
    VecX part = VecX::Zero(system_.velocities());
    add_transposed_rows(system_, ws_, lambda, 1.0, part);
    scale = std::max(scale, largest(part));
    Workspace& ws = const_cast<Workspace&>(ws_); // evaluation() hands out scratch
    const Evaluation e = evaluation(system_, ws, t_);
    for (const auto& batch : system_.forces) {
        part.setZero();
        batch->add_forces(e, {part.data(), system_.moving});
        scale = std::max(scale, largest(part));
    }
    return scale;
}

void RestPoint::linearise() {
    gudgeon::linearise(system_, t_, lambda.data(), ws_);
    std::ranges::fill(ws_.lin.C, 0.0);
    ws_.lin.states.clear();
    ws_.lin.reactions.clear();
}

FactorStatus RestPoint::factor(double a) { return matrix_.factor(ws_, a, 1.0); }

void RestPoint::stiffness_times(const VecX& x, VecX& out) const { blocks_times(system_, ws_.lin.S, x, out); }

void RestPoint::follow_angles() { update_angles(system_, t_, ws_, ws_.angles); }

double RestPoint::energy() { return energies(system_, t_, lambda.data(), ws_).mechanical(); }

double RestPoint::applied_work(const VecX& q, const VecX& step) {
    set_motion(system_, q, step, ws_);
    const double moving = energies(system_, t_, nullptr, ws_).input_power;
    set_motion(system_, q, rest_, ws_);
    return moving - energies(system_, t_, nullptr, ws_).input_power; // a road may move by itself
}

double RestPoint::largest_constraint() const { return largest(ws_.phi); }

int RestPoint::factorisations() const {
    const auto all = [](const LinearSolverCounts& c) { return c.factorisations + c.refactorisations; };
    return static_cast<int>(all(mass_.counts()) + all(matrix_.counts()));
}

} // namespace gudgeon
