// Gudgeon as a part of another program: stepping to a time and back, loads and user-defined forces,
// saved states, matrices, threads, errors as exceptions and outcomes, silence. Everything is compared
// with closed forms.
#include "check.hpp"

#include <gudgeon/models/mechanisms.hpp>
#include <gudgeon/solvers/simulation.hpp>

#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <sys/stat.h>
#include <unistd.h>

using namespace gudgeon;

namespace {

constexpr double mass = 2, stiffness = 50; // kg, N/m: omega = 5 rad/s
const double omega = std::sqrt(stiffness / mass);

/// A block that slides along X, at x, without forces.
Model slider(double x) {
    Model model;
    Body& block = model.bodies.emplace_back();
    block.name = "block";
    block.mass = mass;
    block.inertia.diagonal() << 0.1, 0.2, 0.3;
    block.position = {x, 0, 0};
    Joint& guide = model.joints.emplace_back();
    guide.name = "guide";
    guide.kind = JointKind::translation;
    guide.bodies = {"ground", "block"};
    guide.axes = {Vec3::UnitX(), Vec3::UnitX()};
    return model;
}

/// The slider on a spring from (-10, 0, 0) that is free of force at x = 0.
Model oscillator(double x) {
    Model model = slider(x);
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "block"};
    spring.points = {Vec3(-10, 0, 0), Vec3(x, 0, 0)};
    spring.stiffness = stiffness;
    spring.free_length = 10;
    model.forces.push_back(spring);
    return model;
}

/// A uniform rod of 1 m and 2 kg hanging on a hinge about Y, turned outwards about Y by angle.
Model rod(double angle) {
    Model model;
    Body& body = model.bodies.emplace_back();
    body.name = "rod";
    body.mass = mass;
    body.inertia.diagonal() << mass / 12, mass / 12, 1e-4;
    body.position = {-0.5 * std::sin(angle), 0, -0.5 * std::cos(angle)};
    body.orientation = {std::cos(angle / 2), 0, std::sin(angle / 2), 0};
    Joint& hinge = model.joints.emplace_back();
    hinge.name = "hinge";
    hinge.kind = JointKind::revolute;
    hinge.bodies = {"ground", "rod"};
    hinge.axes = {Vec3::UnitY(), Vec3::UnitY()};
    return model;
}

SimulationOptions tight() {
    SimulationOptions options;
    options.integration.rtol = options.integration.atol = 1e-10;
    return options;
}

double x_of(Simulation& sim) { return sim.state().q[0]; }
double v_of(Simulation& sim) { return sim.state().u[0]; }

// The host's clock ticks irregularly; the mechanism is asked for each of its times.
void stepping_to_a_time() {
    Simulation sim(oscillator(0.3), tight());
    double t = 0;
    for (int k = 1; k <= 60; ++k) {
        t += k % 3 == 0 ? 0.05 : 0.011;
        CHECK(sim.advance_to(t).ok);
        CHECK(sim.time() == t);
        CHECK_NEAR(x_of(sim), 0.3 * std::cos(omega * t), 1e-7);
        CHECK_NEAR(v_of(sim), -0.3 * omega * std::sin(omega * t), 1e-6);
    }
    CHECK(sim.advance_to(t).ok);                                    // nothing to do
    CHECK_NEAR(sim.sample().joint[0].force.z(), mass * 9.81, 1e-7); // the guide carries the weight

    // Stepping freely, with samples inside the last step.
    Simulation free_steps(oscillator(0.3), tight());
    for (int k = 1; k <= 100; ++k) {
        CHECK(free_steps.advance_past(0.01 * k, 1).ok);
        CHECK_NEAR(free_steps.sample_at(0.01 * k).motion[0].r.x(), 0.3 * std::cos(omega * 0.01 * k), 1e-7);
    }
}

