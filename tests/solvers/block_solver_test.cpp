#include "solvers/block_solver.hpp"

#include "core/assembly.hpp"
#include "solvers/dense_solver.hpp"
#include "tests/allocation_count.hpp"
#include "tests/solvers/sparse_samples.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace gudgeon {
namespace {

using Complex = std::complex<double>;
using test::compiled;
using test::count_allocations;
using test::shaken;

/// The matrix of a mechanism in motion, reactions and all.
struct Stage {
    CscPattern pattern;
    std::vector<double> values;
    std::vector<Complex> complex_values;
};

Stage stage_of(const std::string& name, const std::map<std::string, std::string>& parameters, double a = 700,
               Rows rows = Rows::independent) {
    const System system = compiled(name, parameters);
    std::mt19937 rng(5);
    const State state = shaken(system, rng, 0.05, 0.5);
    Workspace ws = make_workspace(system, 1);
    VecX lambda(system.row_count());
    for (Eigen::Index i = 0; i < lambda.size(); ++i)
        lambda[i] = std::uniform_real_distribution<double>(-50, 50)(rng);
    set_motion(system, state.q, state.u, ws);
    linearise(system, 0, lambda.data(), ws);
    const SaddleMatrix saddle(system, rows);
    Stage stage{saddle.pattern(), std::vector<double>(saddle.pattern().nonzeros()),
                std::vector<Complex>(saddle.pattern().nonzeros())};
    saddle.assemble(system, ws, a, 1 / a, stage.values);
    saddle.assemble(system, ws, Complex(a, 0.8 * a), 1.0 / Complex(a, 0.8 * a), stage.complex_values);
    return stage;
}

struct Mechanism {
    const char* name;
    std::map<std::string, std::string> parameters;
};
const std::vector<Mechanism> mechanisms{
    {"pendulum", {}},
    {"slider-crank", {}},
    {"slider-crank", {{"joint", "revolute"}}},
    {"chain", {{"links", "30"}}},
    {"chain", {{"links", "7"}, {"joint", "universal"}}},
    {"suspension-chain", {{"units", "5"}}},
    {"suspension-chain", {{"units", "5"}, {"joints", "perfect"}}},
    {"hmmwv-corner", {}},
    {"hmmwv-corner", {{"joints", "perfect"}}},
};

template <class Scalar> using Columns = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

template <class Scalar> Columns<Scalar> dense_of(const CscPattern& p, const std::vector<Scalar>& values) {
    Columns<Scalar> out = Columns<Scalar>::Zero(p.rows, p.cols);
    for (int j = 0; j < p.cols; ++j)
        for (int k = p.col_start[j]; k < p.col_start[j + 1]; ++k)
            out(p.row[k], j) = values[k];
    return out;
}

template <class Solver, class Scalar>
void expect_solution(Solver& solver, const CscPattern& pattern, const std::vector<Scalar>& values,
                     const std::string& what) {
    solver.analyse(pattern);
    ASSERT_TRUE(solver.factor(values).ok()) << what;
    const Columns<Scalar> k = dense_of(pattern, values);
    for (const int columns : {1, 2, 3}) {
        const Columns<Scalar> x = samples::random_columns(pattern.cols, columns, 9).template cast<Scalar>();
        Columns<Scalar> b = k * x;
        solver.solve({b.data(), static_cast<std::size_t>(b.size())}, columns);
        EXPECT_LT((b - x).norm() / x.norm(), 1e-9) << what;
    }
    EXPECT_EQ(solver.counts().klu_fallbacks, 0) << what;
    EXPECT_EQ(solver.counts().solves, 6) << what;
}

TEST(BlockSolver, FindsWhatTheMatrixWasMultipliedWith) {
    for (const Mechanism& m : mechanisms) {
        const Stage stage = stage_of(m.name, m.parameters);
        BlockSolver real;
        expect_solution(real, stage.pattern, stage.values, m.name);
        ComplexBlockSolver complex;
        expect_solution(complex, stage.pattern, stage.complex_values, m.name);
    }
}

/// Largest residual of K x = b over the largest of its terms, in unknowns scaled to diagonals of one.
double scaled_residual(const Eigen::MatrixXd& k, const Eigen::VectorXd& x, const Eigen::VectorXd& b, int n) {
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(x.size());
    for (int i = 0; i < n; ++i)
        scale[i] = 1 / std::sqrt(k(i, i));
    for (Eigen::Index i = n; i < x.size(); ++i)
        scale[i] = 1 / (k.col(i).head(n).cwiseProduct(scale.head(n))).cwiseAbs().maxCoeff();
    const Eigen::MatrixXd terms = (scale.asDiagonal() * k).cwiseAbs() * x.cwiseAbs().asDiagonal();
    return scale.cwiseProduct(k * x - b).cwiseAbs().maxCoeff() / terms.rowwise().sum().maxCoeff();
}

TEST(BlockSolver, SinglePrecisionKeepsSomeDigits) {
    for (const Mechanism& m : mechanisms) {
        const Stage stage = stage_of(m.name, m.parameters);
        const Eigen::MatrixXd k = dense_of(stage.pattern, stage.values);
        const Eigen::VectorXd b = samples::random_columns(stage.pattern.cols, 1, 4);
        double residual[2];
        for (const bool single : {false, true}) {
            BlockSolver solver({.single_precision = single});
            solver.analyse(stage.pattern);
            ASSERT_TRUE(solver.factor(stage.values).ok()) << m.name;
            Eigen::VectorXd x = b;
            solver.solve({x.data(), static_cast<std::size_t>(x.size())}, 1);
            residual[single] = scaled_residual(k, x, b, stage.pattern.leading);
        }
        EXPECT_LT(residual[false], 1e-13) << m.name;
        EXPECT_LT(residual[true], 1e-4) << m.name;
        EXPECT_GT(residual[true], 1e-10) << m.name << ": not in single precision";
    }
}

TEST(BlockSolver, SmallPivotsAreKeptInDoublePrecision) {
    const Stage stage = stage_of("four-bar", {{"loops", "4"}}, 700, Rows::soft); // soft rows have tiny pivots
    const Eigen::VectorXd b = samples::random_columns(stage.pattern.cols, 1, 4);
    Eigen::VectorXd x[2]{b, b};
    for (const bool single : {false, true}) {
        BlockSolver solver({.single_precision = single});
        solver.analyse(stage.pattern);
        ASSERT_TRUE(solver.factor(stage.values).ok());
        solver.solve({x[single].data(), static_cast<std::size_t>(b.size())}, 1);
    }
    EXPECT_EQ((x[0] - x[1]).norm(), 0);
}

TEST(BlockSolver, RepeatedRowsAreSolvedWhereTheyAreSoft) {
    const Stage stage = stage_of("four-bar", {{"loops", "4"}}, 700, Rows::soft);
    BlockSolver blocks;
    DenseSolver oracle;
    blocks.analyse(stage.pattern);
    oracle.analyse(stage.pattern);
    ASSERT_TRUE(blocks.factor(stage.values).ok());
    ASSERT_TRUE(oracle.factor(stage.values).ok());
    Eigen::MatrixXd b = samples::random_columns(stage.pattern.cols, 1, 4), x = b;
    b.bottomRows(stage.pattern.cols - stage.pattern.leading).setZero();
    x = b;
    blocks.solve({b.data(), static_cast<std::size_t>(b.size())}, 1);
    oracle.solve({x.data(), static_cast<std::size_t>(x.size())}, 1);
    EXPECT_LT((b - x).topRows(stage.pattern.leading).norm(), 1e-6 * x.topRows(stage.pattern.leading).norm());
}

TEST(BlockSolver, SameBitsForAnyNumberOfThreads) {
    const Stage stage = stage_of("suspension-chain", {{"units", "60"}});
    EXPECT_GT(block_structure(stage.pattern).parts.size(), 2u) << "there is something to share";
    std::vector<double> x[3];
    std::vector<Complex> z[3];
    for (const int threads : {1, 2, 3}) {
        BlockSolver real({.threads = threads, .single_precision = true});
        ComplexBlockSolver complex({.threads = threads});
        real.analyse(stage.pattern);
        complex.analyse(real.shared_structure());
        ASSERT_TRUE(real.factor(stage.values).ok());
        ASSERT_TRUE(complex.factor(stage.complex_values).ok());
        x[threads - 1].assign(2 * stage.pattern.cols, 1.0);
        z[threads - 1].assign(2 * stage.pattern.cols, Complex(1, 2));
        real.solve(x[threads - 1], 2);
        complex.solve(z[threads - 1], 2);
    }
    for (const int k : {1, 2}) {
        EXPECT_EQ(x[0], x[k]);
        EXPECT_EQ(z[0], z[k]);
    }
}

TEST(BlockSolver, NewValuesNeedNoAllocation) {
    const Stage stage = stage_of("suspension-chain", {{"units", "3"}});
    BlockSolver solver;
    solver.analyse(stage.pattern);
    std::vector<double> rhs(2 * stage.pattern.cols, 1.0);
    ASSERT_TRUE(solver.factor(stage.values).ok());
    solver.solve(rhs, 2);
    bool ok = false;
    const long allocations = count_allocations([&] {
        ok = solver.factor(stage.values).ok();
        solver.solve(rhs, 2);
    });
    EXPECT_TRUE(ok);
    EXPECT_LE(allocations, 0);
}

// Two bodies in a row, of one no number on the diagonal but through the other: regular, but not by blocks.
TEST(BlockSolver, KluTakesOverWhereABlockHasNoPivot) {
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(12, 12);
    for (int i = 0; i < 6; ++i)
        k(i, i + 6) = k(i + 6, i) = 1 + i;
    CscMatrix a = samples::sparse(k + Eigen::MatrixXd::Constant(12, 12, 1e-300));
    a.pattern.leading = 12;
    for (int j = 0, p = 0; j < 12; ++j)
        for (; p < a.pattern.col_start[j + 1]; ++p)
            a.values[p] = k(a.pattern.row[p], j);
    BlockSolver solver;
    solver.analyse(a.pattern);
    ASSERT_TRUE(solver.factor(a.values).ok());
    EXPECT_EQ(solver.counts().klu_fallbacks, 1);
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(12, 1, 12), b = k * x;
    solver.solve({b.data(), 12}, 1);
    EXPECT_LT((b - x).norm(), 1e-13);
}

/// A hub with arms on spherical joints.
CscPattern star(int arms) {
    Model model;
    Body body;
    body.mass = 1;
    body.inertia = Mat3::Identity();
    for (int i = 0; i <= arms; ++i) {
        body.name = "body" + std::to_string(i);
        body.position = Vec3(std::cos(i), std::sin(i), 0.1 * i);
        model.bodies.push_back(body);
        if (i == 0)
            continue;
        Joint joint;
        joint.name = "joint" + std::to_string(i);
        joint.kind = JointKind::spherical;
        joint.bodies = {"body0", body.name};
        joint.points = {body.position, body.position};
        model.joints.push_back(joint);
    }
    return SaddleMatrix(compiled(std::move(model))).pattern();
}

TEST(BlockSolver, KluTakesHubsOfManyJoints) {
    BlockSolver few, many;
    few.analyse(star(6));
    many.analyse(star(200));
    EXPECT_STREQ(few.name(), "block");
    EXPECT_STREQ(many.name(), "klu");
    EXPECT_TRUE(block_structure(star(200)).fronts.empty());
}

TEST(BlockSolver, LoadedFactorsGiveTheSameBits) {
    const Stage good = stage_of("chain", {{"links", "5"}});
    const Stage soft = stage_of("four-bar", {{"loops", "3"}}, 700, Rows::soft); // in double precision
    for (const Stage* stage : {&good, &soft}) {
        BlockSolver saved({.single_precision = true}), loaded({.single_precision = true});
        saved.analyse(stage->pattern);
        loaded.analyse(stage->pattern);
        ASSERT_TRUE(saved.factor(stage->values).ok());
        Archive writing;
        saved.visit(writing);
        Archive reading(writing.content());
        loaded.visit(reading);
        std::vector<double> x(stage->pattern.cols, 1.0), y = x;
        saved.solve(x);
        loaded.solve(y);
        EXPECT_EQ(x, y);
        EXPECT_EQ(loaded.counts().factorisations, 1);
    }
}

TEST(BlockSolver, SingularMatrixIsRefusedWithAColumn) {
    Stage stage = stage_of("chain", {{"links", "4"}});
    const int column = stage.pattern.leading + 7; // a row that moves nothing
    for (int j = 0; j < stage.pattern.cols; ++j)
        for (int p = stage.pattern.col_start[j]; p < stage.pattern.col_start[j + 1]; ++p)
            if (j == column || stage.pattern.row[p] == column)
                stage.values[p] = 0;
    BlockSolver solver;
    solver.analyse(stage.pattern);
    const FactorStatus status = solver.factor(stage.values);
    EXPECT_EQ(status.kind, FactorStatus::Kind::singular);
    EXPECT_EQ(status.column, column);
    std::vector<double> rhs(stage.pattern.cols, 1.0);
    EXPECT_THROW(solver.solve(rhs), std::logic_error);
}

TEST(BlockSolver, BadNumbersAreNamedByColumn) {
    Stage stage = stage_of("chain", {{"links", "4"}});
    const int column = 9;
    stage.values[stage.pattern.col_start[column]] = std::numeric_limits<double>::quiet_NaN();
    stage.complex_values[stage.pattern.col_start[column]] = {0, std::numeric_limits<double>::infinity()};
    BlockSolver real;
    ComplexBlockSolver complex;
    real.analyse(stage.pattern);
    complex.analyse(stage.pattern);
    for (const FactorStatus& status : {real.factor(stage.values), complex.factor(stage.complex_values)}) {
        EXPECT_EQ(status.kind, FactorStatus::Kind::non_finite);
        EXPECT_EQ(status.column, column);
    }
}

TEST(BlockStructure, EveryUnknownAndEntryHasOnePlace) {
    for (const Mechanism& m : mechanisms) {
        const CscPattern pattern = stage_of(m.name, m.parameters).pattern;
        const BlockStructure s = block_structure(pattern);
        std::set<int> unknowns(s.order.begin(), s.order.end()), slots;
        EXPECT_EQ(std::ssize(unknowns), pattern.cols) << m.name;
        for (const Front& front : s.fronts)
            s.for_entries(front.entry_start, front.entry_end, [&](int row, int col, int slot) {
                const auto unknown = [&](int place) { return s.order[s.unknown(front, place)]; };
                const int column = unknown(col);
                EXPECT_EQ(pattern.row[slot], unknown(row));
                EXPECT_GE(slot, pattern.col_start[column]);
                EXPECT_LT(slot, pattern.col_start[column + 1]);
                EXPECT_TRUE(slots.insert(slot).second);
            });
        EXPECT_EQ(std::ssize(slots), pattern.nonzeros()) << m.name;
        const CscPattern back = pattern_of(s);
        EXPECT_EQ(back.row, pattern.row) << m.name;
        EXPECT_EQ(back.col_start, pattern.col_start) << m.name;
        EXPECT_EQ(back.leading, pattern.leading) << m.name;
    }
}

TEST(BlockStructure, WorkGrowsWithTheLengthAndNotFaster) {
    for (const char* name : {"chain", "suspension-chain", "four-bar"}) {
        const char* size = std::string(name) == "chain"      ? "links"
                           : std::string(name) == "four-bar" ? "loops"
                                                             : "units";
        const BlockStructure small = block_structure(stage_of(name, {{size, "20"}}).pattern);
        const BlockStructure large = block_structure(stage_of(name, {{size, "80"}}).pattern);
        EXPECT_LT(large.operations, 4.4 * small.operations) << name;
        EXPECT_LT(large.nonzeros, 4.4 * small.nonzeros) << name;
    }
}

TEST(BlockStructure, GivenOrderMustBeAPermutationOfTheBodies) {
    const CscPattern pattern = stage_of("chain", {{"links", "3"}}).pattern;
    EXPECT_NO_THROW((void)block_structure(pattern, std::vector<int>{2, 0, 1}));
    EXPECT_THROW((void)block_structure(pattern, std::vector<int>{0, 0, 1}), std::invalid_argument);
    EXPECT_THROW((void)block_structure(pattern, std::vector<int>{0, 1}), std::invalid_argument);
}

} // namespace
} // namespace gudgeon
