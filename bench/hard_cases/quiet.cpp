// Where little or nothing happens: no forces, nothing fixed, nothing free, everything at rest.
#include "bench/hard_cases/cases.hpp"
#include "models/builders.hpp"
#include "tests/solvers/elliptic.hpp"

#include <fmt/format.h>

namespace gudgeon::hard {

namespace {

constexpr double g = 9.81;

struct Momentum {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero(); // about the origin
    double sizes = 0;                                   // sum of m |v|
};

Momentum momentum(const System& system, const Sample& sample) {
    Momentum out;
    for (int i = 0; i < system.moving; ++i) {
        const BodyMotion& b = sample.motion[i];
        const Vec3 p = system.mass[i] * b.v;
        out.linear += p;
        out.angular += b.r.cross(p) + b.A * (system.inertia[i] * b.w);
        out.sizes += p.norm();
    }
    return out;
}

/// Five links on balls, tumbling, with springs from each to the next but one; nothing holds the first.
Model floating() {
    Model model = build_mechanism("chain", {{"links", "5"}, {"joint", "spherical"}});
    model.gravity = Vec3::Zero();
    model.joints.erase(model.joints.begin());
    model.markers.clear();
    for (std::size_t k = 0; k < model.bodies.size(); ++k) {
        const double x = static_cast<double>(k);
        model.bodies[k].velocity = {0.3, std::sin(x), std::cos(2 * x)};
        model.bodies[k].angular_velocity = {3, std::cos(3 * x), 0.5};
    }
    for (std::size_t k = 0; k + 2 < model.bodies.size(); ++k) {
        SpringDamper spring;
        spring.name = fmt::format("spring{}", k);
        spring.bodies = {model.bodies[k].name, model.bodies[k + 2].name};
        spring.points = {model.bodies[k].position, model.bodies[k + 2].position};
        spring.stiffness = 20;
        spring.damping = 0.5;
        model.forces.push_back(spring);
    }
    return model;
}

// Inner forces come in pairs whatever the step: what is left of linear momentum is round-off, at most a unit
// of it for each body and step. Lever arms are those of the step's end, so angular momentum follows to the
// tolerance: 5 s are some five turns.
void free_floating(Trial& trial) {
    const double tolerance = 1e-8, end = 5;
    Momentum start;
    double linear = 0, angular = 0, arms = 0;
    trial.run(floating(), tolerance, {end, 0.1}, [&](const Simulation& sim, const Sample& sample) {
        const Momentum now = momentum(sim.system(), sample);
        if (sample.state.t == 0)
            start = now;
        linear = std::max(linear, (now.linear - start.linear).norm() / start.sizes);
        angular = std::max(angular, (now.angular - start.angular).norm());
        for (int i = 0; i < sim.system().moving; ++i)
            arms += sample.state.t == 0 ? sim.system().mass[i] * (1 + sample.motion[i].r.norm()) : 0;
    });
    trial.hold("linear momentum, of the sum of m v", linear,
               1e-15 * 5 * static_cast<double>(trial.work().steps));
    trial.hold("angular momentum, kg m2/s", angular, arms * allowance(tolerance, 5, 1));
}

/// Two bodies in empty space: a block that tumbles about its first and third axis, and one that only drifts.
Model in_empty_space() {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("block", 2, {0.01, 0.02, 0.025}, {1, 2, 3}),
                    make_body("drifter", 1e-3, {1e-6, 1e-6, 1e-6}, {0, 0, -1})};
    model.bodies[0].velocity = {1, -2, 0.5};
    model.bodies[0].angular_velocity = {3, 0, 5};
    model.bodies[1].velocity = {0, 0, 7};
    return model;
}

// Euler's free motion in Jacobi's functions (Landau & Lifshitz, Mechanics, section 37); 10 s are 14 of its
// periods.
void no_forces(Trial& trial) {
    const double tolerance = 1e-8, end = 10;
    const Vec3 I(0.01, 0.02, 0.025), w0(3, 0, 5), v(1, -2, 0.5);
    const double E2 = I.cwiseProduct(w0.cwiseProduct(w0)).sum(), M2 = I.cwiseProduct(w0).squaredNorm();
    const double rate = std::sqrt((I[2] - I[1]) * (M2 - E2 * I[0]) / (I[0] * I[1] * I[2]));
    const double k = std::sqrt((I[1] - I[0]) * (E2 * I[2] - M2) / ((I[2] - I[1]) * (M2 - E2 * I[0])));
    const double middle = std::sqrt((E2 * I[2] - M2) / (I[1] * (I[2] - I[1])));
    const double period = 4 * std::comp_ellint_1(k) / rate;
    double line = 0, tumble = 0, momentum = 0;
    trial.run(in_empty_space(), tolerance, {end, 0.1}, [&](const Simulation& sim, const Sample& sample) {
        const double t = sample.state.t;
        const BodyMotion& block = sample.motion[0];
        line = std::max({line, (block.r - Vec3(1, 2, 3) - v * t).norm(),
                         (sample.motion[1].r - Vec3(0, 0, -1 + 7 * t)).norm()});
        const test::Jacobi j = test::jacobi(std::fmod(rate * t, 4 * std::comp_ellint_1(k)), k);
        tumble = std::max(tumble, (block.w - Vec3(w0[0] * j.cn, middle * j.sn, w0[2] * j.dn)).norm());
        const Vec3 L = block.A * (sim.system().inertia[0] * block.w);
        momentum = std::max(momentum, (L - I.cwiseProduct(w0)).norm());
    });
    trial.hold("off the straight lines, m", line, allowance(tolerance, 1, 70));
    trial.hold("angular velocity, rad/s", tumble, allowance(tolerance, end / period, w0.norm()));
    trial.hold("angular momentum, kg m2/s", momentum,
               I[2] * allowance(tolerance, end / period, 2 * w0.norm()));
}

/// A bar on a hinge at its end, held up by a rod to the ground: nothing can move.
Model held() {
    Model model;
    model.bodies = {make_body("bar", 2, {1e-3, 0.1, 0.1}, {0.5, 0, 0})};
    model.joints = {make_joint("hinge", JointKind::revolute, "ground", "bar", Vec3::Zero(), Vec3::UnitY()),
                    make_joint("rod", JointKind::distance, "ground", "bar", {1, 0, 0})};
    model.joints[1].points[0] = {0, 0, 1};
    return model;
}

/// An eccentric wheel whose turning is prescribed: nothing is free.
Model turned_by_force(double frequency) {
    Model model;
    model.bodies = {make_body("wheel", 3, {0.1, 0.2, 0.1}, {0.5, 0, 0})};
    const double speed = 2 * pi * frequency;
    model.bodies[0].angular_velocity = {0, speed, 0};
    model.bodies[0].velocity = {0, 0, -0.5 * speed};
    Joint axle = make_joint("axle", JointKind::revolute, "ground", "wheel", Vec3::Zero(), Vec3::UnitY());
    axle.drives["angle"] = RampFunction{0, speed, 0};
    model.joints = {axle};
    return model;
}

// The rod carries m g a / (sin of its slope) about the hinge. The wheel's place is given by its angle, its
// moment by its weight: both to round-off and the closing of the constraints, whatever the tolerance.
void zero_freedom(Trial& trial) {
    double freedom = 0, moved = 0, force = 0, moment = 0, place = 0;
    const auto rest = [&](const Simulation& sim, const Sample& sample) {
        freedom = std::max(freedom, std::abs(static_cast<double>(sim.redundancy().dof)));
        moved = std::max(moved, (sample.motion[0].r - Vec3(0.5, 0, 0)).norm());
        const double rod = 2 * g * 0.5 / std::sqrt(0.5);
        force = std::max({force, (sample.joint[1].force - rod * Vec3(-1, 0, 1) / std::sqrt(2.0)).norm(),
                          (sample.joint[0].force - Vec3(g, 0, g)).norm()});
    };
    trial.run(held(), 1e-6, {10, 1}, rest);
    const double frequency = 2;
    trial.run(turned_by_force(frequency), 1e-6, {5, 0.05}, [&](const Simulation& sim, const Sample& sample) {
        freedom = std::max(freedom, std::abs(static_cast<double>(sim.redundancy().dof)));
        const double a = 2 * pi * frequency * sample.state.t, c = std::cos(a), s = std::sin(a);
        place = std::max(place, (sample.motion[0].r - 0.5 * Vec3(c, 0, -s)).norm());
        moment = std::max(moment, std::abs(sample.joint[0].moment.y() + 3 * g * 0.5 * c));
    });
    trial.hold("degrees of freedom", freedom, 0);
    trial.hold("held bar moved, m", moved, 1e-10);
    trial.hold("reactions of the held bar, N", force, 1e-9 * 2 * g);
    trial.hold("driven wheel off its place, m", place, 2e-10);
    trial.hold("moment of its drive, N m", moment, 1e-6 * 3 * g);
}

/// The ready chain, hanging.
Model hanging(int links) {
    Model model = build_mechanism("chain", {{"links", std::to_string(links)}});
    const auto down = [](Vec3& x) { x = {0, 0, -x.x()}; };
    for (Body& body : model.bodies) {
        down(body.position);
        body.orientation = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};
    }
    for (Joint& joint : model.joints) {
        down(joint.points[0]);
        down(joint.points[1]);
    }
    model.markers.clear();
    return model;
}