// A controller in the host sets the force -g x at each tick and holds it: between ticks the block
// swings about the shifted rest position.
void loads_between_steps() {
    Simulation sim(oscillator(0.3), tight());
    const double gain = 20, tick = 0.05;
    double x = 0.3, v = 0;
    for (int k = 1; k <= 20; ++k) {
        const double force = -gain * x, rest = force / stiffness;
        sim.set_load("block", {-gain * x_of(sim), 0, 0}, Vec3::Zero());
        CHECK(sim.advance_to(k * tick).ok);
        const double c = std::cos(omega * tick), s = std::sin(omega * tick);
        const double x_new = rest + (x - rest) * c + v / omega * s;
        v = -omega * (x - rest) * s + v * c;
        x = x_new;
        CHECK_NEAR(x_of(sim), x, 1e-7);
        CHECK_NEAR(v_of(sim), v, 1e-6);
    }

    // A moment about the hinge of a rod without weight: angle = 1/2 M / I t^2, input energy M angle.
    Model light = rod(0);
    light.gravity = Vec3::Zero();
    Simulation turning(light, tight());
    turning.set_load("rod", Vec3::Zero(), {0, 3, 0});
    CHECK(turning.advance_to(2).ok);
    const double angle = 0.5 * 3 / (mass / 3) * 4; // 9 rad
    CHECK_NEAR(turning.state().angles.value[0], angle, 1e-6);
    CHECK_NEAR(turning.sample().motion[0].r.x(), -0.5 * std::sin(angle), 1e-6);
    turning.set_load("rod", Vec3::Zero(), Vec3::Zero());
    CHECK(turning.advance_to(3).ok); // 9 rad/s from here on
    CHECK_NEAR(turning.state().angles.value[0], angle + 9, 1e-5);
}

/// A damped spring as a user would write it.
UserForce damped_spring(double k, double c, bool derivatives) {
    UserForce force{"damped spring", {"ground", "block"}, nullptr};
    force.law = [=](const UserForceInput& in, UserForceOutput& out) {
        out.wrench.force_b.x() = -k * in.b.r.x() - c * in.b.v.x();
        out.energies = {0.5 * k * in.b.r.x() * in.b.r.x(), c * in.b.v.x() * in.b.v.x(), 0};
        out.has_derivatives = derivatives;
        if (in.derivatives && derivatives) {
            out.C->block[2][2](0, 0) = c;
            out.S->block[2][2](0, 0) = k;
        }
    };
    return force;
}

void user_defined_force() {
    const double c = 4, decay = c / (2 * mass), damped = std::sqrt(omega * omega - decay * decay);
    for (const bool derivatives : {true, false}) {
        SimulationOptions options = tight();
        options.user_forces = {damped_spring(stiffness, c, derivatives)};
        Simulation sim(slider(0.3), options);
        for (const double t : {0.2, 0.7, 1.9}) {
            CHECK(sim.advance_to(t).ok);
            const double x =
                0.3 * std::exp(-decay * t) * (std::cos(damped * t) + decay / damped * std::sin(damped * t));
            CHECK_NEAR(x_of(sim), x, 1e-7);
        }
        const double left = 0.5 * stiffness * x_of(sim) * x_of(sim) + 0.5 * mass * v_of(sim) * v_of(sim);
        CHECK_NEAR(sim.state().dissipated(), 0.5 * stiffness * 0.09 - left, 1e-6);
        CHECK_NEAR(sim.sample().balance, 0, 1e-6);
    }
}

