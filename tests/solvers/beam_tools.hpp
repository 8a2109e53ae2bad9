// Beams under load and their closed forms.
#pragma once

#include "core/beam.hpp"
#include "solvers/modes.hpp"
#include "solvers/statics.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gudgeon::test {

/// 1 m long, x along X and y along Y; a steel bar, twice as wide as high.
inline Beam steel_bar(int elements, double height = 0.01) {
    Beam beam;
    beam.name = "rod";
    beam.points = {Vec3::Zero(), Vec3(1, 0, 0)};
    beam.direction = Vec3::UnitY();
    beam.section = RectangleSection{2 * height, height};
    beam.material = {2.1e11, 0.3, 7850, 0, {}};
    beam.elements = elements;
    return beam;
}

/// The start held fast; no weight.
inline Model clamped(const Beam& beam) {
    Model model;
    model.gravity.setZero();
    model.beams = {beam};
    model.joints = {make_joint("clamp", JointKind::rigid, "ground", beam.name + ".start", beam.points[0])};
    return model;
}

inline AppliedForce load_at_end(const Beam& beam, const Vec3& vector, bool torque) {
    AppliedForce load;
    load.name = "load";
    load.body = beam.name + ".end";
    load.torque = torque;
    load.point = beam.points[1];
    load.vector = vector;
    return load;
}

struct BeamEnd {
    Vec3 shift; // m
    Mat3 turn;
};

/// How the end of the beam stands at rest under what the model holds.
inline BeamEnd end_at_rest(const Model& model) {
    const System system = compiled(model);
    State state = initial_state(system);
    EXPECT_TRUE(assemble_start(system, state).ok);
    const StaticsReport report = find_equilibrium(system, state);
    EXPECT_TRUE(report.ok) << report.message;
    Workspace ws = make_workspace(system);
    set_motion(system, state.q, state.u, ws);
    for (const MarkerRecord& marker : system.markers)
        if (marker.name == model.beams[0].name + ".end") {
            const BodyMotion& now = ws.motion[marker.body];
            return {point_position(now, marker.point) - model.beams[0].points[1],
                    now.A * beam_axes(model.beams[0]).transpose()};
        }
    throw std::runtime_error("no end");
}

/// Inextensible cantilever with a dead force across its end, load = P L^2 / (E I): Bisshopp & Drucker,
/// Quart. Appl. Math. 3 (1945). Along and across the straight beam, over its length.
inline std::array<double, 2> elastica_tip(double load) {
    double low = 0, high = pi / 2;
    const auto elliptic = [](double tip, auto integral, auto complete) {
        const double k = std::sqrt((1 + std::sin(tip)) / 2);
        return complete(k) - integral(k, std::asin(1 / (k * std::sqrt(2.0))));
    };
    const auto first = [&](double tip) {
        return elliptic(
            tip, [](double k, double a) { return std::ellint_1(k, a); },
            [](double k) { return std::comp_ellint_1(k); });
    };
    for (int i = 0; i < 100; ++i) {
        const double middle = (low + high) / 2;
        (first(middle) < std::sqrt(load) ? low : high) = middle;
    }
    const double second = elliptic(
        low, [](double k, double a) { return std::ellint_2(k, a); },
        [](double k) { return std::comp_ellint_2(k); });
    return {std::sqrt(2 * std::sin(low) / load), 1 - 2 * second / std::sqrt(load)};
}

/// Frequencies (rad/s) of the modes that move mostly along `axis` (0..2) or turn mostly about x (3).
inline std::vector<double> frequencies(const Model& model, int axis, double size = 0.01) {
    const System system = compiled(model);
    State state = initial_state(system);
    EXPECT_TRUE(assemble_start(system, state).ok);
    ModesOptions options;
    options.count = 0;
    const ModesReport report = find_modes(system, state, options);
    std::vector<double> out;
    for (const Mode& mode : report.modes) {
        if (mode.kind == Mode::Kind::neutral)
            continue;
        std::array<double, 4> share{};
        for (int i = 0; i < system.moving; ++i) {
            for (int k = 0; k < 3; ++k)
                share[k] += std::norm(mode.shape[6 * i + k]);
            share[3] += size * size * std::norm(mode.shape[6 * i + 3]);
        }
        if (std::max_element(share.begin(), share.end()) - share.begin() == axis)
            out.push_back(mode.omega());
    }
    std::sort(out.begin(), out.end());
    return out;
}

/// Slope of log |error| against log n by least squares, with the sign changed.
inline double observed_order(const std::vector<int>& n, const std::vector<double>& error) {
    double x = 0, y = 0, xx = 0, xy = 0;
    const double count = static_cast<double>(n.size());
    for (std::size_t i = 0; i < n.size(); ++i) {
        const double a = std::log(n[i]), b = std::log(std::abs(error[i]));
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    return -(count * xy - x * y) / (count * xx - x * x);
}

} // namespace gudgeon::test
