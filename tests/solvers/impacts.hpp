// A ball in a socket and what closed forms say of one impact.
#pragma once

#include "models/builders.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon::hard_cases {

inline ContactLaw law_of(const std::string& kind, double stiffness, double restitution) {
    ContactLaw law;
    law.kind = kind;
    law.stiffness = stiffness;
    if (kind != "hertz")
        law.restitution = restitution;
    return law;
}

/// Lankarani and Nikravesh's factor.
inline double factor(double restitution) { return 0.75 * (1 - restitution * restitution); }

/// Speed after an impact over the speed before, f = K d^n (1 + chi rho) alone on a mass: from
/// v dv / (1 + chi v/v0) = -K d^n dd / m, equal on both branches: chi - ln(1 + chi) = -chi r - ln(1 - chi r).
inline double speed_ratio(double chi) {
    double low = 0, high = std::min(1.0, 1 / chi);
    for (int i = 0; i < 100; ++i) {
        const double r = 0.5 * (low + high);
        (-chi * r - std::log1p(-chi * r) < chi - std::log1p(chi) ? low : high) = r;
    }
    return low;
}

/// The greatest depth of that impact, n = 3/2: the same integral from v0 to 0.
inline double impact_depth(double chi, double mass, double speed, double stiffness) {
    return std::pow(2.5 * mass * speed * speed * (chi - std::log1p(chi)) / (chi * chi * stiffness), 0.4);
}

/// A ball of 1 kg in a fixed socket, centred at rest; no weight.
inline Model ball(const ContactLaw& law, double radial) {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("ball", 1, {1e-3, 1e-3, 1e-3}, Vec3::Zero())};
    Joint joint = make_joint("S", JointKind::spherical, "ground", "ball", Vec3::Zero());
    joint.fidelity = Fidelity::clearance;
    joint.clearance = Clearance{};
    joint.clearance->radial = radial;
    joint.clearance->law = law;
    joint.body_frame = true; // the socket stays where it is
    joint.points = {Vec3::Zero(), Vec3::Zero()};
    model.joints = {joint};
    return model;
}

/// The same with weight, at rest at this height over the socket's lowest point (below it: negative).
inline Model ball_above(const ContactLaw& law, double height) {
    Model model = ball(law, 1e-3);
    model.gravity = {0, 0, -9.81};
    model.bodies[0].position = {0, 0, height - 1e-3};
    return model;
}

} // namespace gudgeon::hard_cases
