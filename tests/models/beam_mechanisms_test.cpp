// Ready mechanisms with flexible links: the RSUP linkage and anti-roll bars.
#include "models/builders.hpp"
#include "solvers/redundancy.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/beam_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

TEST(Rsup, DegreesOfFreedom) {
    struct Case {
        const char *coupler, *joint;
        int dof;
    };
    // a beam of five rigid elements has 4 x 6 more; a planar clearance 2, a spatial one 4
    for (const Case& c :
         {Case{"rigid", "perfect", 1}, Case{"rigid", "planar", 3}, Case{"rigid", "spatial", 5},
          Case{"flexible", "perfect", 25}, Case{"flexible", "planar", 27}, Case{"flexible", "spatial", 29}}) {
        const System system = compiled("rsup", {{"coupler", c.coupler}, {"joint", c.joint}});
        State state = initial_state(system);
        EXPECT_TRUE(assemble_start(system, state).ok);
        const RedundancyReport report = find_redundancy(system, state);
        EXPECT_EQ(report.dof, c.dof) << c.coupler << ' ' << c.joint;
        EXPECT_TRUE(report.dependent.empty());
    }
}

// AU's starting vector: crank up, slider at 0.25 m, coupler turned by 60 degrees from the crank's own line.
TEST(Rsup, StartsAtThePapersVector) {
    const Model model = build_mechanism("rsup");
    const auto body = [&](const std::string& name) {
        return *std::ranges::find(model.bodies, name, &Body::name);
    };
    EXPECT_NEAR(body("slider").position.x(), 0.25, 1e-15);
    const Vec3 line = rotation(body("coupler").orientation) * Vec3::UnitX();
    EXPECT_NEAR(line.dot(-body("crank").position.normalized()), std::cos(pi / 3), 1e-15);
    EXPECT_NEAR(line.y(), 0, 1e-15);
    const System flexible = compiled("rsup", {{"coupler", "flexible"}});
    double mass = 0;
    for (int i = 0; i < 5; ++i)
        mass += flexible.mass[flexible.body_index("coupler." + std::to_string(i + 1))];
    EXPECT_NEAR(mass, body("coupler").mass, 1e-14);
    EXPECT_NEAR(mass, 7850 * pi / 4 * 1e-4 * 0.5 / std::sqrt(3.0), 1e-12);
}

TEST(Rsup, TurnsAtNineRadiansPerSecondAndClosesItsLoop) {
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = 1e-7;
    Simulation sim(build_mechanism("rsup"), options);
    const int crank = sim.system().body_index("crank"), slider = sim.system().body_index("slider");
    const double length = 0.5 / std::sqrt(3.0), height = 0.08 - 0.25 / std::sqrt(3.0);
    const double turns = 2 * 2 * pi / 9, end = 4;
    double angle = 0;
    for (const double t : {0.5, 1.1, 1.7, end - turns, end}) {
        ASSERT_TRUE(sim.advance_to(t).ok);
        const Sample& sample = sim.sample();
        const Vec3 pin = 2 * sample.motion[crank].r;
        EXPECT_NEAR(pin.norm(), 0.08, 1e-9);
        EXPECT_NEAR(sample.motion[slider].r.x(),
                    std::sqrt(length * length - pin.y() * pin.y() - std::pow(pin.z() - height, 2)), 1e-8);
        EXPECT_NEAR(sample.balance, 0, 1e-4);
        if (t == end) {
            EXPECT_NEAR((sample.state.angles.value[0] - angle) / turns, 9, 2e-3);
        }
        angle = sample.state.angles.value[0];
    }
}

TEST(Rsup, BooksAreBalancedInEveryCombination) {
    for (const char* coupler : {"rigid", "flexible"})
        for (const char* joint : {"planar", "spatial"})
            for (const char* friction : {"0", "1"}) {
                SCOPED_TRACE(std::string(coupler) + ' ' + joint + ' ' + friction);
                SimulationOptions options;
                options.integrator = "radau";
                options.integration.rtol = options.integration.atol = 1e-7;
                Simulation sim(
                    build_mechanism("rsup", {{"coupler", coupler}, {"joint", joint}, {"friction", friction}}),
                    options);
                ASSERT_TRUE(sim.advance_to(0.12).ok);
                const Sample& sample = sim.sample();
                EXPECT_GT(sample.state.work[2], 1e-6); // lost in the clearance
                EXPECT_NEAR(sample.balance, 0, 0.01 * sample.state.work[2]);
                ASSERT_EQ(sample.contacts.size(), 1u);
            }
}

