#include "contact/bushing.hpp"

#include "contact/standard_forces.hpp"
#include "core/force_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

Vec6 vec6(double a, double b, double c, double d, double e, double f) {
    Vec6 v;
    v << a, b, c, d, e, f;
    return v;
}

// Two bodies whose joint frames are theta and d apart.
template <class Element>
Scene scene_apart(std::mt19937& rng, const Element& x, const Vec3& d, const Vec3& theta) {
    Scene s;
    s.m = random_pair(rng);
    BodyMotion &a = s.m[0], &b = s.m[1];
    const Mat3 frame = a.A * x.axes_a;
    b.p = euler_parameters(frame * rotation(turned(Vec4(1, 0, 0, 0), theta)) * x.axes_b.transpose());
    b.A = rotation(b.p);
    b.r = point_position(a, x.sa) + frame * d - b.A * x.sb;
    return s;
}

template <class Element> void random_geometry(std::mt19937& rng, Element& x) {
    x.a = 0;
    x.b = 1;
    x.sa = random_vector(rng);
    x.sb = random_vector(rng);
    x.qa = random_orientation(rng);
    x.qb = random_orientation(rng);
    x.axes_a = rotation(x.qa);
    x.axes_b = rotation(x.qb);
}

const std::array<double, 6> angles{0.0, 1e-9, 1e-3, 0.49, 0.51, 2.9};

TEST(Bushing, DerivativesEnergyAndBalance) {
    std::mt19937 rng(1);
    for (const double size : angles) {
        SCOPED_TRACE(size);
        LinearBushing::Element x;
        random_geometry(rng, x);
        x.elasticity.stiffness = vec6(30, 50, 80, 7, 11, 4);
        x.damping = vec6(3, 2, 5, 0.7, 0.4, 1.1);
        x.elasticity.preload = vec6(4, -6, 9, 2, -3, 1);
        const Vec3 d = random_vector(rng, 0.5), theta = size * random_vector(rng).normalized();
        check_pair_force<LinearBushing>(scene_apart(rng, x, d, theta), x);
    }
}

TEST(Bushing, TablesOnSomeAxes) {
    std::mt19937 rng(2);
    TabulatedBushing::Element x;
    random_geometry(rng, x);
    x.elasticity.linear.stiffness = vec6(30, 0, 80, 7, 11, 0);
    x.elasticity.linear.preload = vec6(0, 5, 0, 0, 0, -2);
    x.damping = vec6(3, 2, 5, 0.7, 0.4, 1.1);
    std::array<Spline, 6> tables;
    tables[1] = Spline(Table{{-1, -0.2, 0, 0.2, 1}, {-90, -5, 0, 5, 90}}, Spline::Ends::linear);
    tables[5] = Spline(Table{{-2, 0, 1}, {-9, 0, 20}}, Spline::Ends::linear);
    x.elasticity.tables = std::make_shared<const std::array<Spline, 6>>(tables);
    check_pair_force<TabulatedBushing>(scene_apart(rng, x, Vec3(0.1, 0.37, -0.2), Vec3(0.2, -0.5, 0.7)), x);
    check_pair_force<TabulatedBushing>(scene_apart(rng, x, Vec3(0.1, -2, -0.2), Vec3(0.2, -0.5, 1.7)), x);

    // At d = (0.1, 0.2, 0) and no rotation: table 5 + preload 5 along y, 3 along x.
    Scene scene = scene_apart(rng, x, Vec3(0.1, 0.2, 0), Vec3::Zero());
    for (BodyMotion& m : scene.m)
        m.v = m.w = Vec3::Zero();
    const PairWrench w = TabulatedBushing::wrench(scene.evaluation(), x);
    EXPECT_LT(((scene.m[0].A * x.axes_a).transpose() * w.force_b - Vec3(-3, -10, 0)).norm(), 1e-12);
}

// The force acts on both bodies at one point of space, P_b.
TEST(Bushing, DisplacementByHand) {
    LinearBushing::Element x;
    x.a = 0;
    x.b = 1;
    x.sa = {0, 0.4, 0};
    x.sb = {0, -0.1, 0};
    x.elasticity.stiffness.setConstant(5e6);
    x.damping.setConstant(1e3);
    Scene scene;
    scene.m[1].r = {1e-3, 0.5, 0};
    scene.m[1].v = {0, 0, 0.2};
    const Evaluation e = scene.evaluation();
    const PairWrench w = LinearBushing::wrench(e, x);
    EXPECT_LT((w.force_b - Vec3(-5000, 0, -200)).norm(), 1e-9);
    EXPECT_LT((w.force_a - Vec3(5000, 0, 200)).norm(), 1e-9);
    EXPECT_LT((w.moment_b - Vec3(0, -0.1, 0).cross(Vec3(-5000, 0, -200))).norm(), 1e-9);
    EXPECT_LT((w.moment_a - Vec3(1e-3, 0.4, 0).cross(Vec3(5000, 0, 200))).norm(), 1e-9);
    EXPECT_NEAR(LinearBushing::energies(e, x).elastic, 2.5, 1e-12);
    EXPECT_NEAR(LinearBushing::energies(e, x).dissipated_power, 40, 1e-12);
}

