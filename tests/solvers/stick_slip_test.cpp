// Friction over time: stick-slip against an independent solution, sticking on a slope, bearings that brake.
#include "solvers/simulation.hpp"
#include "tests/solvers/reference_table.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <array>

namespace gudgeon {
namespace {

SimulationOptions options(const std::string& integrator, double tol, double step = 0) {
    SimulationOptions out;
    out.integrator = integrator;
    out.integration.rtol = out.integration.atol = tol;
    out.integration.step = step;
    return out;
}

/// Turning points (t, x) of the block: roots of its speed on the dense output.
std::vector<std::array<double, 2>> turning_points(Simulation& sim, double end) {
    std::vector<std::array<double, 2>> found;
    Integrator& integrator = sim.integrator();
    State at;
    double t_before = 0, v_before = 0;
    while (integrator.state().t < end) {
        const StepOutcome outcome = integrator.advance(end);
        EXPECT_TRUE(outcome.ok) << outcome.message;
        if (!outcome.ok)
            break;
        const double t = integrator.state().t, v = integrator.state().u[0];
        if (v * v_before < 0) {
            double low = t_before, high = t;
            for (int i = 0; i < 60; ++i) {
                const double middle = 0.5 * (low + high);
                integrator.interpolate(middle, at);
                (at.u[0] * v_before > 0 ? low : high) = middle;
            }
            found.push_back({high, at.q[0]});
        }
        t_before = t;
        v_before = v;
    }
    return found;
}

// Bounds of gear's balance: the worst of tolerances within a factor of two, which scatter by as much as six.
struct Case {
    std::string integrator;
    double tol, step, time_error, place_error, balance;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.integrator << " at " << c.tol; }

class StickSlip : public testing::TestWithParam<Case> {};

TEST_P(StickSlip, MeetsTheReference) {
    const Case& c = GetParam();
    const testing_data::ReferenceTable table("r6_lugre_extrema.csv");
    Simulation sim(build_mechanism("stick-slip"), options(c.integrator, c.tol, c.step));
    const double end = c.integrator == "rk4" ? 8 : 40;
    const auto found = turning_points(sim, end);
    const std::size_t expected = c.integrator == "rk4" ? 1 : table.rows() - 1; // the first row is the start
    ASSERT_EQ(found.size(), expected);
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i][0], table["t"][i + 1], c.time_error);
        EXPECT_NEAR(found[i][1], table["x"][i + 1], c.place_error);
    }
    EXPECT_LT(std::abs(sim.sample_at(end).balance), c.balance);
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, StickSlip,
    testing::Values(Case{"radau", 1e-6, 0, 1e-3, 2e-5, 1e-6}, Case{"radau", 1e-8, 0, 1e-5, 3e-7, 3e-9},
                    Case{"gear", 1e-6, 0, 2e-2, 3e-4, 2e-4}, Case{"gear", 1e-8, 0, 4e-4, 5e-6, 2e-6},
                    Case{"ida", 1e-6, 0, 3e-2, 6e-4, 3e-4}, Case{"ida", 1e-8, 0, 5e-4, 8e-6, 2e-6},
                    // the bristles' rate, 1e4/s in slip, bounds its step
                    Case{"rk4", 1e-6, 5e-5, 1e-7, 1e-9, 1e-7}),
    [](const auto& info) { return info.param.integrator + (info.param.tol > 1e-7 ? "6" : "8"); });

TEST(StickSlipModel, IsTheOneOfThePaper) {
    const Model model = build_mechanism("stick-slip");
    EXPECT_EQ(model.bodies[0].name, "block");
    EXPECT_EQ(model.bodies[0].mass, 1);
    EXPECT_EQ(model.bodies[0].velocity, Vec3::Zero());
    EXPECT_EQ(model.bodies[1].name, "belt");
    Simulation sim(model, options("radau", 1e-6));
    EXPECT_EQ(sim.system().friction_states(), 1);
    EXPECT_DOUBLE_EQ(sim.system().state_scales[0], 1e-5);
    // at the start 0.1 m/s of slip with straight bristles: sigma1 v + sigma2 v pull the block along
    EXPECT_NEAR(sim.sample().acceleration[0], (std::sqrt(1e5) + 0.4) * 0.1, 1e-10);
    EXPECT_NEAR(sim.sample().energies.elastic, 0, 1e-15);
    ASSERT_TRUE(sim.advance_to(2).ok);
    EXPECT_NEAR(sim.sample().motion[1].r.x(), 0.2, 1e-12);
}

