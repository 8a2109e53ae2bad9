#include "contact/friction_batch.hpp"
#include "tests/contact/friction_tools.hpp"
#include "tests/core/force_tools.hpp"

namespace gudgeon {
namespace {

using test::lugre;
using test::random_pair;
using test::Scene;
using Slider = FrictionKernel<DisplacementMeasure>;
using Pin = FrictionKernel<AngleMeasure>;

Friction coulomb(double speed = 0.5) {
    Friction friction;
    friction.kind = "coulomb";
    friction.kinetic = 0.3;
    friction.speed = speed;
    return friction;
}

struct FrictionScene : Scene {
    double z = 3e-3;
    Vec3 lambda{3, -2, 6};
};

Slider::Element slider(const Friction& friction) {
    Slider::Element x;
    x.b = 1;
    x.measure = {{0.1, 0.2, -0.3}, {-0.2, 0.4, 0.1}, Vec3(2, -1, 2) / 3};
    x.law = compile_friction(friction);
    x.normal_force = 7;
    if (x.law.has_state())
        x.state = 0;
    return x;
}

// The angle of b about its own z axis, seen from a.
Pin::Element pin(const Friction& friction) {
    Pin::Element x;
    x.b = 1;
    x.measure = {{Vec3::UnitY(), Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitX()}, 0};
    x.law = compile_friction(friction);
    x.lever = 0.2;
    x.normal_force = 7;
    if (x.law.has_state())
        x.state = 0;
    return x;
}

// Scene::evaluation() with friction states and multipliers.
template <class F> void with_scene(const FrictionScene& scene, const F& f) {
    Evaluation e = scene.evaluation();
    e.z = &scene.z;
    e.lambda = scene.lambda.data();
    f(e);
}

template <class Kernel> void check(const typename Kernel::Element& x) {
    std::mt19937 rng(5);
    for (int trial = 0; trial < 5; ++trial) {
        FrictionScene scene;
        scene.m = random_pair(rng);
        const auto at = [&](const test::Pair& m) {
            Evaluation e = scene.evaluation();
            e.z = &scene.z;
            e.lambda = scene.lambda.data();
            e.body = m.data();
            return e;
        };
        const auto wrench = [&](const test::Pair& m) { return MatX(test::dense(Kernel::wrench(at(m), x))); };
        BlockMatrix c = test::zero_blocks(), s = test::zero_blocks();
        Kernel::linearise(at(scene.m), x, c, s);
        EXPECT_LT(test::error(test::dense(c), -test::jacobian(scene.m, wrench, test::pushed)), 1e-8);
        EXPECT_LT(test::error(test::dense(s), -test::jacobian(scene.m, wrench, test::moved)), 1e-8);
        EXPECT_EQ(test::outside(c, Kernel::coupling), 0);
        EXPECT_EQ(test::outside(s, Kernel::coupling), 0);

        const PairWrench w = Kernel::wrench(at(scene.m), x);
        EXPECT_LT(test::resultant(w, scene.m).norm(), 1e-13 * (1 + 10 * test::dense(w).norm()));
        const double power = test::dense(w).dot(test::velocities(scene.m));
        EXPECT_NEAR(Kernel::energies(at(scene.m), x).dissipated_power, -power, 1e-13 * (1 + std::abs(power)));
        if (x.state < 0) {
            EXPECT_LT(power, 0);
            continue;
        }
        const auto coupling = Kernel::state_coupling(at(scene.m), x);
        const auto z_rate = [&](const test::Pair& m) {
            double source = 0, decay = 0;
            Kernel::state_terms(at(m), x, source, decay);
            return MatX(MatX::Constant(1, 1, source - decay * scene.z));
        };
        EXPECT_LT(test::error(test::dense(coupling.rate), test::jacobian(scene.m, z_rate, test::pushed)),
                  1e-8);
        const double z = scene.z;
        const MatX by_state = test::derivative([&](double h) {
            scene.z = z + h;
            return wrench(scene.m);
        });
        scene.z = z;
        EXPECT_LT(test::error(test::dense(coupling.force).transpose(), by_state), 1e-9);
    }
}

TEST(FrictionBatch, Slider) {
    check<Slider>(slider(coulomb(30)));
    check<Slider>(slider(coulomb(0.001)));
    check<Slider>(slider(lugre()));
}

TEST(FrictionBatch, Pin) {
    check<Pin>(pin(coulomb(30)));
    check<Pin>(pin(coulomb(0.001)));
    check<Pin>(pin(lugre()));
}

TEST(FrictionBatch, ReactionsPress) {
    std::mt19937 rng(6);
    FrictionScene scene;
    scene.m = random_pair(rng);
    Pin::Element x = pin(coulomb(0.001));
    x.rows = {0, 1, 2};
    with_scene(scene, [&](const Evaluation& e) { // |(3, -2, 6)| = 7
        Pin::Element given = pin(coulomb(0.001));
        EXPECT_LT((test::dense(Pin::wrench(e, x)) - test::dense(Pin::wrench(e, given))).norm(), 1e-14);
        for (int k = 0; k < 3; ++k) {
            const auto changed = [&](double h) {
                Evaluation other = e;
                const Vec3 lambda = scene.lambda + h * Vec3::Unit(k);
                other.lambda = lambda.data();
                return MatX(-test::dense(Pin::wrench(other, x)));
            };
            EXPECT_LT(
                test::error(test::dense(Pin::by_multiplier(e, x, k)).transpose(), test::derivative(changed)),
                1e-9);
        }
    });
}

TEST(FrictionBatch, PinBrakesWithRadiusTimesForce) {
    Scene scene;
    scene.m[1].w = {0, 0, 5};
    const PairWrench w = Pin::wrench(scene.evaluation(), pin(coulomb(0.001)));
    EXPECT_LT((w.moment_b - Vec3(0, 0, -0.2 * 0.3 * 7)).norm(), 1e-15);
    EXPECT_LT((w.moment_a - Vec3(0, 0, 0.2 * 0.3 * 7)).norm(), 1e-15);
}

TEST(FrictionBatch, SliderIsHeldBackAtItsOwnPoint) {
    Scene scene;
    scene.m[1].v = {2, 0, 0};
    Slider::Element x = slider(coulomb(0.001));
    x.measure = {{0, 0, 1}, {0, 0, 1}, Vec3::UnitX()};
    const PairWrench w = Slider::wrench(scene.evaluation(), x);
    EXPECT_LT((w.force_b - Vec3(-2.1, 0, 0)).norm(), 1e-15);
    EXPECT_LT((w.moment_b - Vec3(0, -2.1, 0)).norm(), 1e-15);
}

// K against differences of the momentum residual in which z follows the velocities.
void check_matrix(const System& system, State state, double speed) {
    std::mt19937 rng(9);
    for (double& u : state.u)
        u = std::uniform_real_distribution<double>(-speed, speed)(rng);
    for (double& l : state.lambda)
        l = std::uniform_real_distribution<double>(-5, 5)(rng);
    const double a = 60;
    Workspace ws = make_workspace(system);
    const Eigen::Index n = system.velocities();
    const VecX beta = VecX::Constant(system.friction_states(), -0.02);
    VecX source = beta, decay = beta;
    const auto residual = [&](const VecX& u, const VecX& lambda) {
        set_motion(system, state.q, u, ws);
        state_terms(system, 0, ws, source, decay);
        ws.z = (source - beta).cwiseQuotient((a + decay.array()).matrix());
        ws.lambda = lambda;
        evaluate_forces(system, 0, ws);
        evaluate_constraints(system, 0, lambda.data(), true, ws);
        return VecX(a * test::dense_mass(system) * u - ws.f);
    };
    residual(state.u, state.lambda);
    linearise(system, 0, state.lambda.data(), ws);
    const SaddleMatrix saddle(system);
    CscMatrix k{saddle.pattern(), std::vector<double>(saddle.pattern().nonzeros())};
    saddle.assemble(system, ws, a, 0.0, k.values);
    const MatX value = test::dense(k);
    MatX truth(n, n + system.row_count());
    for (Eigen::Index j = 0; j < truth.cols(); ++j)
        truth.col(j) = test::derivative(
            [&](double h) {
                VecX u = state.u, lambda = state.lambda;
                (j < n ? u[j] : lambda[j - n]) += h;
                return MatX(residual(u, lambda));
            },
            1e-3);
    EXPECT_LT(test::error(value.topRows(n), truth), 1e-7);
}

TEST(FrictionBatch, StatesInTheMatrix) {
    Model model = build_mechanism("stick-slip");
    std::get<FrictionForce>(model.forces[1]).friction = lugre();
    std::get<FrictionForce>(model.forces[1]).friction.normal_force = 9;
    const System system = test::compiled(std::move(model));
    EXPECT_EQ(system.friction_states(), 1);
    EXPECT_DOUBLE_EQ(system.state_scales[0], 1.0 / 40);
    check_matrix(system, initial_state(system), 2);
}

TEST(FrictionBatch, ReactionsInTheMatrix) {
    Model model = build_mechanism("slider-crank");
    Friction on_pin = lugre();
    on_pin.radius = 0.3;
    test::joint_named(model, "A").friction = {on_pin};
    test::joint_named(model, "D").friction = {coulomb(0.01)};
    const System system = test::compiled(std::move(model));
    EXPECT_TRUE(system.reaction_friction);
    check_matrix(system, initial_state(system), 2);
}

} // namespace
} // namespace gudgeon
