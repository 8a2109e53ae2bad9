// Limits that rub and limits of a ball, from the model file to the motion, against closed forms.
#include "core/channels.hpp"
#include "core/reader.hpp"
#include "tests/solvers/hard_case_tools.hpp"

#include <fmt/format.h>

namespace gudgeon {
namespace {

using namespace hard_cases;

HowToRun how(const std::string& integrator, double tolerance, double end, double every = 0,
             double largest_step = 0) {
    return {integrator, tolerance, end, every, Onset::threshold, 1, 100000, largest_step};
}

// A rotor of 2 kg that stands on its lower end face, 9.81 * 2 N on a spring of 1e6 N/m, spinning at 50 rad/s.
Model thrust_bearing(const std::string& friction) {
    return parse_model(fmt::format(R"({{
      "gudgeon": 1, "name": "thrust", "gravity": [0, 0, -9.81],
      "bodies": [{{"name": "rotor", "mass": 2, "inertia": [0.01, 0.01, 0.004], "position": [0, 0, {}],
                  "angular_velocity": [0, 0, 50]}}],
      "joints": [{{"name": "B", "kind": "revolute", "bodies": ["ground", "rotor"], "frame": "body",
        "points": [[0, 0, 0], [0, 0, 0]], "axes": [[0, 0, 1], [0, 0, 1]],
        "fidelity": {{"radial": "perfect", "misalignment": "perfect", "axial": "clearance"}},
        "clearance": {{"axial": 1e-4, "radius": 0.02, "law": {{"kind": "linear", "stiffness": 1e6, "damping": 500}},
                      "friction": {}}}}}]}})",
                                   -1e-4 - 2 * 9.81e-6, friction),
                       "thrust.json");
}

// I w' = -mu N R until it stands still; then it stays, and all its energy has been dissipated. While bristles
// that start straight bend to z = mu/sigma0 at the speed v = R w, they add sigma1 z and lack mu z/v of
// momentum per N.
TEST(LimitMotion, EndFaceBrakesASpinningRotor) {
    const double slowing = 0.1 * 2 * 9.81 * 0.03 / 0.004;
    for (const char* integrator : {"radau", "gear", "ida"})
        for (
            const char* friction :
            {R"({"kind": "coulomb", "mu_k": 0.1, "speed": 1e-4, "radius": 0.03})",
             R"({"kind": "lugre", "mu_k": 0.1, "mu_s": 0.15, "speed": 1e-3, "sigma0": 1e5, "sigma1": 50, "radius": 0.03})"}) {
            SCOPED_TRACE(std::string(integrator) + friction);
            const Model model = thrust_bearing(friction);
            const bool bristles = model.joints[0].clearance->friction->kind == "lugre";
            double balance = 0;
            const HardRun run = simulate(model, how(integrator, 1e-7, 4, 0.5), [&](const Sample& s) {
                const double z = bristles ? 0.1 / 1e5 : 0, bending = 50 * z - 0.1 * z / (0.03 * 50);
                const double w = 50 - slowing * (s.state.t + bending / 0.1);
                if (w > 0) {
                    EXPECT_NEAR(s.state.u[5], w, 1e-6);
                    EXPECT_NEAR(s.contacts[0].friction_force, 0.1 * 2 * 9.81, 1e-4);
                }
                balance = std::max(balance, std::abs(s.balance));
            });
            EXPECT_NEAR(run.last.state.u[5], 0, 1e-4);
            EXPECT_NEAR(run.last.state.dissipated(), 0.5 * 0.004 * 50 * 50, 2e-4);
            EXPECT_LT(balance, 2e-4);
        }
}

// A slider of 3 kg whose key, at 20 mm, carries a moment of 6 N m: pressed by 300 N.
Model keyed_slider(const std::string& friction, double speed, double push) {
    const double turn = 1e-3 + 6e-4; // play and 6 N m / 1e4 N m/rad
    return parse_model(fmt::format(R"({{
      "gudgeon": 1, "name": "keyed", "gravity": [0, 0, 0],
      "bodies": [{{"name": "slider", "mass": 3, "inertia": [0.01, 0.01, 0.01], "velocity": [{}, 0, 0],
                  "orientation": [{}, {}, 0, 0]}}],
      "joints": [{{"name": "K", "kind": "translation", "bodies": ["ground", "slider"], "frame": "body",
        "points": [[0, 0, 0], [0, 0, 0]], "axes": [[1, 0, 0], [1, 0, 0]], "references": [[0, 1, 0], [0, 1, 0]],
        "fidelity": {{"radial": "perfect", "misalignment": "perfect", "rotation": "clearance"}},
        "clearance": {{"rotation": 1e-3, "law": {{"kind": "linear", "stiffness": 1e4, "damping": 20}},
                      "friction": {}}}}}],
      "forces": [{{"name": "T", "kind": "torque", "body": "slider", "vector": [6, 0, 0]}},
                 {{"name": "F", "kind": "force", "body": "slider", "point": [0, 0, 0], "vector": [{}, 0, 0]}}]}})",
                                   speed, std::cos(turn / 2), std::sin(turn / 2), friction, push),
                       "keyed.json");
}

