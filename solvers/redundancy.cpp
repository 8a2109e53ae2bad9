#include "solvers/redundancy.hpp"

#include "core/assembly.hpp"
#include "core/matrices.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

RedundancyReport find_redundancy(const System& system, const State& state) {
    RedundancyReport report;
    report.rows = system.row_count();
    report.rank = report.rows;
    if (report.rows > 0) {
        Workspace ws = make_workspace(system);
        ws.angles = state.angles;
        set_motion(system, state.q, state.u, ws);
        evaluate_constraints(system, state.t, nullptr, true, ws);
        const RankReport rank = rank_of_rows(rows_as_matrix(system, ws), 1e-9);
        report.rank = rank.rank;
        report.dependent = rank.dependent;
    }
    report.dof = system.velocities() - report.rank;
    return report;
}

std::vector<std::string> RedundancyReport::lines(const System& system) const {
    const auto name = [&](int r) {
        const RowRecord& row = system.rows[r];
        return fmt::format("'{}' ({})", system.joints[row.joint].name, row.direction);
    };
    std::vector<std::string> out;
    for (const RankReport::Dependence& d : dependent) {
        std::string others;
        for (const auto& [row, coefficient] : d.combination)
            if (row != d.row)
                others += (others.empty() ? "" : ", ") + name(row);
        out.push_back(others.empty() ? fmt::format("{} stops nothing", name(d.row))
                                     : fmt::format("{} repeats {}", name(d.row), others));
    }
    return out;
}

std::vector<int> dependent_rows(const System& system, const State& state) {
    std::vector<int> rows;
    for (const RankReport::Dependence& d : find_redundancy(system, state).dependent)
        rows.push_back(d.row);
    return rows;
}

double reaction_length(const System& system) {
    double sum = 0;
    int count = 0;
    for (const JointRecord& joint : system.joints)
        for (const Anchor* side : {&joint.a, &joint.b})
            if (side->body < system.moving) {
                sum += side->point.squaredNorm();
                ++count;
            }
    return sum > 0 ? std::sqrt(sum / count) : 1.0;
}

bool is_moment_row(const RowRecord& row) {
    constexpr unsigned translations = 0b000111000111;
    return (row.mask & translations) == 0;
}

} // namespace gudgeon