/// One unit with its chassis held, no tyres and no weight, upward forces (N) on the left and right upright:
/// how far the two rise, and how far the lower arms do where the links of the bar stand.
struct Lift {
    double left, right, pickup_left, pickup_right;
};

Lift lift(const std::string& joints, bool bar, double left, double right) {
    Model model = build_mechanism("suspension-chain", {{"joints", joints}, {"antiroll", bar ? "1" : "0"}});
    model.gravity.setZero();
    model.bodies[0].fixed = true;
    std::erase_if(model.forces, [](const Force& f) { return std::holds_alternative<Tyre>(f); });
    for (Force& force : model.forces)
        if (auto* coil = std::get_if<SpringDamper>(&force); coil && coil->name.starts_with("coil"))
            coil->free_length = (coil->points[1] - coil->points[0]).norm(); // no tension as given
    for (const auto& [side, size] : {std::pair("L", left), std::pair("R", right)}) {
        const std::string upright = std::string("upright0") + side, arm = std::string("lower0") + side;
        const double y = *side == 'L' ? 1 : -1;
        AppliedForce push;
        push.name = std::string("push") + side;
        push.body = upright;
        push.point = {0, 0.8 * y, 0.34};
        push.vector = {0, 0, size};
        model.forces.push_back(push);
        model.markers.push_back(make_marker(std::string("wheel") + side, upright, push.point));
        model.markers.push_back(make_marker(std::string("pickup") + side, arm, {0, 0.55 * y, 0.2114}));
    }
    const System system = compiled(model);
    State state = initial_state(system);
    EXPECT_TRUE(assemble_start(system, state).ok);
    const StaticsReport report = find_equilibrium(system, state);
    EXPECT_TRUE(report.ok) << report.message;
    Workspace ws = make_workspace(system);
    set_motion(system, state.q, state.u, ws);
    std::map<std::string, double> rise;
    for (const MarkerRecord& m : system.markers)
        rise[m.name] = point_position(ws.motion[m.body], m.point).z() -
                       point_position(system.start[m.body], m.point).z();
    return {rise.at("wheelL"), rise.at("wheelR"), rise.at("pickupL"), rise.at("pickupR")};
}

// Opposite wheel heights twist the bar: force of a link over its rise 2 G J/(l a^2), in series with the
// bending between the mounts, the mounts and the links; equal heights turn it freely.
TEST(AntirollBar, StiffensRollAsTwistDoesAndLeavesHeaveAlone) {
    const double d = 0.02, l = 1.1, a = 0.25, overhang = 0.05, half = 0.5;
    const double gj = 2.1e11 / 2.6 * pi * d * d * d * d / 32, ei = 2.1e11 * pi * d * d * d * d / 64;
    const double bending = overhang * overhang * (overhang + half) / (3 * ei);
    const double mounts = std::pow((overhang + half) / half, 2) / 5e6;
    for (const std::string joints : {"bushing", "perfect"}) {
        const double link = joints == "perfect" ? 0 : 1 / 2e7;
        const double bar = 1 / (l * a * a / (2 * gj) + bending + mounts + link);
        const double f = 2; // N
        const Lift without = lift(joints, false, f, -f), with = lift(joints, true, f, -f);
        EXPECT_NEAR(without.left, -without.right, 1e-3 * without.left);
        const double ratio = without.pickup_left / without.left;
        const double rise = f / with.left - f / without.left;
        EXPECT_GT(rise, 0.1 * f / without.left);
        EXPECT_NEAR(rise, bar * ratio * ratio, 0.02 * rise) << joints;
        const Lift heave = lift(joints, false, f, f), heave_with = lift(joints, true, f, f);
        EXPECT_NEAR(heave_with.left, heave.left, 1e-3 * heave.left) << joints;
        EXPECT_NEAR(heave_with.right, heave.right, 1e-3 * heave.right) << joints;
    }
}

TEST(AntirollBar, RunsInEveryVariant) {
    for (const char* joints : {"bushing", "perfect", "clearance", "mixed"}) {
        SimulationOptions options;
        options.integrator = "gear";
        Simulation sim(
            build_mechanism("suspension-chain", {{"units", "2"}, {"joints", joints}, {"antiroll", "1"}}),
            options);
        const StepOutcome outcome = sim.advance_to(0.2);
        EXPECT_TRUE(outcome.ok) << joints << ' ' << outcome.message;
        EXPECT_NEAR(sim.sample().balance, 0, 1e-3 * sim.sample().energies.kinetic + 0.05) << joints;
    }
}

} // namespace
} // namespace gudgeon