// m x'' = -mu M/r: 5 m/s2, so it stops after 0.16 s and 64 mm.
TEST(LimitMotion, KeyBrakesASlider) {
    for (const char* integrator : {"radau", "gear"}) {
        SCOPED_TRACE(integrator);
        const Model model =
            keyed_slider(R"({"kind": "dahl", "mu_k": 0.05, "sigma0": 1e6, "radius": 0.02})", 0.8, 0);
        const HardRun run = simulate(model, how(integrator, 1e-7, 0.15, 0.01), [](const Sample& s) {
            EXPECT_NEAR(s.state.q[0], 0.8 * s.state.t - 2.5 * s.state.t * s.state.t, 1e-6);
            EXPECT_NEAR(s.contacts[0].friction_force, 15, 1e-4);
            EXPECT_NEAR(s.contacts[0].normal_force, 6, 1e-4); // N m
        });
        EXPECT_NEAR(run.last.state.dissipated(), 15 * run.last.state.q[0], 1e-4);
        EXPECT_LT(run.balance, 1e-5);
    }
}

// Half of what the key can hold: the bristles settle within a few of their deflections, mu/sigma0 = 5e-6 m.
TEST(LimitMotion, KeyHoldsASliderWithoutCreep) {
    const Model model = keyed_slider(
        R"({"kind": "lugre", "mu_k": 0.05, "sigma0": 1e4, "sigma1": 10, "radius": 0.02})", 0, 7.5);
    double early = 0;
    const HardRun run = simulate(model, how("radau", 1e-8, 10, 1), [&](const Sample& s) {
        if (early == 0)
            early = s.state.q[0];
    });
    EXPECT_GT(early, 2e-6);
    EXPECT_LT(early, 2e-5);
    EXPECT_NEAR(run.last.state.q[0], early, 1e-9);
    EXPECT_NEAR(run.last.contacts[0].friction_force, 7.5, 1e-3);
}

// A body on a ball at its mass centre, moment of inertia 0.02 about every axis, no weight; its axis Z in a
// cone.
Model stud(const ContactLaw& law, double cone, const Vec3& w, JointKind kind = JointKind::spherical) {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("stud", 1, {0.02, 0.02, 0.02}, Vec3::Zero())};
    model.bodies[0].angular_velocity = w;
    Joint joint = make_joint("S", kind, "ground", "stud", Vec3::Zero());
    joint.axes = {Vec3::UnitZ(), Vec3::UnitZ()};
    joint.stops["swing"] = {std::nullopt, cone, law, {}};
    model.joints = {joint};
    return model;
}

// From exactly zero swing into the cone and back with the opposite speed, through zero to its other side.
TEST(LimitMotion, ConeThrowsBackAsItsLawSays) {
    const double K = 2000, I = 0.02, w = 3;
    const double rise = std::sqrt(I / K), hertz_depth = std::pow(1.25 * I * w * w / K, 0.4);
    ContactLaw linear;
    linear.kind = "linear";
    linear.stiffness = K;
    for (const double cone : {0.5, 2.0, 3.1}) {
        SCOPED_TRACE(cone);
        const double half = cone / w;
        const auto run = [&](const ContactLaw& law, const Vec3& start, JointKind kind, double end,
                             const char* integrator = "radau") {
            // free motion could step over the 0.08 rad outside the widest cone
            return simulate(stud(law, cone, start, kind),
                            how(integrator, 1e-8, end, 0, 0.4 * (pi - cone) / w));
        };
        for (const JointKind kind : {JointKind::spherical, JointKind::point_on_axis}) {
            const HardRun back = run(linear, {w, 0, 0}, kind, 1.7 * half + pi * rise);
            EXPECT_EQ(back.history[0].impacts, 1);
            EXPECT_NEAR(back.history[0].deepest_angle / (w * rise), 1, 1e-4);
            EXPECT_NEAR(back.history[0].peak_moment / (w * rise * K), 1, 1e-3);
            EXPECT_NEAR(back.last.state.u[3], -w, 1e-5);
            EXPECT_NEAR(back.last.state.u.segment<2>(4).norm(), 0, 1e-7);
            EXPECT_LT(back.balance, 1e-6);
            const HardRun again = run(linear, {w, 0, 0}, kind, 3.5 * half + 2 * pi * rise);
            EXPECT_EQ(again.history[0].impacts, 2);
            EXPECT_NEAR(again.last.state.u[3], w, 1e-5);
        }
        const JointKind ball = JointKind::spherical;
        const HardRun hertz = run(law_of("hertz", K, 1), {0, -w, 0}, ball, 1.3 * half + 0.1, "gear");
        EXPECT_NEAR(hertz.history[0].deepest_angle / hertz_depth, 1, 1e-3);
        EXPECT_NEAR(hertz.last.state.u[4], w, 1e-4);
        const HardRun damped = run(law_of("lankarani-nikravesh", K, 0.5), {w, 0, 0}, ball, 1.3 * half + 0.1);
        const double ratio = speed_ratio(factor(0.5));
        EXPECT_EQ(damped.history[0].impacts, 1);
        EXPECT_NEAR(-damped.last.state.u[3] / w, ratio, 1e-5);
        EXPECT_NEAR(damped.last.state.dissipated(), 0.5 * I * w * w * (1 - ratio * ratio), 1e-5);
    }
}

