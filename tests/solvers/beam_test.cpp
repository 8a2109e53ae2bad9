// Flexible links against beam theory: loads, large deflections, frequencies, damping, energy.
#include "solvers/simulation.hpp"
#include "tests/solvers/beam_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

constexpr double young = 2.1e11, shear = young / 2.6, density = 7850;
constexpr double h = 0.01, width = 0.02, area = h * width; // of steel_bar()
constexpr double iy = width * h * h * h / 12, iz = h * width * width * width / 12;

/// The bar, or one so thin that nothing but bending and twist remains.
Beam thin_bar(int elements) {
    Beam beam = steel_bar(elements, 1e-3);
    beam.stretch = false;
    return beam;
}
constexpr double thin = 1e-3, thin_area = 2 * thin * thin, thin_iy = 2 * thin * thin * thin * thin / 12;

// Tip flexibility of the divided beam: midpoints of the parts, so the bending term of a force lacks 1/(4
// n^2).
TEST(Beam, SmallLoadsDeflectAsBeamTheorySays) {
    const int n = 3;
    const double bending = (1 - 1.0 / (4 * n * n)) / 3, k = 10 * 1.3 / (12 + 11 * 0.3);
    const double torsion = section_properties(RectangleSection{width, h}, 0.3).torsion;
    struct Case {
        int axis;
        bool torque;
        double shift, turn; // along the force, or across the beam under a torque; about the torque
    };
    const double size = 1e-3; // N, N m
    for (const Case& c :
         {Case{0, false, 1 / (young * area), 0},
          Case{1, false, bending / (young * iz) + 1 / (k * shear * area), 1 / (2 * young * iz)},
          Case{2, false, bending / (young * iy) + 1 / (k * shear * area), 1 / (2 * young * iy)},
          Case{0, true, 0, 1 / (shear * torsion)}, Case{1, true, -1 / (2 * young * iy), 1 / (young * iy)},
          Case{2, true, 1 / (2 * young * iz), 1 / (young * iz)}}) {
        SCOPED_TRACE(testing::Message() << c.axis << ' ' << c.torque);
        const Beam beam = steel_bar(n);
        Model model = clamped(beam);
        model.forces = {load_at_end(beam, size * Vec3::Unit(c.axis), c.torque)};
        const BeamEnd end = end_at_rest(model);
        const int moved = c.torque && c.axis > 0 ? 3 - c.axis : c.axis;
        const double scale = 1 / (young * iy) * size;
        EXPECT_NEAR(end.shift[moved], c.shift * size, 1e-7 * std::max(c.shift * size, 1e-3 * scale));
        const Vec3 turn(end.turn(2, 1), end.turn(0, 2), end.turn(1, 0));
        const int turned = c.torque || c.axis == 0 ? c.axis : 3 - c.axis;
        const double sense = !c.torque && c.axis == 2 ? -1 : 1;
        EXPECT_NEAR(turn[turned], sense * c.turn * size, 1e-7 * std::max(c.turn * size, 1e-3 * scale));
    }
}

TEST(Beam, ShortBeamsShear) {
    Beam beam = steel_bar(40);
    beam.points[1] = {0.03, 0, 0};
    beam.section = RoundSection{0.02};
    Model model = clamped(beam);
    model.forces = {load_at_end(beam, {0, 0, 1}, false)};
    const double d = 0.02, l = 0.03, a = pi * d * d / 4, i = pi * d * d * d * d / 64;
    const double k = 6 * 1.3 / (7 + 6 * 0.3); // Cowper 1966
    const double bent = l * l * l / (3 * young * i), sheared = l / (k * shear * a);
    EXPECT_GT(sheared, 0.2 * bent);
    EXPECT_NEAR(end_at_rest(model).shift.z(), bent + sheared, 2e-4 * bent);
}