void saved_states() {
    Simulation sim(oscillator(0.3), tight());
    CHECK(sim.advance_to(0.4).ok);
    const State saved = sim.state();
    CHECK(sim.advance_to(1).ok);
    sim.restore(saved); // back in time
    CHECK(sim.time() == 0.4);
    CHECK_NEAR(x_of(sim), 0.3 * std::cos(omega * 0.4), 1e-7);
    CHECK(sim.advance_to(1).ok);
    CHECK_NEAR(x_of(sim), 0.3 * std::cos(omega), 1e-7);

    Simulation other(oscillator(0.3), tight()); // goes on elsewhere
    other.restore(saved);
    CHECK(other.advance_to(1).ok);
    CHECK_NEAR(x_of(other), 0.3 * std::cos(omega), 1e-7);

    State kicked = saved; // a state of the host's own
    kicked.t = 0;
    kicked.q[0] = 0;
    kicked.u[0] = 1;
    other.restore(kicked);
    CHECK(other.advance_to(0.7).ok);
    CHECK_NEAR(x_of(other), std::sin(omega * 0.7) / omega, 1e-7);

    // Angles keep count of their turns.
    Model light = rod(0);
    light.gravity = Vec3::Zero();
    light.bodies[0].angular_velocity = {0, 20, 0};
    light.bodies[0].velocity = {-10, 0, 0};
    Simulation spinning(light, tight()), fresh(light, tight());
    CHECK(spinning.advance_to(1).ok);
    fresh.restore(spinning.state());
    CHECK(fresh.advance_to(1.5).ok);
    CHECK_NEAR(fresh.state().angles.value[0], 30, 1e-5);
}

MatX dense(const CscMatrix& m) {
    MatX out = MatX::Zero(m.pattern.rows, m.pattern.cols);
    CHECK(static_cast<int>(m.pattern.col_start.size()) == m.pattern.cols + 1);
    CHECK(m.values.size() == m.pattern.row.size());
    for (int col = 0; col < m.pattern.cols; ++col)
        for (int i = m.pattern.col_start[col]; i < m.pattern.col_start[col + 1]; ++i) {
            CHECK(i == m.pattern.col_start[col] || m.pattern.row[i - 1] < m.pattern.row[i]);
            out(m.pattern.row[i], col) += m.values[i];
        }
    return out;
}

void matrices() {
    SimulationOptions options;
    options.user_forces = {damped_spring(30, 4, true)};
    Simulation sim(oscillator(0.3), options);
    const Simulation::Matrices m = sim.matrices();
    const MatX M = dense(m.M), C = dense(m.C), K = dense(m.K), G = dense(m.G);
    VecX diagonal(6);
    diagonal << mass, mass, mass, 0.1, 0.2, 0.3;
    CHECK((M - MatX(diagonal.asDiagonal())).norm() < 1e-14);
    CHECK_NEAR(K(0, 0), stiffness + 30, 1e-9);
    CHECK_NEAR(C(0, 0), 4, 1e-12);
    CHECK((C - C(0, 0) * MatX::Identity(6, 1) * MatX::Identity(1, 6)).norm() < 1e-12);
    CHECK(G.rows() == 5 && G.cols() == 6);
    CHECK(G.col(0).norm() < 1e-14); // free along X, nothing else
    CHECK(G.rightCols(5).fullPivLu().rank() == 5);

    // The stiffness of a hanging rod comes from its weight alone, through the reaction of the hinge:
    // along the free motion n, omega^2 = n.K n / n.M n = 3 g / 2 l.
    Simulation hanging(rod(0));
    const Simulation::Matrices h = hanging.matrices();
    VecX n(6);
    n << -0.5, 0, 0, 0, 1, 0;
    CHECK((dense(h.G) * n).norm() < 1e-14);
    CHECK_NEAR(n.dot(dense(h.K) * n) / n.dot(dense(h.M) * n), 1.5 * 9.81, 1e-10);
    CHECK(dense(h.C).norm() < 1e-14);
}

struct Run {
    State state;
    long steps = 0, sweeps = 0;
};

Run run(const std::string& name, double end) {
    Simulation sim(build_mechanism(name));
    CHECK(sim.advance_to(end).ok);
    return {sim.state(), sim.statistics().steps, sim.statistics().newton_sweeps};
}

