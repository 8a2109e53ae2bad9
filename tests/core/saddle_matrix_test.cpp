// Slots of the saddle-point matrix against a dense matrix put together from its parts.
#include "tests/core/whole_models.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gudgeon {
namespace {

using namespace test;

std::vector<std::pair<std::string, Model>> all_models() {
    std::vector<std::pair<std::string, Model>> models;
    for (const Mechanism& mechanism : mechanisms())
        models.emplace_back(mechanism.name, build_mechanism(mechanism.name));
    const auto add = [&](const std::string& name, const std::map<std::string, std::string>& parameters) {
        models.emplace_back(name, build_mechanism(name, parameters));
    };
    add("chain", {{"joint", "spherical"}, {"links", "5"}});
    add("chain", {{"joint", "universal"}, {"links", "5"}});
    add("four-bar", {{"loops", "3"}});
    add("suspension-chain", {{"units", "2"}, {"joints", "perfect"}});
    add("hmmwv-corner", {{"joints", "perfect"}});
    models.emplace_back("every joint", every_joint());
    models.emplace_back("every force", every_force());
    return models;
}

void expect_regular_symmetric(const CscPattern& p) {
    ASSERT_EQ(p.rows, p.cols);
    ASSERT_EQ(p.col_start.size(), static_cast<std::size_t>(p.cols) + 1);
    MatX present = MatX::Zero(p.rows, p.cols);
    for (int c = 0; c < p.cols; ++c)
        for (int i = p.col_start[c]; i < p.col_start[c + 1]; ++i) {
            if (i > p.col_start[c]) {
                ASSERT_LT(p.row[i - 1], p.row[i]) << "column " << c;
            }
            present(p.row[i], c) = 1;
        }
    EXPECT_EQ(present, MatX(present.transpose()));
}

/// A row over (v_a, w_a, v_b, w_b) among all velocities.
VecX over_velocities(const System& system, int a, int b, const Gradient<1>& g) {
    VecX out = VecX::Zero(system.velocities());
    for (int part = 0; part < 4; ++part)
        if (const int body = part < 2 ? a : b; body < system.moving)
            out.segment<3>(6 * body + 3 * (part % 2)) += g.part(part).transpose();
    return out;
}

TEST(SaddleMatrix, EverySlotHoldsItsEntry) {
    for (auto& [name, model] : all_models()) {
        SCOPED_TRACE(name);
        const System system = compiled(model);
        const int n = system.velocities(), m = system.row_count();
        const SaddleMatrix saddle(system);
        const CscPattern before = saddle.pattern();
        expect_regular_symmetric(before);
        std::mt19937 rng(3);
        Workspace ws = make_workspace(system);
        // what an earlier call left behind must not show
        CscMatrix K{before, std::vector<double>(before.nonzeros(), std::numeric_limits<double>::quiet_NaN())};
        for (int repeat = 0; repeat < 3; ++repeat) {
            const State state = shaken(system, rng, 0.05, 1);
            set_motion(system, state.q, state.u, ws);
            linearise(system, 0.1, state.lambda.data(), ws);
            const MatX G = dense(rows_as_matrix(system, ws));
            MatX truth = MatX::Zero(n + m, n + m);
            truth.topLeftCorner(n, n) = 300 * dense_mass(system) + dense(blocks_as_matrix(system, ws.lin.C)) +
                                        0.02 * dense(blocks_as_matrix(system, ws.lin.S));
            for (const Linearisation::StateCoupling& x : ws.lin.states) {
                const VecX force = over_velocities(system, x.a, x.b, x.force);
                const VecX rate = over_velocities(system, x.a, x.b, x.rate);
                truth.topLeftCorner(n, n) -= force * rate.transpose() / (300 + x.decay);
            }
            truth.bottomLeftCorner(m, n) = G;
            truth.topRightCorner(n, m) = G.transpose();
            saddle.assemble(system, ws, 300, 0.02, K.values);
            EXPECT_LT(error(dense(K), truth), 1e-15);

            truth.topLeftCorner(n, n) = 0.5 * dense_mass(system);
            saddle.assemble_mass(system, ws, 0.5, K.values);
            EXPECT_LT(error(dense(K), truth), 1e-15);
        }
        EXPECT_EQ(saddle.pattern().row, before.row);
        EXPECT_EQ(saddle.pattern().col_start, before.col_start);
    }
}

TEST(SaddleMatrix, MassMatrixIsThatOfTheBodies) {
    const System system = compiled(every_joint());
    EXPECT_EQ(dense(mass_matrix(system)), dense_mass(system));
}

TEST(SaddleMatrix, FixedBodiesHaveNoUnknowns) {
    Model model = build_mechanism("chain", {{"links", "3"}});
    model.bodies[1].fixed = true;
    const System system = compiled(model);
    EXPECT_EQ(system.moving, 2);
    EXPECT_EQ(system.velocities(), 12);
    EXPECT_EQ(system.row_count(), 15);
    const SaddleMatrix saddle(system);
    EXPECT_EQ(saddle.pattern().cols, 12 + 15);
    // the fixed link parts its neighbours: no entry couples their velocities
    for (int c = 0; c < 6; ++c)
        for (int i = saddle.pattern().col_start[c]; i < saddle.pattern().col_start[c + 1]; ++i)
            EXPECT_TRUE(saddle.pattern().row[i] < 6 || saddle.pattern().row[i] >= 12);
}

} // namespace
} // namespace gudgeon