// An explicit step too long for the bristles is told, not taken.
TEST(StickSlipModel, IsTooFastForALongExplicitStep) {
    Simulation sim(build_mechanism("stick-slip"), options("rk4", 1e-6, 1e-3));
    const StepOutcome outcome = sim.advance_to(40);
    EXPECT_FALSE(outcome.ok);
    EXPECT_NE(outcome.message.find("bristles"), std::string::npos) << outcome.message;
}

// A saved state holds the bristles: the run goes on as it would have.
TEST(StickSlipModel, GoesOnFromASavedState) {
    for (const char* integrator : {"radau", "gear", "ida"}) {
        SCOPED_TRACE(integrator);
        Simulation whole(build_mechanism("stick-slip"), options(integrator, 1e-9)),
            second(build_mechanism("stick-slip"), options(integrator, 1e-9));
        ASSERT_TRUE(whole.advance_to(5).ok); // sticking
        const State saved = whole.state();
        // the block moves with the belt; its bristles hold the spring and bend on: sigma0 z + sigma1 z' = -k
        // x
        EXPECT_NEAR(saved.z[0], (-2 * saved.q[0] + std::sqrt(1e5) * 2e-6) / 1e5, 1e-10);
        second.restore(saved);
        ASSERT_TRUE(whole.advance_to(9).ok);
        ASSERT_TRUE(second.advance_to(9).ok);
        EXPECT_NEAR(second.sample().motion[0].r.x(), whole.sample().motion[0].r.x(), 1e-6);
        EXPECT_NEAR(second.state().z[0], whole.state().z[0], 1e-10);
    }
}

// Interpolated bristles obey their own equation.
TEST(StickSlipModel, BristlesBetweenSteps) {
    for (const char* integrator : {"radau", "gear", "ida"}) {
        SCOPED_TRACE(integrator);
        const System system = test::compiled("stick-slip");
        Workspace ws = make_workspace(system);
        Simulation sim(build_mechanism("stick-slip"), options(integrator, 1e-8));
        ASSERT_TRUE(sim.advance_past(6, 40).ok);
        const double t1 = sim.integrator().state().t, h = 1e-4;
        State before, at, after;
        VecX source(1), decay(1);
        sim.integrator().interpolate(t1 - 2 * h, before);
        sim.integrator().interpolate(t1 - h, at);
        sim.integrator().interpolate(t1, after);
        set_motion(system, at.q, at.u, ws);
        state_terms(system, at.t, ws, source, decay);
        const double rate = source[0] - decay[0] * at.z[0];
        EXPECT_NEAR((after.z[0] - before.z[0]) / (2 * h), rate, 2e-3 * 2e-6) << rate;
    }
}

/// 1 kg on a slope of `angle` along X, pressed by its own weight.
Model slope(double angle, const Friction& law) {
    Model model;
    model.gravity = 9.81 * Vec3(std::sin(angle), 0, -std::cos(angle));
    Body block;
    block.name = "block";
    block.mass = 1;
    block.inertia = 1e-3 * Mat3::Identity();
    model.bodies = {block};
    Joint guide;
    guide.name = "guide";
    guide.kind = JointKind::translation;
    guide.bodies = {"ground", "block"};
    guide.axes = {Vec3::UnitX(), Vec3::UnitX()};
    guide.friction = {law};
    model.joints = {guide};
    return model;
}

Friction lugre() {
    Friction friction;
    friction.kind = "lugre";
    friction.kinetic = 0.3;
    friction.statics = 0.4;
    friction.speed = 0.01;
    friction.sigma0 = 1e5;
    friction.sigma1 = 300;
    return friction;
}