// A pendulum on a ball that swings round in its cone. The cone turns about the vertical, so it takes no spin
// about it; and no more depth than the energy that there is would press.
TEST(LimitMotion, PendulumInACone) {
    const double cone = 0.6, K = 1e5, m = 1, l = 0.5;
    Model model;
    model.bodies = {make_body("bob", m, {2e-3, 2e-3, 1e-3}, {0, std::sin(0.3) * l, -std::cos(0.3) * l})};
    model.bodies[0].orientation = {std::cos(0.15), std::sin(0.15), 0, 0};
    model.bodies[0].angular_velocity = {3, 4, 2};
    model.bodies[0].velocity = rotation(model.bodies[0].orientation) * Vec3(3, 4, 2).cross(Vec3(0, 0, -l));
    Joint joint = make_joint("S", JointKind::spherical, "ground", "bob", Vec3::Zero());
    joint.body_frame = true;
    joint.points = {Vec3::Zero(), Vec3(0, 0, l)};
    joint.axes = {Vec3(0, 0, -1), Vec3(0, 0, -1)};
    for (const double restitution : {1.0, 0.8}) {
        joint.stops["swing"] = {std::nullopt, cone, law_of("flores", K, restitution), {}};
        model.joints = {joint};
        const System system = test::compiled(model);
        const Channels channels(system, {"S.swing"});
        ASSERT_EQ(channels.names(), std::vector<std::string>{"S.swing"});
        EXPECT_EQ(channels.units(), std::vector<std::string>{"rad"});
        for (const char* integrator : {"radau", "gear", "ida"}) {
            SCOPED_TRACE(integrator);
            double widest = 0, least_spin = 1e9, most_spin = -1e9, start = 0;
            const HardRun run = simulate(model, how(integrator, 1e-8, 3, 0.01), [&](const Sample& s) {
                double swing = 0;
                channels.read(s, {&swing, 1});
                const BodyMotion& b = s.motion[0];
                const double expected = std::acos(b.A(2, 2)); // of (0, 0, -1) to its image
                EXPECT_NEAR(swing, expected, 1e-7);
                widest = std::max(widest, swing);
                const double spin = m * (b.r[0] * b.v[1] - b.r[1] * b.v[0]) +
                                    (b.A * Vec3(2e-3, 2e-3, 1e-3).cwiseProduct(b.w))[2];
                least_spin = std::min(least_spin, spin);
                most_spin = std::max(most_spin, spin);
                start = s.energies.kinetic + s.energies.potential + s.energies.elastic +
                        s.state.dissipated() + m * 9.81 * l;
            });
            const double deepest = std::pow(2.5 * start / K, 0.4);
            EXPECT_GT(run.history[0].impacts, 4);
            EXPECT_LT(widest, cone + deepest);
            EXPECT_LT(run.history[0].deepest_angle, deepest);
            EXPECT_GT(run.history[0].deepest_angle, 0.05 * deepest);
            EXPECT_LT(most_spin - least_spin, 3e-5);
            EXPECT_LT(run.balance, 2e-4);
        }
    }
}

// The axial motion of a hinge, freed, meets a stop: half a period of mass and spring, and back.
TEST(LimitMotion, StopOfAFreedAxialMotion) {
    const Model model = parse_model(R"({
      "gudgeon": 1, "name": "freed", "gravity": [0, 0, 0],
      "bodies": [{"name": "pin", "mass": 2, "inertia": [0.01, 0.01, 0.01], "velocity": [0, 0, 1],
                  "angular_velocity": [0, 0, 7]}],
      "joints": [{"name": "H", "kind": "revolute", "bodies": ["ground", "pin"], "point": [0, 0, 0], "axis": [0, 0, 1],
        "fidelity": {"axial": "free"},
        "stops": {"slide": {"upper": 0.1, "law": {"kind": "linear", "stiffness": 2e4},
                            "friction": {"kind": "coulomb", "mu_k": 0.2, "speed": 1e-4, "radius": 0.05}}}}]})",
                                    "freed.json");
    const double depth = std::sqrt(2 / 2e4);
    const HardRun run = simulate(model, how("radau", 1e-8, 0.2));
    EXPECT_NEAR(run.history[0].deepest, depth, 1e-4 * depth);
    EXPECT_NEAR(run.last.state.u[2], -1, 1e-6);
    // turning over the stop: I dw = -mu R (impulse), the impulse 2 m v
    const double slower = 0.2 * 0.05 * 2 * 2 / 0.01;
    EXPECT_NEAR(run.last.state.u[5], 7 - slower, 1e-4);
    EXPECT_NEAR(run.last.state.dissipated(), 0.5 * 0.01 * (49 - std::pow(7 - slower, 2)), 1e-4);
    const System system = test::compiled(model);
    EXPECT_EQ(Channels(system, {"H.slide"}).units(), std::vector<std::string>{"m"});
}

} // namespace
} // namespace gudgeon
