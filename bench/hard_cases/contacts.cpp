// Contacts that hardly begin, begin hard, or never end.
#include "bench/hard_cases/cases.hpp"
#include "tests/solvers/impacts.hpp"

namespace gudgeon::hard {

namespace {

using namespace hard_cases;

constexpr double weight = 9.81, stiffness = 5e6;

/// One impact of the ball at this speed, met after a second's worth of its flight (at most 1 mm): errors of
/// speed and depth against the closed form of one impact, relative.
struct Impact {
    double speed, depth;
};
Impact impact(Trial& trial, double speed, double tolerance, double atol, double ratio, double chi) {
    const double gap = std::min(1e-4, speed), radial = speed < 0.1 ? 1e-3 : 10; // one wall is met, not both
    Model model = ball(law_of("lankarani-nikravesh", stiffness, 0.75), radial);
    model.bodies[0].position = {radial - gap, 0, 0};
    model.bodies[0].velocity = {speed, 0, 0};
    const double depth = chi > 0 ? impact_depth(chi, 1, speed, stiffness)
                                 : std::pow(1.25 * speed * speed / (stiffness * (1 + factor(0.75))), 0.4);
    double deepest = 0;
    const Sample last =
        trial.run(model, trial.options(tolerance, atol), {gap / speed + 4 * depth / speed},
                  [&](const Simulation& sim, const Sample&) { deepest = sim.state().history[0].deepest; });
    return {std::abs(-last.state.u[0] / (speed * ratio) - 1), std::abs(deepest / depth - 1)};
}

// Lankarani and Nikravesh: below 1e-9 m/s their ratio of speeds is 1, so that the contact is elastic, (1 +
// chi) K. One impact is one characteristic time; what the onset may hide is the share 20 rtol of its energy.
// The greatest depth is read at steps: a hundred of them leave it open by (pi/200)^2 / 2 of itself.
void impact_speeds(Trial& trial) {
    const double tolerance = 1e-7, chi = factor(0.75), bound = allowance(tolerance, 1, 1) + 20 * tolerance;
    double speed = 0, depth = 0;
    for (const double v : {2e-9, 1e-4, 1.0, 1e2}) {
        const Impact found =
            impact(trial, v, tolerance, tolerance * std::min(1.0, 0.1 * v), speed_ratio(chi), chi);
        speed = std::max(speed, found.speed);
        depth = std::max(depth, found.depth);
    }
    const Impact elastic = impact(trial, 0.5e-9, tolerance, 0.5e-10 * tolerance, 1, 0);
    const double few_steps = std::pow(pi / 200, 2) / 2;
    trial.hold("speed after 2e-9 ... 1e2 m/s, of itself", speed, bound);
    trial.hold("depth, of itself", depth, bound + few_steps);
    trial.hold("speed after 5e-10 m/s, of itself", elastic.speed, bound);
    trial.hold("its depth, of itself", elastic.depth, bound + few_steps);
}

// Speeds below the tolerance: nothing is asked of the motion but that it stays below ten tolerances, and that
// the contact, whose threshold is 1e-10 m and less, is neither tried for ever nor missed.
void below_the_tolerance(Trial& trial) {
    double missed = 0, fast = 0, steps = 0, rejected = 0, force = 0, pressed_steps = 0, pressed_rejected = 0;
    for (const double tolerance : {1e-4, 1e-6, 1e-9}) {
        Model model = ball(law_of("lankarani-nikravesh", stiffness, 0.75), 1e-3);
        model.bodies[0].position = {1e-3 - 1e-9, 0, 0}; // 1 s before contact
        model.bodies[0].velocity = {1e-9, 0, 0};
        SimulationOptions options = trial.options(tolerance);
        long starts = 0;
        options.on_contact = [&starts](const ContactEvent& e) {
            starts += e.kind == ContactEvent::Kind::start;
        };
        const Sample free = trial.run(model, options, {10});
        missed += starts == 0;
        fast = std::max(fast, (std::abs(free.state.u[0]) - 2e-9) / tolerance);
        steps = std::max(steps, static_cast<double>(trial.work().steps));
        rejected = std::max(rejected, static_cast<double>(trial.work().rejected_contact));
        model.gravity = {weight, 0, 0};
        const Sample pressed = trial.run(model, options, {10});
        pressed_steps = std::max(pressed_steps, static_cast<double>(trial.work().steps));
        pressed_rejected = std::max(pressed_rejected, static_cast<double>(trial.work().rejected_contact));
        force = std::max(force, std::abs(pressed.contacts[0].normal_force / weight - 1));
    }
    trial.hold("contacts missed", missed, 0);
    trial.hold("speed, of the tolerance", fast, 10);
    trial.hold("steps", steps, 100);
    trial.hold("steps rejected for contact", rejected, 10);
    trial.hold("under weight: force, of the weight", force, 1e-3);
    trial.hold("under weight: steps", pressed_steps, 500);
    trial.hold("under weight: rejected for contact", pressed_rejected, 30);
}

// Rest is where the elastic part carries the weight; an implicit method of any worth ends there to round-off
// times its Newton tolerance: 1e-6 of the depth, and no creep of that size between 1 s and 10 s.
void resting(Trial& trial) {
    const double depth = std::pow(weight / stiffness, 1 / 1.5);
    double deep = 0, early = 0, force = 0, steps = 0;
    for (const char* kind : {"hertz", "lankarani-nikravesh", "flores", "hunt-crossley"}) {
        const bool elastic = std::string(kind) == "hertz"; // never comes to rest by itself
        const Model model = ball_above(law_of(kind, stiffness, 0.75), elastic ? -depth : 1e-5);
        SimulationOptions options = trial.options(1e-6);
        bool begun = false;
        long last_start = 0, taken = 0;
        options.on_contact = [&](const ContactEvent& event) {
            begun = begun || event.kind == ContactEvent::Kind::start;
        };
        trial.run(model, options, {10, 0.1}, [&](const Simulation& sim, const Sample& sample) {
            taken = sim.statistics().steps;
            if (std::exchange(begun, false))
                last_start = taken;
            const double off = std::abs(sample.contacts[0].penetration / depth - 1);
            if (std::abs(sample.state.t - 1) < 1e-9)
                early = std::max(early, off);
            if (sample.state.t == 10) {
                deep = std::max(deep, off);
                force = std::max(force, std::abs(sample.contacts[0].normal_force / weight - 1));
            }
        });
        steps = std::max(steps, static_cast<double>(taken - last_start));
    }
    trial.hold("depth at 1 s, of itself", early, 1e-6);
    trial.hold("depth at 10 s, of itself", deep, 1e-6);
    trial.hold("force at 10 s, of the weight", force, 1e-5);
    trial.hold("steps since contact lasts", steps, 500);
}

} // namespace

std::vector<HardCase> contact_cases() {
    return {{"ImpactSpeeds", "a ball of 1 kg hits its socket at 5e-10 to 1e2 m/s", impact_speeds},
            {"BelowTheTolerance", "the same at 1e-9 m/s, far below the tolerance; then pressed by its weight",
             below_the_tolerance},
            {"RestingContact", "a ball that lies in its socket, by four laws", resting}};
}

} // namespace gudgeon::hard