// Below the friction angle the block goes as far as its bristles bend, and stays.
TEST(Slope, StickingHolds) {
    const double angle = std::atan(0.15);
    for (const bool given : {true, false})
        for (const char* integrator : {"radau", "gear", "ida"})
            for (const double tol : {1e-4, 1e-6, 1e-8}) {
                SCOPED_TRACE(testing::Message()
                             << integrator << " " << tol << (given ? " given" : " reaction"));
                Friction law = lugre();
                const double pressed = 9.81 * std::cos(angle), force = 9.81 * std::sin(angle);
                if (given)
                    law.normal_force = pressed;
                Simulation sim(slope(angle, law), options(integrator, tol));
                const double bound = force / (1e5 * pressed); // 1.5e-6 m
                ASSERT_TRUE(sim.advance_to(0.5).ok);
                const double early = sim.sample().motion[0].r.x();
                ASSERT_TRUE(sim.advance_to(10.5).ok);
                const double late = sim.sample().motion[0].r.x();
                EXPECT_GT(early, 0.9 * bound);
                EXPECT_LT(early, 1.5 * bound); // the start overshoots, slipping a little
                EXPECT_LT(late - early, bound);
            }
}

// Above it the block slides with g (sin - mu cos).
TEST(Slope, SlidingAccelerates) {
    const double angle = 0.5, a = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
    for (const char* integrator : {"radau", "gear", "ida", "rk4"}) {
        SCOPED_TRACE(integrator);
        Friction law;
        law.kinetic = 0.3;
        law.speed = 1e-3;
        Simulation sim(slope(angle, law), options(integrator, 1e-8));
        ASSERT_TRUE(sim.advance_to(1).ok);
        const Sample& sample = sim.sample();
        // the regularised start brings it forward by less than the time below the threshold
        EXPECT_NEAR(sample.motion[0].v.x(), a, 1e-3);
        EXPECT_NEAR(sample.acceleration[0], a, 1e-9);
        EXPECT_NEAR(sample.state.dissipated(), 0.3 * 9.81 * std::cos(angle) * sample.motion[0].r.x(), 2e-3);
        EXPECT_LT(std::abs(sample.balance), 2e-6);
    }
}

/// A rod's end on a pin of radius R through the origin, about Y; mass centre at l.
struct RubbingPendulum {
    static constexpr double m = 2, l = 0.5, inertia = 0.1, radius = 0.05, mu = 0.3, speed = 0.02, g = 9.81;

    static Model model() {
        Model out;
        Body body;
        body.name = "bob";
        body.mass = m;
        body.inertia = inertia * Mat3::Identity();
        body.position = {l, 0, 0};
        out.bodies = {body};
        Joint pin;
        pin.name = "pin";
        pin.kind = JointKind::revolute;
        pin.bodies = {"ground", "bob"};
        pin.axes = {Vec3::UnitY(), Vec3::UnitY()};
        Friction law;
        law.kind = "coulomb-smooth";
        law.kinetic = mu;
        law.speed = speed;
        law.radius = radius;
        pin.friction = {law};
        out.joints = {pin};
        return out;
    }

    /// theta from the downward vertical; force of the pin along and across the rod.
    static double acceleration(double theta, double rate) {
        const double s = std::min(1.0, std::abs(radius * rate) / speed);
        const double coefficient = std::copysign(mu * (1.5 * s - 0.5 * s * s * s), rate);
        double a = 0;
        for (int i = 0; i < 60; ++i) {
            const double along = m * (g * std::cos(theta) + l * rate * rate),
                         across = m * (g * std::sin(theta) + l * a);
            a = (-m * g * l * std::sin(theta) - radius * coefficient * std::hypot(along, across)) /
                (inertia + m * l * l);
        }
        return a;
    }

    /// Angle at t from rest at the horizontal, by a classical Runge-Kutta method of its own.
    static double angle(double end, int steps) {
        double theta = pi / 2, w = 0;
        const double h = end / steps;
        for (int i = 0; i < steps; ++i) {
            const double a1 = acceleration(theta, w), w2 = w + 0.5 * h * a1,
                         a2 = acceleration(theta + 0.5 * h * w, w2), w3 = w + 0.5 * h * a2,
                         a3 = acceleration(theta + 0.5 * h * w2, w3), w4 = w + h * a3,
                         a4 = acceleration(theta + h * w3, w4);
            theta += h / 6 * (w + 2 * w2 + 2 * w3 + w4);
            w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        }
        return theta;
    }
};

