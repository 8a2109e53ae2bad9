// Small models with known motions and loops over steps, for the tests of the integrators.
#pragma once

#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "core/user_force.hpp"
#include "models/mechanisms.hpp"
#include "solvers/integrator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace gudgeon::integrator_tools {

inline System ready(const std::string& name, const std::map<std::string, std::string>& parameters = {}) {
    return compile(build_mechanism(name, parameters), standard_force_builders());
}

/// An integrator of fixed steps at the start of a system.
template <class Make> std::unique_ptr<Integrator> started(Make make, const System& system, double step) {
    IntegratorOptions options;
    options.step = step;
    auto integrator = make(system, options);
    integrator->start(initial_state(system));
    return integrator;
}

/// Advances to `end`; calls `at(state)` at k * every, interpolated, and at the end.
inline StepOutcome run(Integrator& integrator, double end, double every = 0,
                       const std::function<void(const State&)>& at = {}) {
    State sample = integrator.state();
    double next = integrator.state().t;
    while (integrator.state().t < end) {
        if (StepOutcome outcome = integrator.advance(end); !outcome.ok)
            return outcome;
        for (; at && every > 0 && next <= integrator.state().t; next += every) {
            integrator.interpolate(next, sample);
            EXPECT_NEAR(sample.t, next, 1e-12);
            at(sample);
        }
    }
    return {};
}

inline double mechanical_energy(const System& system, const State& state) {
    Workspace ws = make_workspace(system);
    set_motion(system, state.q, state.u, ws);
    return energies(system, state.t, nullptr, ws).mechanical();
}

/// 2 kg on a guide along X with a spring (50 N/m, 3 N s/m, at rest at x = 0) and no weight.
struct Oscillator {
    static constexpr double m = 2, k = 50, c = 3, x0 = 0.1, v0 = -0.4;

    static System system() {
        Model model;
        model.gravity = Vec3::Zero();
        Body mass;
        mass.name = "mass";
        mass.mass = m;
        mass.inertia = Mat3::Identity();
        mass.position = {x0, 0, 0};
        mass.velocity = {v0, 0, 0};
        model.bodies = {mass};
        Joint guide;
        guide.name = "guide";
        guide.kind = JointKind::translation;
        guide.bodies = {"ground", "mass"};
        guide.points = {mass.position, mass.position};
        guide.axes = {Vec3::UnitX(), Vec3::UnitX()};
        model.joints = {guide};
        SpringDamper spring;
        spring.name = "spring";
        spring.bodies = {"ground", "mass"};
        spring.points = {Vec3(-1, 0, 0), mass.position};
        spring.stiffness = k;
        spring.damping = c;
        spring.free_length = 1;
        model.forces = {spring};
        return compile(std::move(model), standard_force_builders());
    }

    static double x(double t) {
        const double a = c / (2 * m), w = std::sqrt(k / m - a * a);
        return std::exp(-a * t) * (x0 * std::cos(w * t) + (v0 + a * x0) / w * std::sin(w * t));
    }
    static double v(double t) {
        const double a = c / (2 * m), w = std::sqrt(k / m - a * a), b = (v0 + a * x0) / w;
        return std::exp(-a * t) * ((b * w - a * x0) * std::cos(w * t) - (x0 * w + a * b) * std::sin(w * t));
    }
    static double energy(double t) { return 0.5 * (m * v(t) * v(t) + k * x(t) * x(t)); }
};

/// The ready slider-crank, its slider driven: x = 0.2 + 0.24 / w sin(w t), w = 2 pi 4 Hz. It takes over at
/// the speed of the ready start and stays clear of the dead centre at x = 0.185.
inline System driven_slider_crank() {
    Model model = build_mechanism("slider-crank");
    HarmonicFunction drive;
    drive.frequency = 4;
    drive.amplitude = 0.24 / (2 * pi * drive.frequency);
    for (Joint& joint : model.joints)
        if (joint.name == "D")
            joint.drives["slide"] = drive;
    return compile(std::move(model), standard_force_builders());
}

inline double driven_slide(double t) { return 0.24 / (8 * pi) * std::sin(8 * pi * t); }

/// The ready pendulum at a time: x = -sin(theta), z = -cos(theta), theta from the lowest point (Jacobi's
/// elliptic functions, 30 digits).
struct PendulumAt10 {
    static constexpr double x = -0.27508746257611686, z = -0.96141920509912506;
};

/// A free body pushed by a law of the test.
inline System pushed_body(UserForceLaw law) {
    Model model;
    Body body;
    body.name = "probe";
    body.mass = 1;
    body.inertia = Mat3::Identity();
    model.bodies = {body};
    std::vector<ForceBatchBuilder> builders = standard_force_builders();
    UserForce push;
    push.name = "push";
    push.bodies = {"ground", "probe"};
    push.law = std::move(law);
    builders.push_back(user_force_builder({push}));
    return compile(std::move(model), builders);
}

} // namespace gudgeon::integrator_tools