TEST(Bushing, RotationByHand) {
    LinearBushing::Element x;
    x.a = 0;
    x.b = 1;
    x.elasticity.stiffness = vec6(0, 0, 0, 100, 1e4, 1e4);
    x.damping = vec6(0, 0, 0, 1, 10, 10);
    Scene scene;
    scene.m[1].p = turned(scene.m[1].p, Vec3(0.8, 0, 0));
    scene.m[1].A = rotation(scene.m[1].p);
    scene.m[1].w = {2, 0, 0};
    const PairWrench w = LinearBushing::wrench(scene.evaluation(), x);
    EXPECT_LT((w.moment_b - Vec3(-82, 0, 0)).norm(), 1e-12);
    EXPECT_LT((w.moment_a - Vec3(82, 0, 0)).norm(), 1e-12);
    EXPECT_NEAR(LinearBushing::energies(scene.evaluation(), x).elastic, 32, 1e-13);
    EXPECT_NEAR(LinearBushing::energies(scene.evaluation(), x).dissipated_power, 4, 1e-13);

    // Isotropic: -k theta along the axis of any turn, in both bodies' components.
    std::mt19937 rng(3);
    x.elasticity.stiffness.setConstant(50);
    x.damping.setZero();
    const Vec3 theta = 2.5 * random_vector(rng).normalized();
    scene = scene_apart(rng, x, Vec3::Zero(), theta);
    const PairWrench iso = LinearBushing::wrench(scene.evaluation(), x);
    EXPECT_LT((iso.moment_b + 50 * theta).norm(), 1e-11);
    EXPECT_LT((iso.moment_a - 50 * theta).norm(), 1e-11);
}

// --- builder ---

Body simple_body(const std::string& name, const Vec3& position, const Vec4& orientation = {1, 0, 0, 0}) {
    Body b;
    b.name = name;
    b.mass = 2;
    b.inertia = Vec3(0.1, 0.1, 0.1).asDiagonal();
    b.position = position;
    b.orientation = orientation;
    return b;
}

Model bushing_model(const Bushing& bushing) {
    Model m;
    const Vec4 tilt = turned(Vec4(1, 0, 0, 0), Vec3(0.3, -0.8, 0.5));
    m.bodies = {simple_body("chassis", {0, 0, 0.28}), simple_body("arm", {0, 0.575, 0.21}, tilt)};
    Joint j;
    j.name = "inner";
    j.kind = JointKind::revolute;
    j.bodies = {"chassis", "arm"};
    j.points = {Vec3(0, 0.4, 0.22), Vec3(0, 0.4, 0.22)};
    j.axes = {Vec3::UnitX(), Vec3::UnitX()};
    j.fidelity = Fidelity::bushing;
    j.bushing = bushing;
    m.joints = {j};
    return m;
}

// Force and moment on the arm about the joint point, global, after a small shift and turn of the arm.
Vec6 arm_load(const Model& model, const Vec3& shift, const Vec3& turn) {
    const System system = compile(model, standard_force_builders());
    std::vector<BodyMotion> motion = system.start;
    const int arm = system.body_index("arm");
    BodyMotion& m = motion[arm];
    const Vec3 lever = m.A.transpose() * (Vec3(0, 0.4, 0.22) - m.r);
    m.p = turned(m.p, m.A.transpose() * turn);
    m.A = rotation(m.p);
    m.r = Vec3(0, 0.4, 0.22) + shift - m.A * lever;
    Evaluation e;
    e.body = motion.data();
    e.moving = system.moving;
    Wrench w[1];
    for (const auto& batch : system.forces)
        batch->add_joint_wrenches(e, w);
    Vec6 out;
    out << w[0].force, m.A * w[0].moment + (m.A * lever).cross(-w[0].force);
    return out;
}

TEST(BushingBuilder, GlobalAxesAreThoseOfThePoseAsGiven) {
    Bushing b;
    b.stiffness = {1e5, 2e5, 3e5, 100, 200, 300};
    b.global_axes = true;
    const Vec6 load = arm_load(bushing_model(b), Vec3(1e-3, 2e-3, 3e-3), Vec3::Zero());
    EXPECT_LT((load - vec6(-100, -400, -900, 0, 0, 0)).norm(), 1e-9);
    EXPECT_NEAR(arm_load(bushing_model(b), Vec3::Zero(), Vec3(0, 0.01, 0))[4], -2, 1e-12);
}

TEST(BushingBuilder, JointAxesAreTransverseTransverseAxial) {
    Bushing b;
    b.stiffness = {1e5, 2e5, 3e5, 100, 200, 300}; // axis X: h = Y, t = Z
    const Vec6 load = arm_load(bushing_model(b), Vec3(1e-3, 2e-3, 3e-3), Vec3::Zero());
    EXPECT_LT((load - vec6(-300, -200, -600, 0, 0, 0)).norm(), 1e-9);
    EXPECT_NEAR(arm_load(bushing_model(b), Vec3::Zero(), Vec3(0.01, 0, 0))[3], -3, 1e-12);
}

TEST(BushingBuilder, PreloadDampingAndTables) {
    Bushing b;
    b.stiffness = {1e5, 1e5, 1e5, 0, 0, 0};
    b.preload = {0, 0, 50, 0, 0, 0};
    b.tables[0] = {{-1e-2, 0, 1e-2}, {-700, 0, 700}};
    b.global_axes = true;
    const Vec6 load = arm_load(bushing_model(b), Vec3(1e-3, 2e-3, 3e-3), Vec3::Zero());
    EXPECT_LT((load - vec6(-70, -200, -350, 0, 0, 0)).norm(), 1e-9);
}

TEST(BushingBuilder, PerfectJointsHaveNone) {
    Model m = bushing_model({});
    m.joints[0].fidelity = Fidelity::perfect;
    m.joints[0].bushing.reset();
    EXPECT_TRUE(compile(m, standard_force_builders()).forces.empty());
}

} // namespace
} // namespace gudgeon