TEST(Beam, TipMomentRollsItUp) {
    std::vector<double> error;
    const std::vector<int> n{5, 10, 20, 40};
    for (const int elements : n) {
        const Beam beam = thin_bar(elements);
        Model model = clamped(beam);
        model.forces = {
            load_at_end(beam, {0, -0.75 * pi * young * thin_iy, 0}, true)}; // bends by 135 degrees
        const BeamEnd end = end_at_rest(model);
        const double radius = 1 / (0.75 * pi);
        const Vec3 truth(radius * std::sin(0.75 * pi) - 1, 0, radius * (1 - std::cos(0.75 * pi)));
        EXPECT_NEAR(std::atan2(end.turn(2, 0), end.turn(0, 0)), 0.75 * pi, 1e-8);
        error.push_back((end.shift - truth).norm());
    }
    EXPECT_LT(error.back(), 3e-4);
    EXPECT_NEAR(observed_order(n, error), 2, 0.03);
}

TEST(Beam, TipForceBendsItAsTheElastica) {
    for (const double load : {1.0, 10.0}) {
        const auto [along, across] = elastica_tip(load);
        if (load == 1) {
            EXPECT_NEAR(across, 0.30172, 1e-5); // Mattiasson, Int. J. Num. Meth. Eng. 17 (1981)
            EXPECT_NEAR(1 - along, 0.05643, 1e-5);
        } else {
            EXPECT_NEAR(across, 0.81061, 1e-5);
            EXPECT_NEAR(1 - along, 0.55500, 1e-5);
        }
        std::vector<double> error;
        const std::vector<int> n{5, 10, 20, 40};
        for (const int elements : n) {
            const Beam beam = thin_bar(elements);
            Model model = clamped(beam);
            model.forces = {load_at_end(beam, {0, 0, load * young * thin_iy}, false)};
            const Vec3 shift = end_at_rest(model).shift;
            EXPECT_NEAR(shift.y(), 0, 1e-12);
            error.push_back((shift - Vec3(along - 1, 0, across)).norm());
        }
        EXPECT_LT(error.back(), 5e-4);
        EXPECT_NEAR(observed_order(n, error), 2, 0.05);
    }
}

// A bushing measures displacements in the axes of one side: the beam turned round differs by strain times
// bending only.
TEST(Beam, BothWaysRoundAreTheSame) {
    Beam beam = steel_bar(10, 1e-3);
    Model model = clamped(beam);
    const double load = 10 * young * thin_iy;
    model.forces = {load_at_end(beam, {0, 0, load}, false)};
    const Vec3 there = end_at_rest(model).shift;
    std::swap(beam.points[0], beam.points[1]);
    Model turned = model;
    turned.beams = {beam};
    turned.joints[0].bodies[1] = "rod.end";
    AppliedForce force = load_at_end(beam, {0, 0, load}, false);
    force.body = "rod.start";
    force.point = beam.points[0];
    turned.forces = {force};
    turned.markers = {make_marker("tip", "rod.start", beam.points[0])};
    const System system = compiled(turned);
    State state = initial_state(system);
    ASSERT_TRUE(assemble_start(system, state).ok);
    ASSERT_TRUE(find_equilibrium(system, state).ok);
    Workspace ws = make_workspace(system);
    set_motion(system, state.q, state.u, ws);
    const Vec3 back =
        point_position(ws.motion[system.markers[0].body], system.markers[0].point) - Vec3(1, 0, 0);
    EXPECT_LT((back - there).norm(), 1e-5 * there.norm());
}

std::vector<double> clamped_free(int modes) {
    const std::vector<double> wave{1.875104068711961, 4.694091132974175, 7.854757438237613};
    std::vector<double> out;
    for (int i = 0; i < modes; ++i)
        out.push_back(wave[i] * wave[i] * std::sqrt(young * thin_iy / (density * thin_area)));
    return out;
}

