#include "solvers/initial.hpp"

#include "core/assembly.hpp"
#include "solvers/consistent.hpp"
#include "solvers/redundancy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gudgeon {

namespace {

constexpr double position_limit = 1e-9; // m, rad: wider than this is not closed
constexpr double velocity_limit = 1e-9; // m/s, rad/s
constexpr double soft = 1e-9;           // weight that lets repeated rows pass while assembling

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

void evaluate_at(const System& system, const State& state, Workspace& ws) {
    set_motion(system, state.q, state.u, ws);
    evaluate_constraints(system, state.t, nullptr, true, ws);
}

// Gauss-Newton with moves limited to a share of the mechanism's size, from the pose as given.
bool close_positions(const System& system, State& state, ConsistentSolver& solver, Workspace& ws) {
    double size = 0;
    for (int i = 0; i < system.moving; ++i)
        for (int j : {0, system.moving - 1})
            size = std::max(size, (system.start[i].r - system.start[j].r).norm());
    for (const JointRecord& j : system.joints) {
        const Vec3 gap =
            point_difference::value(system.start[j.a.body], system.start[j.b.body], j.a.point, j.b.point);
        size = std::max({size, j.a.point.norm(), j.b.point.norm(), gap.norm()});
    }
    solver.limit_move(std::max(0.2 * size, 1e-6));
    VecX best = state.q;
    double best_phi = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < 8; ++attempt) {
        const bool ok = solver.project_positions(state.t, state.q, state.u, ws);
        if (ok)
            return true;
        if (!std::isfinite(solver.worst_position()))
            break;
        if (solver.worst_position() >= 0.999 * best_phi)
            break;
        best_phi = solver.worst_position();
        best = state.q;
    }
    state.q = best;
    evaluate_at(system, state, ws);
    return largest(ws.phi) <= position_limit;
}

void list_changes(const System& system, const State& before, const State& after, AssemblyReport& report) {
    for (int i = 0; i < system.moving; ++i) {
        const Vec4 p0 = before.q.segment<4>(7 * i + 3), p1 = after.q.segment<4>(7 * i + 3);
        AssemblyReport::Change c{};
        c.body = i;
        c.shift = (after.q.segment<3>(7 * i) - before.q.segment<3>(7 * i)).norm();
        c.turn = 2 * std::min((p1 - p0).norm(), (p1 + p0).norm()); // small turns
        c.velocity = (after.u.segment<3>(6 * i) - before.u.segment<3>(6 * i)).norm();
        c.angular_velocity = (after.u.segment<3>(6 * i + 3) - before.u.segment<3>(6 * i + 3)).norm();
        if (std::max({c.shift, c.turn, c.velocity, c.angular_velocity}) > 1e-12)
            report.changes.push_back(c);
    }
}

void list_open(const System& system, const VecX& residual, double limit, bool velocity,
               AssemblyReport& report) {
    for (int r = 0; r < system.row_count(); ++r)
        if (!(std::abs(residual[r]) <= limit))
            report.open.push_back({r, residual[r], velocity});
    std::stable_sort(report.open.begin(), report.open.end(),
                     [](const auto& x, const auto& y) { return std::abs(x.by) > std::abs(y.by); });
}

} // namespace

std::string AssemblyReport::message(const System& system) const {
    std::string text;
    for (std::size_t i = 0; i < open.size() && i < 8; ++i) {
        const RowRecord& row = system.rows[open[i].row];
        text +=
            fmt::format("{}joint '{}' ({}) {} by {:.6g} {}{}", i ? ", " : "", system.joints[row.joint].name,
                        row.direction, open[i].velocity ? "keeps a speed violated" : "stays open",
                        std::abs(open[i].by), is_moment_row(row) ? "rad" : "m", open[i].velocity ? "/s" : "");
    }
    if (open.size() > 8)
        text += fmt::format(" and {} more", open.size() - 8);
    if (!open.empty())
        text += open[0].velocity ? "; allowed: velocities and drives that fit each other, or fewer joints"
                                 : "; allowed: lengths and places that fit each other, or fewer joints";
    return text;
}

namespace {

AssemblyReport assemble(const System& system, State& state, ConsistentSolver& solver) {
    AssemblyReport report;
    Workspace ws = make_workspace(system);
    ws.angles = state.angles;
    const State given = state;
    evaluate_at(system, state, ws);
    report.position_before = largest(ws.phi);
    report.velocity_before = largest(ws.rate);

    if (report.position_before > 1e-13)
        report.ok = close_positions(system, state, solver, ws);
    evaluate_at(system, state, ws);
    report.position_after = largest(ws.phi);
    if (!report.ok) {
        list_open(system, ws.phi, std::max(position_limit, 1e-3 * report.position_after), false, report);
        return report;
    }
    if (largest(ws.rate) > 1e-14 * (1 + largest(state.u)))
        solver.project_velocities(state.t, state.q, state.u, ws);
    evaluate_at(system, state, ws);
    report.velocity_after = largest(ws.rate);
    report.ok = report.velocity_after <= velocity_limit * (1 + largest(state.u));
    if (!report.ok)
        list_open(system, ws.rate, 1e-3 * report.velocity_after, true, report);
    list_changes(system, given, state, report);
    return report;
}

} // namespace

AssemblyReport assemble_start(const System& system, State& state, ConsistentSolver& solver) {
    if (system.row_count() == 0)
        return {};
    solver.hold(system.hold);
    solver.regularise(soft);
    AssemblyReport report = assemble(system, state, solver);
    solver.hold(std::vector<unsigned>(system.moving, 0u));
    solver.regularise(0);
    solver.limit_move(ConsistentSolver::unlimited);
    return report;
}

AssemblyReport assemble_start(const System& system, State& state) {
    ConsistentSolver solver(system);
    return assemble_start(system, state, solver);
}

} // namespace gudgeon
