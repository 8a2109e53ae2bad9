// Long times and many turns.
#include "bench/hard_cases/cases.hpp"
#include "bench/hard_cases/truths.hpp"
#include "core/channels.hpp"
#include "models/builders.hpp"

namespace gudgeon::hard {

namespace {

constexpr double g = 9.81;

// Energy: what a period may lose by allowance() (in m g l), a thousand times, all in one sense. A relative
// change e of the energy of a swing of 90 degrees changes its period by (dK/dm)/K e/2 = 0.228 e of itself, m
// = k^2 = 1/2; summed over N periods while the energy drifts that is 2 pi 0.228 (loss per period) N^2/2, to
// which the errors of the angle itself come.
void thousand_periods(Trial& trial) {
    const double tolerance = 1e-10, periods = 1000;
    const Swing swing{g, pi / 2};
    const double T = swing.period();
    double phase = 0, energy = 0;
    trial.run(build_mechanism("pendulum"), tolerance, {periods * T, T / 4},
              [&](const Simulation&, const Sample& sample) {
                  const Vec3 &r = sample.motion[0].r, &v = sample.motion[0].v;
                  energy = std::max(energy, std::abs(v.squaredNorm() / 2 + g * r.z()) / g);
                  const Swing::Now now = swing.at(sample.state.t);
                  if (std::abs(now.theta) > 0.1)
                      return; // only where it passes its lowest point the angle tells the phase
                  const double lag = (std::atan2(-r.x(), -r.z()) - now.theta) / now.rate;
                  phase = std::max(phase, 2 * pi * std::abs(lag) / T);
              });
    const double loss = allowance(tolerance, 1, 1);
    trial.hold("energy, of m g l", energy, loss * periods);
    trial.hold("phase, rad", phase, 2 * pi * 0.228 * loss * periods * periods / 2 + loss * periods);
}

// Nothing changes but the angle, whose errors add up over the turns. Steps may be as long as the method
// likes, even longer than a turn, but no turn may be lost.
void many_turns(Trial& trial) {
    const double tolerance = 1e-7, turns = 1e4, speed = 100, end = 2 * pi * turns / speed;
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("rotor", 1, {1e-2, 2e-2, 1e-2}, Vec3::Zero())};
    model.bodies[0].angular_velocity = {0, speed, 0};
    model.joints = {make_joint("axle", JointKind::revolute, "ground", "rotor", Vec3::Zero(), Vec3::UnitY())};
    double length = 0, angle = 0;
    trial.run(model, tolerance, {end, end / 1237}, [&](const Simulation& sim, const Sample& sample) {
        const Channels channel(sim.system(), {"axle.angle"});
        double value = 0;
        channel.read(sample, {&value, 1});
        angle = std::max(angle, std::abs(value - speed * sample.state.t));
        for (const VecX& q : {sim.state().q, sample.state.q})
            length = std::max(length, std::abs(q.segment<4>(3).norm() - 1));
    });
    trial.hold("length of the quaternion, off 1", length, 1e-12);
    trial.hold("unwrapped angle, rad", angle, allowance(tolerance, turns, 1));
}

/// The ready top, released in the air, and its exact motion.
struct Released {
    double iperp, iaxial, spin;
    static constexpr double mass = 1, arm = 0.3, tilt = pi / 3;

    Model model() const {
        Model out = build_mechanism("heavy-top", {{"spin", "0"}, {"iperp", "1"}, {"iaxial", "1"}});
        out.bodies[0].inertia = Vec3(iperp, iperp, iaxial).asDiagonal();
        out.bodies[0].angular_velocity = {0, 0, spin};
        return out;
    }
    double about_point() const { return iperp + mass * arm * arm; }
    ReleasedTop exact() const {
        return {2 * mass * g * arm / about_point(), iaxial * spin / about_point(), tilt};
    }
};

// 1000 rad/s are 159 turns in a second; the orientation has to be followed through each of them.
void fast_top(Trial& trial) {
    const double tolerance = 1e-9, end = 1, speed = 1000;
    const Released top{0.02, 0.01, speed};
    const ReleasedTop exact = top.exact();
    double centre = 0, spin = 0, azimuth = 0, before = 0;
    trial.run(top.model(), tolerance, {end, 0.01}, [&](const Simulation&, const Sample& sample) {
        const double t = sample.state.t, u = exact.cosine(t), s = std::sqrt(1 - u * u);
        azimuth += exact.azimuth(before, t);
        before = t;
        const Vec3 truth = Released::arm * Vec3(s * std::cos(azimuth), s * std::sin(azimuth), u);
        centre = std::max(centre, (sample.motion[0].r - truth).norm());
        spin = std::max(spin, std::abs(sample.motion[0].w.z() / speed - 1));
    });
    const double turns = speed * end / (2 * pi);
    trial.hold("mass centre, m", centre, allowance(tolerance, turns, 1));
    trial.hold("spin, of itself", spin, allowance(tolerance, turns, 0));
}

} // namespace

std::vector<HardCase> long_time_cases() {
    return {{"ThousandPeriods", "the pendulum, 90 degrees to both sides, 1000 times", thousand_periods, true},
            {"ManyTurns", "a free rotor, 10 000 turns", many_turns, true},
            {"FastTop", "a heavy top at 1000 rad/s", fast_top}};
}

} // namespace gudgeon::hard