TEST(Beam, FrequenciesClampedFree) {
    const std::vector<double> truth = clamped_free(3);
    const double polar = thin_iy + 4 * thin_iy; // iz = 4 iy
    const double twist = pi / 2 *
                         std::sqrt(shear * section_properties(RectangleSection{2 * thin, thin}, 0.3).torsion /
                                   (density * polar));
    const std::vector<int> n{5, 10, 20};
    std::array<std::vector<double>, 4> error;
    for (const int elements : n) {
        const Model model = clamped(thin_bar(elements));
        const std::vector<double> bending = frequencies(model, 2, thin),
                                  torsion = frequencies(model, 3, thin);
        ASSERT_GE(bending.size(), 3u);
        ASSERT_GE(torsion.size(), 1u);
        for (int i = 0; i < 3; ++i)
            error[i].push_back(bending[i] / truth[i] - 1);
        error[3].push_back(torsion[0] / twist - 1);
    }
    const std::array<double, 4> within{1e-3, 6e-3, 2e-2, 5e-4}; // at n = 20
    for (int i = 0; i < 4; ++i) {
        EXPECT_LT(std::abs(error[i].back()), within[i]) << i;
        EXPECT_NEAR(observed_order(n, error[i]), 2, 0.25) << i;
    }
}

/// With rotary inertia (Rayleigh).
double hinged(int mode) {
    const double wave = mode * pi, slender = wave * wave * thin_iy / thin_area;
    return wave * wave * std::sqrt(young * thin_iy / (density * thin_area) / (1 + slender));
}

TEST(Beam, FrequenciesHingedAtBothEnds) {
    const std::vector<int> n{20, 40};
    std::array<std::vector<double>, 3> error;
    for (const int elements : n) {
        const Beam beam = thin_bar(elements);
        Model model = clamped(beam);
        model.joints = {
            make_joint("left", JointKind::revolute, "ground", "rod.start", beam.points[0], Vec3::UnitY()),
            make_joint("right", JointKind::point_on_axis, "ground", "rod.end", beam.points[1],
                       Vec3::UnitX())};
        const std::vector<double> bending = frequencies(model, 2, thin);
        ASSERT_GE(bending.size(), 3u);
        for (int i = 0; i < 3; ++i)
            error[i].push_back(bending[i] / hinged(i + 1) - 1);
    }
    const std::array<double, 3> within{1e-7, 1e-6, 5e-6}; // at n = 40
    for (int i = 0; i < 3; ++i) {
        EXPECT_LT(std::abs(error[i].back()), within[i]) << i;
        EXPECT_NEAR(observed_order(n, error[i]), 4, 0.2) << i; // the ends carry no moment
    }
}

// With a loss factor every vibration of the frequency w has the damping ratio loss/2 w/(2 pi f).
TEST(Beam, DampingRatioFollowsTheLossFactor) {
    for (const bool given : {false, true}) {
        Beam beam = thin_bar(10);
        beam.material.loss = 0.04;
        if (given)
            beam.material.frequency = 2.5;
        Model model = clamped(beam);
        const System system = compiled(model);
        State state = initial_state(system);
        ASSERT_TRUE(assemble_start(system, state).ok);
        const double first = pi * pi * std::sqrt(young * thin_iy / (density * thin_area)); // hinged, slender
        const double reference = given ? 2 * pi * 2.5 : first;
        int seen = 0;
        for (const Mode& mode : find_modes(system, state).modes)
            if (mode.kind == Mode::Kind::vibration && ++seen <= 4) {
                EXPECT_NEAR(mode.damping(), 0.02 * mode.omega() / reference, 1e-6 * mode.damping() + 1e-9);
            }
        EXPECT_GE(seen, 4);
    }
}

