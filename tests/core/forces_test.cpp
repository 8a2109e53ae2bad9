#include "core/forces_applied.hpp"
#include "core/forces_spring_damper.hpp"
#include "core/forces_torsion_spring.hpp"
#include "core/forces_tyre.hpp"
#include "core/user_force.hpp"

#include "core/force_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

// Tabulated spring of a double wishbone corner: tension against elongation, odd.
Table progressive_table() {
    const std::array<double, 10> x{0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 0.14, 0.16, 0.18, 0.20};
    const std::array<double, 10> y{3629.923,  8991.945,   17818.165,  31840.681,  52791.592,
                                   82402.997, 122406.996, 174535.686, 240521.166, 322095.536};
    Table t;
    for (int i = 9; i >= 0; --i) {
        t.x.push_back(-x[i]);
        t.y.push_back(-y[i]);
    }
    t.x.push_back(0);
    t.y.push_back(0);
    for (int i = 0; i < 10; ++i) {
        t.x.push_back(x[i]);
        t.y.push_back(y[i]);
    }
    return t;
}

Scene random_scene(unsigned seed) {
    std::mt19937 rng(seed);
    Scene s;
    s.m = random_pair(rng);
    return s;
}

// a is the ground.
Scene ground_scene(unsigned seed) {
    Scene s = random_scene(seed);
    s.m[0] = BodyMotion{};
    return s;
}

template <class Element> Element between(int a, int b) {
    Element x;
    x.a = a;
    x.b = b;
    return x;
}

// --- spring-damper ---

SpringDamperKernel::Element spring_element(unsigned seed) {
    std::mt19937 rng(seed);
    auto x = between<SpringDamperKernel::Element>(0, 1);
    x.sa = random_vector(rng);
    x.sb = random_vector(rng);
    x.stiffness = 40;
    x.damping = 3;
    x.free_length = 0.8;
    return x;
}

TEST(SpringDamper, DerivativesEnergyAndBalance) {
    for (unsigned seed = 1; seed < 5; ++seed) {
        auto x = spring_element(seed);
        const Scene scene = random_scene(seed + 20);
        check_pair_force<SpringDamperKernel>(scene, x);
        x.damping = 0;
        x.constant = 7;
        check_pair_force<SpringDamperKernel>(scene, x);
    }
}

TEST(SpringDamper, TableAndActuator) {
    auto x = spring_element(6);
    const Scene scene = random_scene(26);
    SpringDamperKernel::Extra extra;
    extra.table = Spline(Table{{-2, 0, 1, 2, 3}, {-10, 0, 8, 30, 90}}, Spline::Ends::linear);
    extra.actuator = HarmonicFunction{12, 0.7, 0.3, 2};
    x.extra = std::make_shared<const SpringDamperKernel::Extra>(extra);
    check_pair_force<SpringDamperKernel>(scene, x);

    extra.table = {};
    x.extra = std::make_shared<const SpringDamperKernel::Extra>(extra);
    check_pair_force<SpringDamperKernel>(scene, x);
}

TEST(SpringDamper, ByHand) {
    Scene scene;
    scene.m[1].r = {0.5, -0.1, 0};
    scene.m[1].v = {2, 5, 0}; // the part across the line does not count
    auto x = between<SpringDamperKernel::Element>(0, 1);
    x.sb = {0, 0.1, 0};
    x.stiffness = 100;
    x.damping = 10;
    x.free_length = 0.3;
    PairWrench w = SpringDamperKernel::wrench(scene.evaluation(), x); // 100 * 0.2 + 10 * 2
    EXPECT_LT((w.force_a - Vec3(40, 0, 0)).norm(), 1e-13);
    EXPECT_LT((w.force_b - Vec3(-40, 0, 0)).norm(), 1e-13);
    EXPECT_LT((w.moment_b - Vec3(0, 0, 4)).norm(), 1e-13);
    EXPECT_LT(w.moment_a.norm(), 1e-13);
    EnergyRates rates = SpringDamperKernel::energies(scene.evaluation(), x);
    EXPECT_NEAR(rates.elastic, 2, 1e-14);
    EXPECT_NEAR(rates.dissipated_power, 40, 1e-13);
    EXPECT_EQ(rates.input_power, 0);

    SpringDamperKernel::Extra extra;
    extra.actuator = RampFunction{5, 10, 0}; // 8 N at t = 0.3
    x.extra = std::make_shared<const SpringDamperKernel::Extra>(extra);
    w = SpringDamperKernel::wrench(scene.evaluation(), x);
    rates = SpringDamperKernel::energies(scene.evaluation(), x);
    EXPECT_NEAR(w.force_b.x(), -48, 1e-13);
    EXPECT_NEAR(rates.input_power, -16, 1e-13); // pulls while the points part
}

