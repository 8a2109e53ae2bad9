#include "solvers/rank.hpp"

#include "tests/solvers/sparse_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

using Eigen::MatrixXd;

std::vector<int> dependent_rows(const RankReport& report) {
    std::vector<int> out;
    for (const auto& d : report.dependent)
        out.push_back(d.row);
    return out;
}

/// Every combination vanishes (relative to its terms), ends at its row with coefficient one, and holds
/// no other dependent row.
void expect_consistent(const CscMatrix& g, const RankReport& report) {
    const std::vector<int> dependent = dependent_rows(report);
    EXPECT_TRUE(std::is_sorted(dependent.begin(), dependent.end()));
    EXPECT_EQ(report.rank + std::ssize(dependent), g.pattern.rows);
    std::vector<double> coefficient(g.pattern.rows, 0.0), length(g.pattern.rows, 0.0);
    for (int p = 0; p < g.pattern.nonzeros(); ++p)
        length[g.pattern.row[p]] = std::hypot(length[g.pattern.row[p]], g.values[p]);
    for (const auto& d : report.dependent) {
        ASSERT_FALSE(d.combination.empty());
        EXPECT_EQ(d.combination.back().first, d.row);
        EXPECT_NEAR(d.combination.back().second, 1, 1e-14);
        double size = 0;
        for (const auto& [row, value] : d.combination) {
            coefficient[row] = value;
            size = std::max(size, std::abs(value) * length[row]);
            EXPECT_TRUE(row == d.row || !std::binary_search(dependent.begin(), dependent.end(), row));
        }
        for (int j = 0; j < g.pattern.cols; ++j) {
            double sum = 0;
            for (int p = g.pattern.col_start[j]; p < g.pattern.col_start[j + 1]; ++p)
                sum += coefficient[g.pattern.row[p]] * g.values[p];
            EXPECT_LT(std::abs(sum), 1e-8 * size + 1e-300);
        }
        for (const auto& [row, value] : d.combination)
            coefficient[row] = 0;
    }
}

TEST(Rank, FullRankHasNothingToReport) {
    const RankReport report = rank_of_rows(samples::sparse(MatrixXd::Identity(4, 9)), 1e-9);
    EXPECT_EQ(report.rank, 4);
    EXPECT_TRUE(report.dependent.empty());
}

TEST(Rank, SmallCaseByHand) {
    // row 3 = 2 row 0 - row 2; row 1 independent.
    MatrixXd g(4, 3);
    g << 1, 0, 2, 0, 1, 0, 0, 0, 3, 2, 0, 1;
    const RankReport report = rank_of_rows(samples::sparse(g), 1e-9);
    EXPECT_EQ(report.rank, 3);
    ASSERT_EQ(report.dependent.size(), 1u);
    const auto& c = report.dependent[0].combination;
    EXPECT_EQ(report.dependent[0].row, 3);
    ASSERT_EQ(c.size(), 3u);
    EXPECT_EQ(c[0].first, 0);
    EXPECT_NEAR(c[0].second, -2, 1e-13);
    EXPECT_EQ(c[1].first, 2);
    EXPECT_NEAR(c[1].second, 1, 1e-13);
    EXPECT_EQ(c[2].first, 3);
}

TEST(Rank, DoesNotDependOnTheUnitsOfTheRows) {
    MatrixXd g(4, 3);
    g << 1e-8, 0, 2e-8, 0, 1e7, 0, 0, 0, 3, 2e9, 0, 1e9;
    const RankReport report = rank_of_rows(samples::sparse(g), 1e-9);
    EXPECT_EQ(report.rank, 3);
    ASSERT_EQ(dependent_rows(report), std::vector<int>{3});
    EXPECT_NEAR(report.dependent[0].combination[0].second / -2e17, 1, 1e-12);
}

/// Velocity constraints of four revolute joints about Y of a closed planar loop of three bars and
/// the ground: 5 rows each (three translations, two rotations), 20 rows on 18 unknowns, one degree
/// of freedom left: rank 17, three rows repeat others (y offset and the two out-of-plane rotations).
MatrixXd planar_four_bar(double turn) {
    const Eigen::Vector3d p[4] = {{0, 0, 0},
                                  {std::sin(turn), 0, std::cos(turn)},
                                  {1.3 + std::sin(turn), 0.0, std::cos(turn)},
                                  {1.3, 0, 0}};
    const Eigen::Vector3d centre[3] = {(p[0] + p[1]) / 2, (p[1] + p[2]) / 2, (p[2] + p[3]) / 2};
    MatrixXd g = MatrixXd::Zero(20, 18);
    for (int joint = 0; joint < 4; ++joint)
        for (const int side : {-1, 1}) {
            const int body = side < 0 ? joint - 1 : joint;
            if (body < 0 || body > 2)
                continue;
            const Eigen::Vector3d s = p[joint] - centre[body];
            Eigen::Matrix3d cross;
            cross << 0, -s.z(), s.y(), s.z(), 0, -s.x(), -s.y(), s.x(), 0;
            g.block<3, 3>(5 * joint, 6 * body) = side * Eigen::Matrix3d::Identity();
            g.block<3, 3>(5 * joint, 6 * body + 3) = -side * cross;
            g(5 * joint + 3, 6 * body + 3) = side;
            g(5 * joint + 4, 6 * body + 5) = side;
        }
    return g;
}

