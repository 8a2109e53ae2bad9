// Derivatives and right-hand sides of whole systems against differences of forces and constraints.
#include "core/assembly.hpp"

#include "tests/core/whole_models.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace gudgeon {
namespace {

using namespace test;

struct Case {
    std::string name;
    std::function<Model()> build;
    double moved; // how far from the start the bodies are shaken, m and rad
};

// for the names of the tests
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class WholeSystem : public testing::TestWithParam<Case> {
  protected:
    WholeSystem() : system_(compiled(GetParam().build())), ws_(make_workspace(system_)) {
        std::mt19937 rng(5);
        state_ = shaken(system_, rng, GetParam().moved, 1.5);
        state_.t = 0.37;
        for (double& x : ws_.external)
            x = std::uniform_real_distribution<double>(-3, 3)(rng);
        ws_.angles = state_.angles;
        set_motion(system_, state_.q, state_.u, ws_);
        update_angles(system_, 0.37, ws_, ws_.angles);
    }

    void put(const VecX& q, const VecX& u) { set_motion(system_, q, u, ws_); }
    VecX moved_along(const VecX& step, double h) const {
        VecX q = state_.q;
        move(system_, h * step, q);
        return q;
    }
    /// f - G^T lambda
    VecX forces() {
        evaluate_forces(system_, state_.t, ws_);
        evaluate_constraints(system_, state_.t, state_.lambda.data(), false, ws_);
        return ws_.f;
    }

    /// Every column of matrix against -d f/d(coordinate), f(step, h). Entries count relative to the
    /// largest of their row and column together.
    template <class F> void expect_derivative(const MatX& matrix, F f) {
        MatX truth(matrix.rows(), matrix.cols());
        for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
            const VecX step = VecX::Unit(matrix.cols(), k);
            truth.col(k) = derivative([&](double h) { return MatX(f(step, h)); }, 2e-3);
        }
        for (Eigen::Index i = 0; i < matrix.rows(); ++i)
            for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
                const double size =
                    std::min(truth.row(i).cwiseAbs().maxCoeff(), truth.col(k).cwiseAbs().maxCoeff());
                ASSERT_NEAR(matrix(i, k), truth(i, k), 1e-6 * (1 + size)) << "row " << i << ", column " << k;
            }
    }

    System system_;
    Workspace ws_;
    State state_;
};

TEST_P(WholeSystem, DerivativesTakeRoomWhenTheyAreFormed) {
    const std::size_t blocks = 9 * static_cast<std::size_t>(system_.layout.blocks());
    forces();
    EXPECT_TRUE(ws_.lin.C.empty() && ws_.lin.S.empty() && ws_.rate_rows.empty());
    linearise(system_, state_.t, state_.lambda.data(), ws_);
    EXPECT_EQ(ws_.lin.C.size(), blocks);
    EXPECT_EQ(ws_.lin.S.size(), blocks);
    EXPECT_TRUE(ws_.rate_rows.empty());
    evaluate_rate_rows(system_, state_.t, ws_);
    EXPECT_EQ(ws_.rate_rows.size(), 12 * system_.rows.size());
}

TEST_P(WholeSystem, DampingIsTheForceDerivativeByVelocities) {
    linearise(system_, state_.t, state_.lambda.data(), ws_);
    const MatX C = dense(blocks_as_matrix(system_, ws_.lin.C));
    expect_derivative(C, [&](const VecX& step, double h) -> VecX {
        put(state_.q, state_.u + h * step);
        return -forces();
    });
}

TEST_P(WholeSystem, StiffnessIsTheForceDerivativeByPositions) {
    linearise(system_, state_.t, state_.lambda.data(), ws_);
    const MatX S = dense(blocks_as_matrix(system_, ws_.lin.S));
    expect_derivative(S, [&](const VecX& step, double h) -> VecX {
        put(moved_along(step, h), state_.u);
        return -forces();
    });
}

TEST_P(WholeSystem, RowsAreTheConstraintDerivative) {
    linearise(system_, state_.t, state_.lambda.data(), ws_);
    const MatX G = dense(rows_as_matrix(system_, ws_));
    expect_derivative(G, [&](const VecX& step, double h) -> VecX {
        put(moved_along(step, h), state_.u);
        evaluate_constraints(system_, state_.t, nullptr, false, ws_);
        return ws_.phi;
    });
    const VecX x = VecX::LinSpaced(G.cols(), -1, 2), y = VecX::LinSpaced(G.rows(), 3, -1);
    VecX gx(G.rows()), gty = x;
    rows_times(system_, ws_, x, gx);
    add_transposed_rows(system_, ws_, y, -2, gty);
    EXPECT_LT(error(gx, G * x), 1e-14);
    EXPECT_LT(error(gty, x - 2 * G.transpose() * y), 1e-14);
}