TEST(SpringDamper, StaysFiniteAtZeroLength) {
    Scene scene;
    scene.m[1].v = {1, 2, 3};
    auto x = between<SpringDamperKernel::Element>(0, 1);
    x.stiffness = 50;
    x.damping = 2;
    for (const double free_length : {0.0, 0.3}) {
        x.free_length = free_length;
        const Evaluation e = scene.evaluation();
        EXPECT_EQ(dense(SpringDamperKernel::wrench(e, x)).norm(), 0);
        BlockMatrix c = zero_blocks(), s = zero_blocks();
        SpringDamperKernel::linearise(e, x, c, s);
        EXPECT_TRUE(dense(c).allFinite());
        EXPECT_LT((s.block[2][2] - 50 * Mat3::Identity()).norm(), 1e-13);
        EXPECT_LT((s.block[0][2] + 50 * Mat3::Identity()).norm(), 1e-13);
        EXPECT_NEAR(SpringDamperKernel::energies(e, x).elastic, 25 * free_length * free_length, 1e-14);
    }
}

TEST(SpringDamper, ElongationForATension) {
    const Table table = progressive_table();
    EXPECT_NEAR(*elongation_for(table, 17818.165), 0.06, 1e-15);
    EXPECT_NEAR(*elongation_for(table, -3629.923), -0.02, 1e-15);
    EXPECT_NEAR(*elongation_for(table, 0), 0, 1e-15);
    const Spline curve(table, Spline::Ends::linear);
    EXPECT_NEAR(curve(*elongation_for(table, -5000)).value, -5000, 1e-8);
    EXPECT_NEAR(curve(*elongation_for(table, 4e5)).value, 4e5, 1e-8); // beyond the end
    EXPECT_NEAR(*elongation_for(Table{{1, 2}, {10, 30}}, -10), 0, 1e-15);
    EXPECT_FALSE(elongation_for(Table{{0, 1}, {5, 5}}, 6));
}

// --- torsion spring ---

TorsionSpringKernel::Element torsion_element(const Mat3& triad) {
    auto x = between<TorsionSpringKernel::Element>(0, 1);
    x.frames = {triad.col(1), triad.col(0), triad.col(0), triad.col(0)};
    x.stiffness = 30;
    x.damping = 2;
    x.free_angle = 0.4;
    return x;
}

TEST(TorsionSpring, DerivativesEnergyAndBalance) {
    std::mt19937 rng(40);
    for (int trial = 0; trial < 3; ++trial) {
        const Mat3 triad = joint_triad(random_vector(rng));
        Scene scene = random_scene(41 + trial);
        scene.m[1].p = turned(turned(scene.m[0].p, 1.2 * triad.col(2)), 0.05 * triad.col(0));
        scene.m[1].A = rotation(scene.m[1].p);
        scene.angle = 1.2 + 4 * pi; // two turns further on
        auto x = torsion_element(triad);
        check_pair_force<TorsionSpringKernel>(scene, x);
        x.table = std::make_shared<const Spline>(Table{{-1, 0, 10, 13, 15}, {-4, 0, 30, 70, 200}},
                                                 Spline::Ends::linear);
        check_pair_force<TorsionSpringKernel>(scene, x);
    }
}

TEST(TorsionSpring, ByHand) {
    Scene scene;
    scene.m[1].p = turned(scene.m[1].p, Vec3(0, 0, 0.5));
    scene.m[1].A = rotation(scene.m[1].p);
    scene.m[1].w = {0, 0, 3};
    auto x = torsion_element(Mat3::Identity());
    const auto moment = [&] { return TorsionSpringKernel::wrench(scene.evaluation(), x).moment_b.z(); };
    EXPECT_NEAR(moment(), -(30 * 0.1 + 2 * 3), 1e-13);
    EXPECT_NEAR(TorsionSpringKernel::energies(scene.evaluation(), x).elastic, 0.15, 1e-14);
    EXPECT_NEAR(TorsionSpringKernel::energies(scene.evaluation(), x).dissipated_power, 18, 1e-13);
    scene.angle = 2 * pi; // the same pose one turn later
    EXPECT_NEAR(moment(), -(30 * (0.1 + 2 * pi) + 6), 1e-12);
}

