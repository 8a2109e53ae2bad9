// Constraint rows that repeat others: how many, which, and the measure by which their reactions are shared.
#pragma once

#include "core/archive.hpp"
#include "core/state.hpp"
#include "solvers/rank.hpp"

#include <string>
#include <vector>

namespace gudgeon {

struct RedundancyReport {
    int rows = 0, rank = 0, dof = 0;
    std::vector<RankReport::Dependence> dependent;

    void visit(Archive& archive) { archive(rows, rank, dof, dependent); }

    /// One line per group of rows that repeat each other, joints and directions named.
    std::vector<std::string> lines(const System& system) const;
};

/// The rank of the constraint rows is another from a time on.
struct RankChange {
    double t = 0; // s, of the sample that showed it
    RedundancyReport now;
    void visit(Archive& archive) { archive(t, now); }
};

/// Rank of the constraint rows at a state (sparse QR; rows with lengths made dimensionless by 1 m).
RedundancyReport find_redundancy(const System& system, const State& state);

/// Rows that repeat earlier ones, increasing.
std::vector<int> dependent_rows(const System& system, const State& state);

/// Length L (m) that compares moments with forces where rows repeat each other: of all multipliers that give
/// the same motion the reactions are those with the least sum of force^2 + (moment/L)^2. L is the root mean
/// square of the distances between mass centres and joint points; 1 where all of them vanish.
double reaction_length(const System& system);

/// The multiplier of this row is a moment: the row holds rotations only.
bool is_moment_row(const RowRecord& row);

} // namespace gudgeon