TEST(RubbingPin, PendulumAgainstItsOwnIntegration) {
    const double end = 3, truth = RubbingPendulum::angle(end, 30000);
    EXPECT_NEAR(truth, RubbingPendulum::angle(end, 15000), 1e-9);
    struct Run {
        const char* integrator;
        double tol, step, error;
    };
    for (const Run& run : {Run{"radau", 1e-8, 0, 1e-6}, Run{"gear", 1e-8, 0, 5e-6}, Run{"ida", 1e-8, 0, 5e-6},
                           Run{"rk4", 1e-8, 1e-3, 1e-6}}) {
        SCOPED_TRACE(run.integrator);
        Simulation sim(RubbingPendulum::model(), options(run.integrator, run.tol, run.step));
        ASSERT_TRUE(sim.advance_to(end).ok);
        const Sample& sample = sim.sample();
        const Vec3 r = sample.motion[0].r;
        EXPECT_NEAR(std::atan2(r.x(), -r.z()), truth, run.error);
        EXPECT_LT(std::abs(sample.balance), 1e-5);
    }
}

/// A heavy shaft that spins in a bearing along X, resting where friction has rolled it up its wall.
Model spinning_shaft(const Friction& law, const std::string& gap) {
    constexpr double radial = 1e-3, radius = 0.02, mu = 0.2, stiffness = 1e7;
    Model model;
    Body shaft;
    shaft.name = "shaft";
    shaft.mass = 1;
    shaft.inertia = Vec3(2e-3, 1e-3, 1e-3).asDiagonal();
    const double phi = std::atan(mu), depth = 9.81 * std::cos(phi) / stiffness;
    // spinning about +X its lowest point runs along +Y: friction pushes along -Y, and there the shaft rests
    shaft.position = (radial + depth) * Vec3(0, -std::sin(phi), -std::cos(phi));
    shaft.angular_velocity = {100, 0, 0};
    model.bodies = {shaft};
    Joint joint;
    joint.name = "bearing";
    joint.kind = JointKind::cylindrical;
    joint.bodies = {"ground", "shaft"};
    joint.points[1] = shaft.position;
    joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
    joint.fidelity = Fidelity::clearance;
    // kept parallel: free to tilt, the shaft would whirl in the end
    joint.motions[static_cast<std::size_t>(Motion::misalignment)] = Fidelity::perfect;
    Clearance clearance;
    clearance.model = gap;
    clearance.radial = radial;
    clearance.radius = radius;
    if (gap != "planar")
        clearance.length = 0.04;
    clearance.strips = 4;
    clearance.law.kind = "linear";
    clearance.law.stiffness = stiffness;
    clearance.law.damping = 2e3;
    clearance.friction = law;
    joint.clearance = clearance;
    model.joints = {joint};
    return model;
}

// Torque mu N R with N = m g / sqrt(1 + mu^2).
TEST(RubbingBearing, SpinFallsAsByHand) {
    Friction coulomb;
    coulomb.kinetic = 0.2;
    coulomb.speed = 1e-2;
    Friction bristles;
    bristles.kind = "lugre";
    bristles.kinetic = 0.2;
    bristles.sigma0 = 1e4;
    bristles.sigma1 = 10;
    const double brake = 0.2 * 9.81 / std::sqrt(1.04) * 0.019 / 2e-3;
    for (const char* gap : {"strips", "planar", "two-end"})
        for (const Friction& law : {coulomb, bristles})
            for (const char* integrator : {"radau", "gear", "ida"}) {
                SCOPED_TRACE(std::string(gap) + " " + law.kind + " " + integrator);
                Simulation sim(spinning_shaft(law, gap), options(integrator, 1e-6));
                ASSERT_TRUE(sim.advance_to(0.5).ok);
                const double early = sim.sample().motion[0].w.x();
                ASSERT_TRUE(sim.advance_to(1.5).ok);
                const Sample& sample = sim.sample();
                EXPECT_NEAR(early - sample.motion[0].w.x(), brake, 1e-4 * brake);
                EXPECT_LT(std::abs(sample.balance), 1e-4);
            }
}

} // namespace
} // namespace gudgeon
