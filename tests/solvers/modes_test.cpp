// Eigenfrequencies and damping ratios against closed forms and a dense oracle.
#include "models/builders.hpp"
#include "solvers/modes.hpp"
#include "solvers/statics.hpp"
#include "tests/solvers/system_tools.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

ModesReport modes_of(Model model, ModesOptions options = {}, bool rest = true) {
    const System system = compiled(without_friction(std::move(model)));
    State state = initial_state(system);
    EXPECT_TRUE(assemble_start(system, state).ok);
    if (rest) {
        EXPECT_TRUE(find_equilibrium(system, state).ok);
    }
    return find_modes(system, state, options);
}

Model hanging_rods(int rods, double above = -1) {
    Model model;
    for (int i = 0; i < rods; ++i) {
        model.bodies.push_back(
            make_body(fmt::format("rod{}", i), 1.5, {0.2, 0.2, 0.1}, {0, 0, above * (i + 0.5)}));
        model.joints.push_back(make_joint(fmt::format("hinge{}", i), JointKind::revolute,
                                          i ? fmt::format("rod{}", i - 1) : "ground", fmt::format("rod{}", i),
                                          {0, 0, above * i}, Vec3::UnitY()));
    }
    return model;
}

TEST(Modes, Pendulum) {
    const ModesReport report = modes_of(hanging_rods(1));
    ASSERT_EQ(report.modes.size(), 1u);
    const double omega = std::sqrt(1.5 * 9.81 * 0.5 / (0.2 + 1.5 * 0.25));
    EXPECT_NEAR(report.modes[0].omega(), omega, 1e-12);
    EXPECT_NEAR(report.modes[0].hertz(), omega / (2 * pi), 1e-12);
    EXPECT_NEAR(report.modes[0].damping(), 0, 1e-14);
    EXPECT_EQ(report.modes[0].kind, Mode::Kind::vibration);
}

// Two rods: M th'' + K th = 0 in absolute angles, K = m g l diag(3/2, 1/2).
TEST(Modes, DoublePendulum) {
    const ModesReport report = modes_of(hanging_rods(2));
    const double m = 1.5, J = 0.2;
    Eigen::Matrix2d mass, stiffness;
    mass << J + m * 0.25 + m, 0.5 * m, 0.5 * m, J + 0.25 * m;
    stiffness << 1.5 * m * 9.81, 0, 0, 0.5 * m * 9.81;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> eigen(stiffness, mass);
    ASSERT_EQ(report.modes.size(), 2u);
    for (int k = 0; k < 2; ++k)
        EXPECT_NEAR(report.modes[k].omega(), std::sqrt(eigen.eigenvalues()[k]), 1e-11);
    // shape: the rods' angles, seen as their rotations
    const Eigen::Vector2d angles = eigen.eigenvectors().col(0);
    EXPECT_NEAR(std::abs(report.modes[0].shape[10] / report.modes[0].shape[4]), angles[1] / angles[0], 1e-9);
}

TEST(Modes, InvertedPendulumGrows) {
    const ModesReport report = modes_of(hanging_rods(1, 1));
    ASSERT_EQ(report.modes.size(), 2u);
    EXPECT_EQ(report.unstable, 1);
    const double rate = std::sqrt(1.5 * 9.81 * 0.5 / (0.2 + 1.5 * 0.25));
    for (const Mode& mode : report.modes)
        EXPECT_NEAR(mode.root.real(), mode.kind == Mode::Kind::unstable ? rate : -rate, 1e-11);
}

TEST(Modes, BlockOnRubberHasTheDampingRatiosOfOscillators) {
    Model model = test::block_on_rubber(3000, 60);
    model.gravity.setZero();
    const ModesReport report = modes_of(model);
    struct Oscillator {
        double m, c, k;
    };
    std::vector<Mode> left = report.modes;
    // the last one is overdamped: two real roots
    for (const Oscillator& o :
         {Oscillator{3, 40, 4e4}, {3, 50, 5e4}, {3, 60, 6e4}, {0.02, 0.1, 100}, {0.03, 0.2, 200}}) {
        const double omega = std::sqrt(o.k / o.m), damping = o.c / (2 * std::sqrt(o.k * o.m));
        const auto found = std::ranges::find_if(left, [&](const Mode& mode) {
            return std::abs(mode.omega() - omega) < 1e-9 * omega &&
                   std::abs(mode.damping() - damping) < 1e-10;
        });
        ASSERT_NE(found, left.end()) << omega;
        EXPECT_EQ(found->kind, Mode::Kind::vibration);
        left.erase(found);
    }
    ASSERT_EQ(left.size(), 2u);
    const double half = 60 / (2 * 0.04), root = std::sqrt(half * half - 3000 / 0.04);
    EXPECT_NEAR(left[0].root.real(), -half + root, 1e-9 * half);
    EXPECT_NEAR(left[1].root.real(), -half - root, 1e-9 * half);
    for (const Mode& mode : left)
        EXPECT_EQ(mode.kind, Mode::Kind::overdamped);
}