// Along q(s) with constant u: d Phi/ds = G u + dPhi/dt and d2 Phi/ds2 = -gamma.
TEST_P(WholeSystem, RatesAndAccelerationsOfTheConstraints) {
    evaluate_constraints(system_, state_.t, nullptr, true, ws_);
    const VecX rate = ws_.rate;
    VecX gamma(system_.row_count());
    const Evaluation e = evaluation(system_, ws_, state_.t);
    for (const auto& batch : system_.constraints)
        batch->acceleration_rhs(e, gamma.data());
    const auto phi = [&](double s) -> MatX {
        put(moved_along(state_.u, s), state_.u);
        evaluate_constraints(system_, state_.t + s, nullptr, false, ws_);
        return ws_.phi;
    };
    EXPECT_LT(error(rate, derivative(phi, 2e-3)), 1e-10);
    EXPECT_LT(error(-gamma, second_derivative(phi, 1e-2)), 1e-6);
}

// Kinetic energy changes by the power of all forces; what is stored, lost and put in accounts for it.
TEST_P(WholeSystem, PowersBalance) {
    const VecX f = forces();
    put(state_.q, state_.u);
    const Energies now = energies(system_, state_.t, state_.lambda.data(), ws_);
    evaluate_constraints(system_, state_.t, nullptr, true, ws_);
    const VecX rate = ws_.rate, drive = derivative(
                                    [&](double s) -> MatX {
                                        evaluate_constraints(system_, state_.t + s, nullptr, false, ws_);
                                        return ws_.phi;
                                    },
                                    2e-3);
    double drive_power = 0;
    for (const auto& batch : system_.constraints)
        drive_power += batch->drive_power(evaluation(system_, ws_, state_.t), state_.lambda.data());
    EXPECT_NEAR(drive_power, state_.lambda.dot(drive), 1e-9 * (1 + std::abs(drive_power)));
    // a shaken state lets the constraints work: their power is lambda . (G u), of which the drives' part
    // counts as input
    const double leak = -state_.lambda.dot(rate - drive);
    const auto stored = [&](double s) {
        put(moved_along(state_.u, s), state_.u);
        const Energies e = energies(system_, state_.t + s, nullptr, ws_);
        return MatX::Constant(1, 1, e.potential + e.elastic);
    };
    const double power = f.dot(state_.u); // the gyroscopic part has none
    const double input = now.input_power - state_.lambda.dot(drive);
    const double balance = power + derivative(stored, 2e-3)(0) + now.dissipated_power - input - leak;
    EXPECT_NEAR(balance, 0, 1e-8 * (1 + std::abs(power) + std::abs(now.dissipated_power)));
}

INSTANTIATE_TEST_SUITE_P(
    Assembly, WholeSystem,
    testing::Values(Case{"SliderCrank", [] { return build_mechanism("slider-crank"); }, 0.1},
                    Case{"Bushings", [] { return build_mechanism("suspension-chain"); }, 0.01},
                    Case{"PerfectSuspension",
                         [] {
                             return build_mechanism("suspension-chain", {{"joints", "perfect"}});
                         },
                         0.01},
                    Case{"VehicleCorner", [] { return build_mechanism("hmmwv-corner"); }, 0.01},
                    Case{"EveryJoint", every_joint, 0.2}, Case{"EveryForce", every_force, 0.2}),
    [](const auto& info) { return info.param.name; });

TEST(Assembly, MassTimesAndItsInverse) {
    const System system = compiled("slider-crank");
    const VecX x = VecX::LinSpaced(system.velocities(), -1, 3);
    VecX y = x;
    mass_times(system, y, y);
    EXPECT_LT(error(y, dense_mass(system) * x), 1e-15);
    inverse_mass_times(system, y, y);
    EXPECT_LT(error(y, x), 1e-14);
}

TEST(Assembly, BodyAtRestFeelsItsWeightAndTheLoadSet) {
    Model model;
    model.gravity = {1, 0, -9};
    model.bodies = {make_body("block", 2, {1, 2, 3}, {0, 0, 0})};
    model.bodies[0].orientation = {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}; // body x is global Y
    const System system = compiled(model);
    Workspace ws = make_workspace(system);
    ws.external << 0, 5, 0, 0, 7, 0; // moment about global Y: body x
    evaluate_forces(system, 0, ws);
    Vec6 expected;
    expected << 2, 5, -18, 7, 0, 0;
    EXPECT_LT((ws.f - expected).norm(), 1e-14);
}

TEST(Assembly, GyroscopicMomentIsEulers) {
    Model model;
    model.gravity.setZero();
    model.bodies = {make_body("block", 2, {1, 2, 2.5}, {0, 0, 0})};
    model.bodies[0].angular_velocity = {3, 4, 5};
    const System system = compiled(model);
    Workspace ws = make_workspace(system);
    evaluate_forces(system, 0, ws);
    // J1 w1' = (J2 - J3) w2 w3 and cyclic
    const Vec3 expected(-0.5 * 20, 1.5 * 15, -1 * 12);
    EXPECT_LT((ws.f.segment<3>(3) - expected).norm(), 1e-14);
}

} // namespace
} // namespace gudgeon