bool same_bits(const VecX& a, const VecX& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

void two_threads() {
    const Run car = run("suspension-chain", 0.5), crank = run("slider-crank", 1);
    Run car2, crank2;
    std::thread first([&] { car2 = run("suspension-chain", 0.5); });
    std::thread second([&] { crank2 = run("slider-crank", 1); });
    first.join();
    second.join();
    CHECK(same_bits(car.state.q, car2.state.q) && same_bits(car.state.u, car2.state.u));
    CHECK(same_bits(crank.state.q, crank2.state.q) && same_bits(crank.state.u, crank2.state.u));
    CHECK(same_bits(crank.state.lambda, crank2.state.lambda));
    CHECK(car.steps == car2.steps && car.sweeps == car2.sweeps);
    CHECK(crank.steps == crank2.steps && crank.sweeps == crank2.sweeps);
    CHECK_NEAR(crank.state.q[14], 0.20789584070644, 1e-4); // the slider, independent solution
}

/// The exception thrown by f, or "".
template <class Exception> std::string thrown(const std::function<void()>& f) {
    try {
        f();
    } catch (const Exception& error) {
        return error.what();
    } catch (...) {
        return "another exception";
    }
    return "";
}

void errors() {
    Model massless = slider(0);
    massless.bodies[0].mass = 0;
    CHECK(thrown<ModelError>([&] { Simulation sim(massless); }).find("/bodies/0/mass") != std::string::npos);

    Model apart = slider(0); // its points cannot meet: the guide and a distance joint across it
    Joint& bar = apart.joints.emplace_back();
    bar.name = "bar";
    bar.kind = JointKind::distance;
    bar.bodies = {"ground", "block"};
    bar.points = {Vec3(0, 5, 0), Vec3(0, 0, 0)};
    bar.length = 2;
    CHECK(thrown<AssemblyError>([&] { Simulation sim(apart); }).find("bar") != std::string::npos);

    SimulationOptions unknown;
    unknown.integrator = "euler";
    CHECK(thrown<std::invalid_argument>([&] { Simulation sim(slider(0), unknown); }) != "");
    Simulation sim(slider(0));
    CHECK(thrown<std::invalid_argument>([&] { sim.set_load("wheel", Vec3::Zero(), Vec3::Zero()); }) != "");
    CHECK(thrown<std::invalid_argument>([&] { sim.restore(State{}); }) != "");

    // A force that stops being a number: the outcome says so, the state stays at the last good step.
    bool broken = true;
    SimulationOptions options;
    options.user_forces = {{"host", {"ground", "block"}, [&](const UserForceInput& in, UserForceOutput& out) {
                                out.wrench.force_b.x() = broken && in.t > 0.5
                                                             ? std::numeric_limits<double>::quiet_NaN()
                                                             : -stiffness * in.b.r.x();
                            }}};
    Simulation failing(slider(0.3), options);
    const StepOutcome outcome = failing.advance_to(1);
    CHECK(!outcome.ok && !outcome.message.empty() && outcome.reason != StepReason::none);
    CHECK(failing.time() <= 0.5);
    CHECK(failing.state().q.allFinite());
    broken = false; // the host mends it and goes on
    failing.restore(failing.state());
    CHECK(failing.advance_to(1).ok);
    CHECK_NEAR(x_of(failing), 0.3 * std::cos(omega), 1e-4);
}

void all() {
    stepping_to_a_time();
    loads_between_steps();
    user_defined_force();
    saved_states();
    matrices();
    two_threads();
    errors();
}

} // namespace

int main() {
    // Everything written to the descriptors 1 and 2 from here on lands in a file.
    report = fdopen(dup(2), "w");
    std::setvbuf(report, nullptr, _IONBF, 0);
    std::FILE* caught = std::tmpfile();
    if (!report || !caught || dup2(fileno(caught), 1) < 0 || dup2(fileno(caught), 2) < 0)
        return 2;
    try {
        all();
    } catch (const std::exception& error) {
        ++failures;
        std::fprintf(report, "unexpected: %s\n", error.what());
    }
    std::fflush(stdout);
    struct stat written {};
    fstat(fileno(caught), &written);
    CHECK(written.st_size == 0);
    std::fprintf(report, "%d failures\n", failures);
    return failures == 0 ? 0 : 1;
}