// --- tyre ---

TyreElement tyre_element() {
    auto x = between<TyreElement>(0, 1);
    x.stiffness = 900;
    x.damping = 20;
    x.preload = 150;
    x.reference = 0.2;
    x.road = HarmonicFunction{0.1, 0.8, 0.4, 0};
    return x;
}

TEST(Tyre, DerivativesAndEnergy) {
    const auto profile =
        std::make_shared<const Spline>(Table{{-3, -1, 0.5, 4}, {0, 0.2, -0.1, 0.3}}, Spline::Ends::constant);
    for (unsigned seed = 50; seed < 54; ++seed) {
        const Scene scene = ground_scene(seed);
        TyreElement x = tyre_element();
        check_derivatives<TyreKernel<true>>(scene, x);
        check_energy<TyreKernel<true>>(scene, x);
        x.profile = profile;
        check_derivatives<TyreKernel<true>>(scene, x);
        check_energy<TyreKernel<true>>(scene, x);
        x.point = {0.1, -0.3, 0.2};
        check_derivatives<TyreKernel<false>>(scene, x);
        check_energy<TyreKernel<false>>(scene, x);
    }
}

TEST(Tyre, ByHand) {
    Scene scene;
    scene.t = 0;
    scene.m[1].r = {3, 0, 0.35};
    scene.m[1].v = {10, 0, 0.1};
    auto x = between<TyreElement>(0, 1);
    x.stiffness = 2e5;
    x.damping = 200;
    x.preload = 2000;
    x.reference = 0.34;
    x.road = HarmonicFunction{0.02, 2, 0, 0};
    const auto wrench = [&] { return TyreKernel<true>::wrench(scene.evaluation(), x); };
    const double road_rate = 0.02 * 4 * pi;
    EXPECT_NEAR(wrench().force_b.z(), 2000 - 2e5 * 0.01 - 200 * (0.1 - road_rate), 1e-9);
    EXPECT_EQ(wrench().force_b.head<2>().norm(), 0);
    EXPECT_EQ(wrench().moment_b.norm(), 0);

    // A slope of 1/100 driven over at 10 m/s; at x = 3 it is 0.03 m high.
    x.road.reset();
    x.profile = std::make_shared<const Spline>(Table{{-100, 100}, {-1, 1}}, Spline::Ends::linear);
    EXPECT_NEAR(wrench().force_b.z(), 2000 - 2e5 * (0.01 - 0.03) - 200 * (0.1 - 0.1), 1e-9);
    x.point = {0, 0.5, 0};
    EXPECT_NEAR(TyreKernel<false>::wrench(scene.evaluation(), x).moment_b.x(), 0.5 * 6000, 1e-9);

    // Bilateral: it pulls when the wheel is lifted.
    scene.m[1].r.z() = 1;
    EXPECT_LT(wrench().force_b.z(), 0);
}

// --- applied forces ---

template <bool follows> void check_applied(unsigned seed) {
    const Scene scene = ground_scene(seed);
    auto x = between<AppliedElement>(0, 1);
    x.point = {0.2, -0.5, 0.3};
    x.force = {3, -7, 5};
    x.time = HarmonicFunction{2, 1.1, 0.2, 0.5};
    check_derivatives<AppliedForceKernel<follows>>(scene, x);
    check_energy<AppliedForceKernel<follows>>(scene, x);
    x.torque = {-2, 4, 9};
    check_derivatives<AppliedForceKernel<follows>>(scene, x);
    check_energy<AppliedForceKernel<follows>>(scene, x);
}

TEST(AppliedForce, DerivativesAndEnergy) {
    for (unsigned seed = 60; seed < 63; ++seed) {
        check_applied<false>(seed);
        check_applied<true>(seed);
    }
}