// Each joint carries what hangs below it. Nothing moves, so that steps grow without limit.
void many_at_rest(Trial& trial) {
    const int links = 10'000;
    double moved = 0, speed = 0, force = 0;
    trial.run(hanging(links), 1e-6, {10}, [&](const Simulation& sim, const Sample& sample) {
        for (int k = 0; k < links; ++k) {
            const BodyMotion& link = sample.motion[sim.system().body_index(fmt::format("link{}", k + 1))];
            moved = std::max(moved, (link.r - Vec3(0, 0, -k - 0.5)).norm());
            speed = std::max({speed, link.v.norm(), link.w.norm()});
            const Vec3& f = sample.joint[sim.system().joint_index(fmt::format("J{}", k + 1))].force;
            force = std::max(force, (f - Vec3(0, 0, (links - k) * g)).norm() / (links * g));
        }
    });
    trial.hold("moved, m", moved, 1e-9);
    trial.hold("speed, m/s, rad/s", speed, 1e-9);
    trial.hold("reactions, of the largest", force, 1e-10);
    trial.hold("steps", static_cast<double>(trial.work().steps), 50);
}

} // namespace

std::vector<HardCase> quiet_cases() {
    return {{"FreeFloating", "five links and three springs that nothing holds", free_floating},
            {"NoForces", "two bodies in empty space, no joints: drift and free tumbling", no_forces},
            {"ZeroFreedom", "a bar that cannot move, and a wheel whose motion is prescribed", zero_freedom},
            {"TenThousandAtRest", "a chain of 10 000 links, hanging", many_at_rest, true}};
}

} // namespace gudgeon::hard
