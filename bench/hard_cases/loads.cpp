// Forces that are not smooth: steps, kinks, pulses after a long rest.
#include "bench/hard_cases/cases.hpp"
#include "core/curve.hpp"
#include "models/builders.hpp"

namespace gudgeon::hard {

namespace {

/// 1 kg on a guide along X, no weight.
Model on_a_guide() {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("block", 1, Vec3::Constant(1e-2), Vec3::Zero())};
    model.joints = {
        make_joint("guide", JointKind::translation, "ground", "block", Vec3::Zero(), Vec3::UnitX())};
    return model;
}

AppliedForce push(const std::string& name, const TimeFunction& time) {
    AppliedForce force;
    force.name = name;
    force.body = "block";
    force.vector = Vec3::UnitX();
    force.time = time;
    return force;
}

/// Constant values from given times on, each reached within `rise`: a stair as a table.
TableFunction stair(const std::vector<std::pair<double, double>>& from, double rise, double end) {
    Table table;
    double value = 0;
    const auto point = [&table](double t, double y) {
        table.x.push_back(t);
        table.y.push_back(y);
    };
    point(-1, 0);
    for (const auto& [t, next] : from) {
        point(t - rise / 2, value);
        point(t + rise / 2, next);
        value = next;
    }
    point(end, value);
    return TableFunction(std::move(table));
}

struct Line {
    double place = 0, speed = 0;
};

/// Exact motion from rest under such a stair (of no rise).
Line under_stair(const std::vector<std::pair<double, double>>& from, double t) {
    Line out;
    for (std::size_t k = 0; k < from.size() && from[k].first < t; ++k) {
        const double until = k + 1 < from.size() ? std::min(t, from[k + 1].first) : t;
        const double h = until - from[k].first;
        out.place += h * (out.speed + h * from[k].second / 2);
        out.speed += h * from[k].second;
    }
    return out;
}

/// Largest errors of place (m) and speed (m/s) over 4 s.
Line largest_errors(Trial& trial, const Model& model, double tolerance,
                    const std::vector<std::pair<double, double>>& from) {
    Line worst;
    trial.run(model, tolerance, {4, 0.05}, [&](const Simulation&, const Sample& sample) {
        const Line exact = under_stair(from, sample.state.t);
        worst.place = std::max(worst.place, std::abs(sample.motion[0].r.x() - exact.place));
        worst.speed = std::max(worst.speed, std::abs(sample.motion[0].v.x() - exact.speed));
    });
    return worst;
}

// Each step of the force is a characteristic time of its own; beyond it the motion is a parabola, which every
// order above one follows exactly. A rise of 1e-9 s is off by 1e-9 of the force at most.
void stepped_forces(Trial& trial) {
    const double tolerance = 1e-8;
    const std::vector<std::pair<double, double>> steps{{0.5, 8}, {1.25, -5}, {1.3, 20}, {2, -12}, {3.1, 0}};
    Model table = on_a_guide();
    table.forces = {push("stair", stair(steps, 1e-9, 5))};
    const Line by_table = largest_errors(trial, table, tolerance, steps);
    Model smooth = on_a_guide();
    double before = 0;
    for (const auto& [t, value] : steps) {
        smooth.forces.push_back(push("step" + std::to_string(smooth.forces.size()),
                                     SmoothStepFunction{t - 5e-10, t + 5e-10, 0, value - before}));
        before = value;
    }
    const Line by_steps = largest_errors(trial, smooth, tolerance, steps);
    const double bound = allowance(tolerance, 5, 15);
    trial.hold("stair from a table: place, m", by_table.place, 4 * bound);
    trial.hold("stair from a table: speed, m/s", by_table.speed, bound);
    trial.hold("stair from steps: place, m", by_steps.place, 4 * bound);
    trial.hold("stair from steps: speed, m/s", by_steps.speed, bound);
}

// A pulse has to be met however long the steps have grown in the rest before it. Its impulse is the area of
// the table's curve; the step's is height times width.
void pulse_after_rest(Trial& trial) {
    const double tolerance = 1e-6, start = 50, width = 1e-3;
    const Table pulse{{0, start, start + width / 2, start + width, 100}, {0, 0, 2000, 0, 0}};
    const double impulse = Spline(pulse, Spline::Ends::constant)(100).integral;
    Model table = on_a_guide();
    table.forces = {push("pulse", TableFunction(pulse))};
    const double by_table = trial.run(table, tolerance, {60}).motion[0].v.x();
    Model pair = on_a_guide();
    pair.forces = {push("on", SmoothStepFunction{start, start + 1e-5, 0, 1000}),
                   push("off", SmoothStepFunction{start + width, start + width + 1e-5, 0, -1000})};
    const double by_steps = trial.run(pair, tolerance, {60}).motion[0].v.x();
    const double bound = allowance(tolerance, 1, 1);
    trial.hold("speed after a pulse in a table, of itself", std::abs(by_table / impulse - 1), bound);
    trial.hold("speed after two steps of the force, of itself", std::abs(by_steps / (1000 * width) - 1),
               bound);
}

// Soft one way and a hundred times as stiff the other, with kinks at both sides of the middle: the motion
// repeats itself with the period that quadrature of the curve gives.
void kinked_table(Trial& trial) {
    const double tolerance = 1e-7, start = -0.3, periods = 20;
    const Table table{{-1, -1e-4, 1e-4, 1}, {-100, -1e-2, 1, 1e4}};
    const Spline curve(table, Spline::Ends::linear);
    const double energy = curve(start).integral;
    double far = 0, beyond = 1; // where all of it is elastic again
    for (int i = 0; i < 100; ++i) {
        const double middle = (far + beyond) / 2;
        (curve(middle).integral < energy ? far : beyond) = middle;
    }
    double period = 0; // dx / v, x = end (1 - s^2) to take the root at the end away, in pieces between kinks
    for (const double end : {start, far}) {
        const double kinks[]{0, std::sqrt(1 - 1e-4 / std::abs(end)), 1};
        for (int piece = 0; piece < 2; ++piece) {
            const int n = 20000; // midpoints
            const double h = (kinks[piece + 1] - kinks[piece]) / n;
            for (int i = 0; i < n; ++i) {
                const double s = kinks[piece] + (i + 0.5) * h;
                const double v = std::sqrt(2 * (energy - curve(end * (1 - s * s)).integral));
                period += 2 * std::abs(end) * 2 * s / v * h;
            }
        }
    }
    Model model = on_a_guide();
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "block"};
    spring.points = {Vec3(-3, 0, 0), Vec3::Zero()};
    spring.free_length = 3;
    spring.table = table;
    model.forces = {spring};
    model.bodies[0].start_position = Vec3(start, 0, 0);
    double lost = 0, back = 0;
    trial.run(model, tolerance, {periods * period, period}, [&](const Simulation&, const Sample& sample) {
        lost = std::max(lost, std::abs(sample.balance) / energy);
        back = std::max(back, std::abs(sample.motion[0].r.x() - start));
    });
    const double fastest = std::sqrt(2 * energy);
    trial.hold("energy, of itself", lost, 2 * allowance(tolerance, periods, fastest) / fastest);
    trial.hold("back at its start, m", back, allowance(tolerance, periods, fastest) / fastest);
}

} // namespace

std::vector<HardCase> load_cases() {
    return {{"SteppedForces", "a block under a force that jumps five times within 1e-9 s", stepped_forces},
            {"PulseAfterRest", "50 s of rest, then 1 N s within 1 ms", pulse_after_rest},
            {"KinkedTable", "a spring a hundred times as stiff one way as the other", kinked_table}};
}

} // namespace gudgeon::hard
