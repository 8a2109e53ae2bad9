#include "contact/friction_law.hpp"
#include "tests/core/motion_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;

FrictionLaw law(const std::string& kind) {
    Friction friction;
    friction.kind = kind;
    friction.kinetic = 0.4;
    if (kind == "lugre" || kind == "dahl")
        friction.sigma0 = 1e3;
    if (kind != "dahl")
        friction.speed = 0.02;
    if (kind == "lugre") {
        friction.statics = 0.6;
        friction.exponent = 1.7;
        friction.sigma1 = 5;
        friction.sigma2 = 0.3;
    }
    return compile_friction(friction);
}

double mu(const FrictionLaw& law, double v, double z = 0) {
    return evaluate_friction<1>(law, Scalar(v), Scalar(z)).mu(0);
}

TEST(FrictionLaw, CoulombIsLinearBelowTheThresholdAndConstantAbove) {
    const FrictionLaw coulomb = law("coulomb");
    EXPECT_DOUBLE_EQ(mu(coulomb, 0.005), 0.1);
    EXPECT_DOUBLE_EQ(mu(coulomb, -0.005), -0.1);
    EXPECT_DOUBLE_EQ(mu(coulomb, 0.02), 0.4);
    EXPECT_DOUBLE_EQ(mu(coulomb, -3), -0.4);
    EXPECT_EQ(mu(coulomb, 0), 0);
    EXPECT_FALSE(coulomb.has_state());
}

TEST(FrictionLaw, SmoothCoulombHasNoKinkAtTheThreshold) {
    const FrictionLaw smooth = law("coulomb-smooth");
    EXPECT_DOUBLE_EQ(mu(smooth, 0.01), 0.4 * 0.6875); // 3/2 s - 1/2 s^3 at s = 1/2
    EXPECT_DOUBLE_EQ(mu(smooth, -0.5), -0.4);
    const auto slope = [&](double v) {
        return evaluate_friction<1>(smooth, Scalar(v), Scalar(0)).by_speed(0);
    };
    EXPECT_DOUBLE_EQ(slope(0), 0.4 / 0.02 * 1.5);
    EXPECT_NEAR(slope(0.02 * (1 - 1e-7)), 0, 1e-5);
    EXPECT_NEAR(slope(0.02 * (1 + 1e-7)), 0, 1e-12);
}

TEST(FrictionLaw, LuGreByHand) {
    const FrictionLaw lugre = law("lugre");
    // v = v_s: g = 0.4 + 0.2/e, z' = v - 1e3 v z/g
    const double g = 0.4 + 0.2 * std::exp(-1), z = 3e-4, v = -0.02, rate = v - 1e3 * 0.02 * z / g;
    const auto f = evaluate_friction<1>(lugre, Scalar(v), Scalar(z));
    EXPECT_NEAR(f.decay, 1e3 * 0.02 / g, 1e-12);
    EXPECT_NEAR(f.mu(0), 0.3 + 5 * rate + 0.3 * v, 1e-14);
    // steady sliding: sigma0 z = g sgn v
    const double fast = 0.5;
    EXPECT_NEAR(mu(lugre, fast, 0.4 / 1e3), 0.4 + 0.3 * fast, 1e-12);
    EXPECT_NEAR(mu(lugre, -fast, -0.4 / 1e3), -0.4 - 0.3 * fast, 1e-12);
    // at rest the bristles alone hold
    EXPECT_DOUBLE_EQ(mu(lugre, 0, 2e-4), 0.2);
    EXPECT_DOUBLE_EQ(lugre.state_scale(), 1e-3);
    EXPECT_DOUBLE_EQ(lugre.free_decay(), 200);
}

TEST(FrictionLaw, DahlIsLuGreWithoutDampingAndStribeckCurve) {
    const FrictionLaw dahl = law("dahl");
    const auto f = evaluate_friction<1>(dahl, Scalar(-0.3), Scalar(1e-4));
    EXPECT_DOUBLE_EQ(f.mu(0), 0.1);
    EXPECT_DOUBLE_EQ(f.decay, 1e3 * 0.3 / 0.4);
    EXPECT_EQ(f.by_speed(0), 0);
}

TEST(FrictionLaw, InThePlaneItActsAlongTheSlip) {
    const Vec3 direction = Vec3(1, 2, -2) / 3;
    for (const char* kind : {"coulomb", "coulomb-smooth", "lugre", "dahl"})
        for (const double v : {0.007, 0.3}) {
            const Vec3 in_space =
                evaluate_friction<3>(law(kind), Vec3(v * direction), Vec3(1e-4 * direction)).mu;
            EXPECT_LT((in_space - mu(law(kind), v, 1e-4) * direction).norm(), 1e-15) << kind;
        }
}

TEST(FrictionLaw, DerivativesAgainstDifferences) {
    const Vec3 z(2e-4, -1e-4, 1.5e-4);
    for (const char* kind : {"coulomb", "coulomb-smooth", "lugre", "dahl"})
        for (const Vec3& v : {Vec3(0.004, -0.006, 0.003), Vec3(-0.2, 0.1, 0.15)}) {
            SCOPED_TRACE(kind);
            const FrictionLaw l = law(kind);
            const auto f = evaluate_friction<3>(l, v, z);
            for (int k = 0; k < 3; ++k) {
                const auto at = [&](double h) {
                    return evaluate_friction<3>(l, Vec3(v + h * Vec3::Unit(k)), z);
                };
                const MatX by_speed = test::derivative([&](double h) { return MatX(at(h).mu); }, 2e-4);
                EXPECT_LT(test::error(f.by_speed.col(k), by_speed), 1e-8);
                if (!l.has_state())
                    continue;
                const MatX rate = test::derivative(
                    [&](double h) { return MatX(v + h * Vec3::Unit(k) - at(h).decay * z); }, 2e-4);
                EXPECT_LT(test::error(f.rate_by_speed.col(k), rate), 1e-8);
                const MatX by_state = test::derivative([&](double h) {
                    return MatX(evaluate_friction<3>(l, v, Vec3(z + h * Vec3::Unit(k))).mu);
                });
                EXPECT_LT(test::error(f.by_state * Vec3::Unit(k), by_state), 1e-8);
            }
        }
}

} // namespace
} // namespace gudgeon