// Turned and moved as a whole, in a rigid motion: no elastic energy, no damping, no force in any element.
TEST(Beam, RigidMotionIsFreeOfStrain) {
    Beam beam = steel_bar(6);
    beam.material.loss = 0.1;
    beam.direction = Vec3(0.3, -1, 2);
    beam.points = {Vec3(1, 2, 3), Vec3(1.4, 2.5, 2.1)};
    Model model;
    model.gravity.setZero();
    model.beams = {beam};
    const System system = compiled(model);
    State state = initial_state(system);
    const Mat3 turn(Eigen::AngleAxisd(2.9, Vec3(1, -2, 0.5).normalized()));
    const Vec3 spin(30, -20, 50); // global
    std::vector<Vec3> force(system.moving);
    for (int i = 0; i < system.moving; ++i) {
        const BodyMotion& m = system.start[i];
        const Vec3 r = turn * m.r + Vec3(5, 6, 7);
        const Mat3 A = turn * m.A;
        state.q.segment<3>(7 * i) = r;
        const Eigen::Quaterniond q(A);
        state.q.segment<4>(7 * i + 3) << q.w(), q.x(), q.y(), q.z();
        state.u.segment<3>(6 * i) = spin.cross(r);
        state.u.segment<3>(6 * i + 3) = A.transpose() * spin;
    }
    Workspace ws = make_workspace(system);
    set_motion(system, state.q, state.u, ws);
    EXPECT_LT(energies(system, 0, nullptr, ws).elastic, 1e-15);
    evaluate_forces(system, 0, ws);
    const double round_off = 1e-14 * 10 * element_stiffness(beam).displacement.x();
    for (int i = 0; i < system.moving; ++i)
        EXPECT_LT(ws.f.segment<3>(6 * i).norm(), round_off) << i;
}

TEST(Beam, FreeVibrationKeepsItsEnergyInTheBooks) {
    Beam beam = steel_bar(8);
    beam.material.loss = 0.05;
    beam.points[1] = {0.6, 0, 0.8};
    Model model = clamped(beam);
    model.gravity = {0, 0, -9.81};
    AppliedForce push = load_at_end(beam, {30, 40, 0}, false);
    push.time = SmoothStepFunction{0, 0.05, 1, 0};
    model.forces = {push};
    for (const char* integrator : {"gear", "radau"}) {
        SimulationOptions options;
        options.integrator = integrator;
        options.start = Start::equilibrium;
        options.integration.rtol = options.integration.atol = 1e-8;
        Simulation sim(model, options);
        const double before = sim.sample().energies.elastic;
        const StepOutcome outcome = sim.advance_to(0.4);
        ASSERT_TRUE(outcome.ok) << outcome.message;
        const Sample& sample = sim.sample();
        EXPECT_GT(sample.state.dissipated(), 0.1 * before) << integrator;
        EXPECT_NEAR(sample.balance, 0, 1e-5 * before) << integrator;
    }
}

// A spinning free beam keeps its momentum, its angular momentum and, without loss, its energy.
TEST(Beam, FreeBeamSpinsOn) {
    Beam beam = steel_bar(4, 0.005);
    beam.velocity = {1, 2, 3};
    beam.angular_velocity = {5, 20, -30};
    Model model;
    model.gravity.setZero();
    model.beams = {beam};
    SimulationOptions options;
    options.integrator = "radau";
    options.integration.rtol = options.integration.atol = 1e-9;
    Simulation sim(model, options);
    const auto momenta = [&](const Sample& s) {
        Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
        for (int i = 0; i < sim.system().moving; ++i) {
            const BodyMotion& m = s.motion[i];
            linear += sim.system().mass[i] * m.v;
            angular += sim.system().mass[i] * m.r.cross(m.v) + m.A * (sim.system().inertia[i] * m.w);
        }
        return std::pair(linear, angular);
    };
    const auto [linear, angular] = momenta(sim.sample());
    const double kinetic = sim.sample().energies.kinetic;
    ASSERT_TRUE(sim.advance_to(0.3).ok); // more than a turn
    const auto [linear_after, angular_after] = momenta(sim.sample());
    EXPECT_LT((linear_after - linear).norm(), 1e-7 * linear.norm());
    EXPECT_LT((angular_after - angular).norm(), 1e-6 * angular.norm());
    EXPECT_NEAR(sim.sample().balance, 0, 1e-6 * kinetic);
    EXPECT_GT(sim.sample().energies.elastic, 0);
}

} // namespace
} // namespace gudgeon