// A sleeping top: I s^2 - i (Ip W) s - m g l = 0.
TEST(Modes, GyroscopicTermsHoldATopUpright) {
    for (const double spin : {150.0, 40.0}) {
        const Model model = build_mechanism("heavy-top", {{"tilt", "0"}, {"spin", std::to_string(spin)}});
        const ModesReport report = modes_of(model, {}, false);
        const std::complex<double> half(0, 0.01 * spin / (2 * 0.11));
        const std::complex<double> root = std::sqrt(half * half + 9.81 * 0.3 / 0.11);
        EXPECT_EQ(report.unstable, spin > 100 ? 0 : 1);
        EXPECT_EQ(report.neutral, 1);
        ASSERT_EQ(report.modes.size(), 3u);
        for (const std::complex<double> s : {half + root, half - root})
            EXPECT_TRUE(std::ranges::any_of(report.modes, [&](const Mode& m) {
                return std::abs(m.root - s) < 1e-8;
            })) << s;
    }
}

// Omega of the chain from a dense generalised eigenproblem on the null space of G.
TEST(Modes, ChainByBothWaysAgreesWithADenseEigenproblem) {
    const Model model = hanging_rods(60);
    const System system = compiled(model);
    State state = initial_state(system);
    ASSERT_TRUE(find_equilibrium(system, state).ok);
    Workspace ws = make_workspace(system);
    const MatX g = dense_rows(system, state, ws);
    linearise(system, 0, state.lambda.data(), ws);
    const MatX s = dense(blocks_as_matrix(system, ws.lin.S));
    const Eigen::ColPivHouseholderQR<MatX> qr(g.transpose());
    const MatX z = MatX(qr.householderQ()).rightCols(system.velocities() - qr.rank());
    const MatX k = z.transpose() * s * z;
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatX> eigen(0.5 * (k + k.transpose()),
                                                               z.transpose() * dense_mass(system) * z);
    for (const int dense_up_to : {1000, 10}) {
        ModesOptions options;
        options.dense_up_to = dense_up_to;
        options.count = 12;
        const ModesReport report = find_modes(system, state, options);
        EXPECT_EQ(report.solver, dense_up_to == 10 ? "arnoldi" : "dense");
        ASSERT_EQ(report.modes.size(), 12u);
        for (int i = 0; i < 12; ++i)
            EXPECT_NEAR(report.modes[i].omega() / std::sqrt(eigen.eigenvalues()[i]), 1, 1e-9);
    }
}

// Rods on balls: every frequency of the plane chain twice, and a free turn of every rod about itself.
TEST(Modes, RepeatedAndNeutralRootsAreAllFound) {
    Model model = hanging_rods(60);
    for (Joint& joint : model.joints) {
        joint.kind = JointKind::spherical;
        joint.axes.reset();
    }
    const ModesReport plane = modes_of(hanging_rods(60));
    ModesOptions options;
    options.count = 12;
    options.dense_up_to = 1000;
    const System system = compiled(model);
    State state = initial_state(system);
    ASSERT_TRUE(assemble_start(system, state).ok);
    ASSERT_TRUE(find_equilibrium(system, state).ok);
    const ModesReport report = find_modes(system, state, options);
    EXPECT_EQ(report.neutral, 60);
    for (int i = 0; i < 12; ++i)
        EXPECT_NEAR(report.modes[60 + i].omega() / plane.modes[i / 2].omega(), 1, 1e-8) << i;
}

TEST(Modes, SuspensionsByBothWays) {
    Model model = build_mechanism("suspension-chain", {{"units", "10"}});
    const System system = compiled(model);
    State state = initial_state(system);
    ASSERT_TRUE(find_equilibrium(system, state).ok);
    ModesOptions options;
    options.count = 15;
    options.dense_up_to = 2000;
    const ModesReport dense = find_modes(system, state, options);
    options.dense_up_to = 10;
    const ModesReport sparse = find_modes(system, state, options);
    EXPECT_EQ(dense.neutral, 3);
    EXPECT_EQ(sparse.neutral, 3);
    ASSERT_EQ(dense.modes.size(), 18u);
    ASSERT_EQ(sparse.modes.size(), 18u);
    for (int i = 3; i < 18; ++i) {
        EXPECT_NEAR(std::abs(dense.modes[i].root - sparse.modes[i].root) / dense.modes[i].omega(), 0, 1e-7)
            << i;
        EXPECT_EQ(dense.modes[i].kind, Mode::Kind::vibration);
    }
}

// A ball in its socket: K = 3/2 W / d along the load; the law's damping over the resting memory gives
// chi / sqrt(4.8) of the critical one.
TEST(Modes, RestingContactVibratesAndDamps) {
    ContactLaw law;
    law.kind = "hunt-crossley";
    law.stiffness = 5e7;
    law.restitution = 0.8;
    const ModesReport report = modes_of(test::ball_in_socket(law));
    EXPECT_EQ(report.neutral, 3); // turns
    const double depth = std::pow(2 * 9.81 / 5e7, 2.0 / 3), chi = 1.5 * 0.2;
    const Mode& stiff = report.modes.back();
    EXPECT_NEAR(stiff.omega() / std::sqrt(1.5 * 9.81 / depth), 1, 1e-8);
    EXPECT_NEAR(stiff.damping(), chi / std::sqrt(4.8), 1e-7);
    // across: a pendulum in the play
    EXPECT_NEAR(report.modes[3].omega() / std::sqrt(9.81 / (1e-3 + depth)), 1, 1e-8);
}

} // namespace
} // namespace gudgeon