TEST(Rank, PlanarFourBarInSpaceHasThreeRepeatedRows) {
    for (const double turn : {0.0, 0.3, 1.1, 2.5}) {
        const CscMatrix g = samples::sparse(planar_four_bar(turn));
        const RankReport report = rank_of_rows(g, 1e-9);
        EXPECT_EQ(report.rank, 17) << turn;
        EXPECT_EQ(dependent_rows(report), (std::vector<int>{16, 18, 19}))
            << turn; // y, and both rotations, of the last
        expect_consistent(g, report);
    }
}

TEST(Rank, LatestRowsAreTheDependentOnes) {
    // Rows 0, 5, 9 are the same, and 2 = -row 7.
    MatrixXd g = MatrixXd::Zero(10, 30);
    samples::Random random(4);
    for (int i = 0; i < 10; ++i)
        for (int k = 0; k < 5; ++k)
            g(i, random.below(30)) = random.uniform();
    g.row(5) = g.row(9) = g.row(0);
    g.row(7) = -g.row(2);
    const RankReport report = rank_of_rows(samples::sparse(g), 1e-9);
    EXPECT_EQ(dependent_rows(report), (std::vector<int>{5, 7, 9}));
    for (const auto& d : report.dependent)
        EXPECT_EQ(d.combination.size(), 2u);
    EXPECT_EQ(report.dependent[2].combination[0].first, 0);
    EXPECT_NEAR(report.dependent[1].combination[0].second, 1, 1e-13);
}

TEST(Rank, ZeroAndEmptyRows) {
    CscMatrix g = samples::sparse(MatrixXd::Identity(3, 4));
    g.values[1] = 0;
    RankReport report = rank_of_rows(g, 1e-9);
    EXPECT_EQ(report.rank, 2);
    ASSERT_EQ(dependent_rows(report), std::vector<int>{1});
    EXPECT_EQ(report.dependent[0].combination.size(), 1u);
    EXPECT_EQ(rank_of_rows({{0, 4, {0, 0, 0, 0, 0}, {}}, {}}, 1e-9).rank, 0);
    report = rank_of_rows({{2, 0, {0}, {}}, {}}, 1e-9);
    EXPECT_EQ(report.rank, 0);
    EXPECT_EQ(report.dependent.size(), 2u);
}

TEST(Rank, MoreRowsThanUnknowns) {
    MatrixXd g = samples::random_columns(12, 5, 3);
    const RankReport report = rank_of_rows(samples::sparse(g), 1e-9);
    EXPECT_EQ(report.rank, 5);
    EXPECT_EQ(dependent_rows(report), (std::vector<int>{5, 6, 7, 8, 9, 10, 11}));
    expect_consistent(samples::sparse(g), report);
}

TEST(Rank, ToleranceSeparatesNearlyDependentRows) {
    MatrixXd g = MatrixXd::Zero(2, 3);
    g << 1, 1, 0, 1, 1, 1e-6;
    EXPECT_EQ(rank_of_rows(samples::sparse(g), 1e-9).rank, 2);
    EXPECT_EQ(rank_of_rows(samples::sparse(g), 1e-4).rank, 1);
}

TEST(Rank, RefusesBadInput) {
    CscMatrix g = samples::sparse(MatrixXd::Identity(2, 2));
    EXPECT_THROW(rank_of_rows(g, 0), std::invalid_argument);
    g.values[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(rank_of_rows(g, 1e-9), std::invalid_argument);
    g.values.pop_back();
    EXPECT_THROW(rank_of_rows(g, 1e-9), std::invalid_argument);
}

/// m rows on neighbouring unknowns; each of the listed rows is rewritten as a combination of three before it.
CscMatrix sparse_with_dependences(int m, int every, std::vector<int>& planted, bool wide) {
    samples::Random random(77);
    const int n = m + m / 5;
    std::vector<std::vector<double>> row(m);
    std::vector<std::vector<int>> column(m);
    for (int i = 0; i < m; ++i) {
        std::vector<double> full(n, 0.0);
        if (i > 10 && i % every == 0) {
            planted.push_back(i);
            for (const int k : {i - 1, i - 3, wide ? random.below(i - 5) : i - 7})
                for (std::size_t p = 0; p < row[k].size(); ++p)
                    full[column[k][p]] += (k % 3 + 0.5) * row[k][p];
        } else {
            full[i * (n - 1) / m] = 1;
            for (int k = 0; k < 5; ++k)
                full[std::min(n - 1, i + random.below(12))] = random.uniform();
        }
        for (int j = 0; j < n; ++j)
            if (full[j] != 0) {
                row[i].push_back(full[j]);
                column[i].push_back(j);
            }
    }
    CscMatrix out{{m, n, {}, {}}, {}};
    std::vector<std::vector<std::pair<int, double>>> by_column(n);
    for (int i = 0; i < m; ++i)
        for (std::size_t p = 0; p < row[i].size(); ++p)
            by_column[column[i][p]].emplace_back(i, row[i][p]);
    out.pattern.col_start.push_back(0);
    for (const auto& entries : by_column) {
        for (const auto& [i, v] : entries) {
            out.pattern.row.push_back(i);
            out.values.push_back(v);
        }
        out.pattern.col_start.push_back(out.pattern.nonzeros());
    }
    return out;
}

TEST(Rank, TwoThousandRowsWithKnownDependences) {
    for (const bool wide : {false, true}) {
        std::vector<int> planted;
        const CscMatrix g = sparse_with_dependences(2000, wide ? 200 : 20, planted, wide);
        const auto start = std::chrono::steady_clock::now();
        const RankReport report = rank_of_rows(g, 1e-9);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        RecordProperty(wide ? "seconds_wide" : "seconds", std::to_string(seconds));
        EXPECT_EQ(dependent_rows(report), planted);
        expect_consistent(g, report);
    }
}

} // namespace
} // namespace gudgeon