TEST(AppliedForce, ByHand) {
    Scene scene;
    scene.m[1].p = turned(scene.m[1].p, Vec3(0, 0, pi / 2)); // body x along global y
    scene.m[1].A = rotation(scene.m[1].p);
    scene.m[1].v = {0, 0, 2};
    scene.m[1].w = {0, -3, 0};
    auto x = between<AppliedElement>(0, 1);
    x.point = {1, 0, 0};
    x.force = {0, 0, 10};
    x.time = ConstantFunction{0.5};
    const Evaluation e = scene.evaluation();
    PairWrench w = AppliedForceKernel<false>::wrench(e, x);
    EXPECT_LT((w.force_b - Vec3(0, 0, 5)).norm(), 1e-14);
    EXPECT_LT((w.moment_b - Vec3(0, -5, 0)).norm(), 1e-14);
    EXPECT_EQ(w.force_a.norm() + w.moment_a.norm(), 0);
    EXPECT_NEAR(AppliedForceKernel<false>::energies(e, x).input_power, 5 * 2 + 5 * 3, 1e-13);

    x.force = {10, 0, 0};
    w = AppliedForceKernel<false>::wrench(e, x); // global x is minus body y
    EXPECT_LT((w.force_b - Vec3(5, 0, 0)).norm(), 1e-14);
    EXPECT_LT((w.moment_b - Vec3(0, 0, -5)).norm(), 1e-14);
    w = AppliedForceKernel<true>::wrench(e, x); // along body x, through the mass centre
    EXPECT_LT((w.force_b - Vec3(0, 5, 0)).norm(), 1e-14);
    EXPECT_LT(w.moment_b.norm(), 1e-14);

    x.force = {0, 10, 0};
    w = AppliedForceKernel<true>::wrench(e, x); // along body y at body x: turns about body z
    EXPECT_LT((w.force_b - Vec3(-5, 0, 0)).norm(), 1e-14);
    EXPECT_LT((w.moment_b - Vec3(0, 0, 5)).norm(), 1e-14);

    x.force.setZero();
    x.torque = {4, 0, 0};
    EXPECT_LT((AppliedForceKernel<false>::wrench(e, x).moment_b - Vec3(0, -2, 0)).norm(), 1e-14);
    EXPECT_LT((AppliedForceKernel<true>::wrench(e, x).moment_b - Vec3(2, 0, 0)).norm(), 1e-14);
}

// --- user forces ---

// A damped spring between the mass centres and drag on the rotation of b.
void user_law(const UserForceInput& in, UserForceOutput& out) {
    const double k = 20, c = 3, drag = 0.7;
    const Vec3 f = k * (in.b.r - in.a.r) + c * (in.b.v - in.a.v);
    out.wrench.force_a = f;
    out.wrench.force_b = -f;
    out.wrench.moment_b = -drag * in.b.w.norm() * in.b.w;
    out.energies = EnergyRates{0.5 * k * (in.b.r - in.a.r).squaredNorm(),
                               c * (in.b.v - in.a.v).squaredNorm() + drag * std::pow(in.b.w.norm(), 3), 0};
    if (!in.derivatives)
        return;
    out.has_derivatives = true;
    const Mat3 i = Mat3::Identity();
    for (const auto& [row, col, sign] : {std::array{0, 0, 1}, {0, 2, -1}, {2, 0, -1}, {2, 2, 1}}) {
        out.C->block[row][col] = sign * c * i;
        out.S->block[row][col] = sign * k * i;
    }
    const double w = in.b.w.norm();
    out.C->block[3][3] = drag * (w * i + in.b.w * in.b.w.transpose() / w);
}

// Without derivatives and energies: turns with body a, depends on both poses.
void rough_law(const UserForceInput& in, UserForceOutput& out) {
    const Vec3 f = in.a.A * Vec3(1, 2, 3) * std::sin(in.t) + in.b.A.col(0) * in.b.v.squaredNorm();
    out.wrench.force_b = f;
    out.wrench.force_a = -f;
    out.wrench.moment_a = in.a.w.cross(in.a.A.transpose() * f);
}

TEST(UserForce, AnalyticDerivatives) {
    const Scene scene = random_scene(70);
    auto x = between<UserForceKernel::Element>(0, 1);
    x.law = std::make_shared<const UserForceLaw>(user_law);
    check_derivatives<UserForceKernel>(scene, x);
    check_energy<UserForceKernel>(scene, x);
}

TEST(UserForce, NumericalDerivativesAndDefaultPower) {
    const Scene scene = random_scene(71);
    auto x = between<UserForceKernel::Element>(0, 1);
    x.law = std::make_shared<const UserForceLaw>(rough_law);
    check_derivatives<UserForceKernel>(scene, x, 1e-7);
    check_energy<UserForceKernel>(scene, x); // all power is input
    const EnergyRates rates = UserForceKernel::energies(scene.evaluation(), x);
    EXPECT_EQ(rates.elastic, 0);
    EXPECT_EQ(rates.dissipated_power, 0);
}

// --- builders ---

Body simple_body(const std::string& name, const Vec3& position) {
    Body b;
    b.name = name;
    b.mass = 2;
    b.inertia = Vec3(0.1, 0.1, 0.1).asDiagonal();
    b.position = position;
    return b;
}

// Forces on the bodies of a model in its start pose.
VecX start_forces(const Model& model, std::vector<ForceBatchBuilder> builders = core_force_builders(),
                  double t = 0) {
    const System system = compile(model, builders);
    const std::vector<double> angle(system.angles.size(), 0.0);
    Evaluation e;
    e.t = t;
    e.body = system.start.data();
    e.moving = system.moving;
    e.angle = e.angle_rate = angle.data();
    VecX f = VecX::Zero(system.velocities());
    for (const auto& batch : system.forces)
        batch->add_forces(e, {f.data(), system.moving});
    return f;
}

Model turned_body_model() {
    Model m;
    m.bodies.push_back(simple_body("arm", {1, 0, 0}));
    m.bodies[0].orientation = turned(Vec4(1, 0, 0, 0), Vec3(0, 0, pi / 2)); // body x along global y
    return m;
}

TEST(ForceBuilders, SpringPointsAreGlobalUnlessSaidOtherwise) {
    Model m = turned_body_model();
    SpringDamper s;
    s.name = "s";
    s.bodies = {"ground", "arm"};
    s.points = {Vec3(0, 2, 0), Vec3(1, 2, 0)};
    s.stiffness = 10;
    s.free_length = 0.5;
    m.forces = {s};
    VecX truth(6);
    truth << -5, 0, 0, 0, 0, 10; // arm (0, 2, 0) x (-5, 0, 0)
    EXPECT_LT((start_forces(m) - truth).norm(), 1e-13);
    s.body_frame = true;
    s.points[1] = Vec3(2, 0, 0); // the same point
    m.forces = {s};
    EXPECT_LT((start_forces(m) - truth).norm(), 1e-13);
}

TEST(ForceBuilders, SpringPreloadIsTheTensionAtTheStart) {
    Model m = turned_body_model();
    SpringDamper s;
    s.name = "s";
    s.bodies = {"ground", "arm"};
    s.points = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
    s.stiffness = 1.2e5;
    m.forces = {s};
    EXPECT_LT(start_forces(m).norm(), 1e-12); // free length: as given
    s.preload = -3400;
    m.forces = {s};
    EXPECT_NEAR(start_forces(m)[0], 3400, 1e-8);
    s.stiffness = 0;
    m.forces = {s};
    EXPECT_NEAR(start_forces(m)[0], 3400, 1e-10);
    s.table = progressive_table();
    m.forces = {s};
    EXPECT_NEAR(start_forces(m)[0], 3400, 1e-8);
}

TEST(ForceBuilders, TorsionSpringActsOnTheJointsAngle) {
    Model m = turned_body_model();
    Joint j;
    j.name = "hinge";
    j.kind = JointKind::revolute;
    j.bodies = {"ground", "arm"};
    j.axes = {Vec3::UnitZ(), Vec3::UnitZ()};
    m.joints = {j};
    TorsionSpring s;
    s.name = "s";
    s.joint = "hinge";
    s.stiffness = 8;
    s.free_angle = 0.25; // the angle is zero in the pose as given
    m.forces = {s};
    EXPECT_NEAR(start_forces(m)[5], 2, 1e-13);
}

TEST(ForceBuilders, TyreReferenceIsTheHeightAsGiven) {
    Model m = turned_body_model();
    m.bodies[0].position.z() = 0.34;
    Tyre t;
    t.name = "tyre";
    t.body = "arm";
    t.point = m.bodies[0].position;
    t.stiffness = 2e5;
    t.preload = 239 * 9.81;
    t.road = HarmonicFunction{0.02, 2, -0.5, 0};
    m.forces = {t};
    EXPECT_NEAR(start_forces(m)[2], 239 * 9.81 + 2e5 * 0.02 * std::sin(-0.5), 1e-9);
    EXPECT_EQ(start_forces(m).tail<3>().norm(), 0);
    t.point += Vec3(0, 0.1, 0.2);
    t.reference = 0.5;
    t.road.reset();
    m.forces = {t};
    const double force = 239 * 9.81 - 2e5 * (0.54 - 0.5);
    const VecX f = start_forces(m);
    EXPECT_NEAR(f[2], force, 1e-9);
    EXPECT_NEAR(f[4], -0.1 * force, 1e-9); // arm along body x
}

TEST(ForceBuilders, AppliedForcesAndTorques) {
    Model m = turned_body_model();
    AppliedForce f;
    f.name = "f";
    f.body = "arm";
    f.point = {1, 2, 0};
    f.vector = {3, 0, 0};
    f.time = RampFunction{0, 2, 0};
    AppliedForce torque;
    torque.name = "torque";
    torque.body = "arm";
    torque.torque = true;
    torque.follows = true;
    torque.vector = {0, 0, 1};
    m.forces = {f, torque};
    VecX truth(6);
    truth << 6, 0, 0, 0, 0, -12 + 1;
    EXPECT_LT((start_forces(m, core_force_builders(), 1.0) - truth).norm(), 1e-13);
}

TEST(ForceBuilders, UserForces) {
    const Model m = turned_body_model();
    const UserForceLaw push = [](const UserForceInput& in, UserForceOutput& out) {
        out.wrench.force_b = in.b.r - in.a.r;
    };
    VecX truth(6);
    truth << 1, 0, 0, 0, 0, 0;
    EXPECT_LT((start_forces(m, {user_force_builder({{"push", {"ground", "arm"}, push}})}) - truth).norm(),
              1e-15);
    EXPECT_THROW(compile(m, {user_force_builder({{"push", {"ground", "leg"}, push}})}), ModelError);
    EXPECT_THROW(compile(m, {user_force_builder({{"push", {"ground", "arm"}, nullptr}})}), ModelError);
}

// Elements are spread over the bodies by colour; the sums keep their order for any number of threads.
TEST(ForceBatches, SameBitsForAnyNumberOfThreads) {
    Model m;
    std::mt19937 rng(80);
    const int bodies = 400;
    for (int i = 0; i < bodies; ++i)
        m.bodies.push_back(simple_body("b" + std::to_string(i), random_vector(rng, 5)));
    std::uniform_int_distribution<int> any(0, bodies - 1);
    for (int i = 0; i < 3000; ++i) {
        SpringDamper s;
        s.name = "s" + std::to_string(i);
        const int a = any(rng);
        s.bodies = {m.bodies[a].name, i % 10 == 0 ? "ground" : m.bodies[(a + 1 + i % 7) % bodies].name};
        s.points = {random_vector(rng, 5), random_vector(rng, 5)};
        s.stiffness = 100;
        s.free_length = 1;
        m.forces.push_back(s);
    }
    const System system = compile(m, core_force_builders());
    VecX f[2];
    std::vector<double> s[2];
    for (const int threads : {1, 2}) {
        Evaluation e;
        e.body = system.start.data();
        e.moving = system.moving;
        e.threads = threads;
        VecX& out = f[threads - 1];
        out = VecX::Zero(system.velocities());
        Linearisation lin;
        lin.C.assign(9 * static_cast<std::size_t>(system.layout.blocks()), 0.0);
        lin.S = lin.C;
        lin.pairs = system.layout.pairs;
        for (const auto& batch : system.forces) {
            batch->add_forces(e, {out.data(), system.moving});
            batch->add_linearisation(e, lin);
        }
        s[threads - 1] = lin.S;
    }
    EXPECT_GT(f[0].norm(), 1);
    EXPECT_EQ(f[0], f[1]);
    EXPECT_EQ(s[0], s[1]);
}

} // namespace
} // namespace gudgeon
