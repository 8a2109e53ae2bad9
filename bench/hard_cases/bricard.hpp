// Bricard's linkage along six edges of a cube: six bars of 1 m, axes of neighbouring joints at right angles,
// the sixth bar fixed. The 36 - 6 freedoms and 30 rows would leave none; one row repeats others, so it moves.
#pragma once

#include "core/types.hpp"
#include "models/builders.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace gudgeon::hard {

/// The motion with threefold symmetry. Angles theta at joints 1, 3, 5 and phi at 2, 4, 6 (both a right angle
/// along the cube) close the loop where cos theta + cos phi + cos theta cos phi = 0 (Chen, You & Tarnai 2005,
/// twist of a right angle). With a, b = (theta +- phi)/2 that is cos a + cos b = 1, a closed curve, here with
/// the polar angle psi of (a, b) as its parameter; psi = 0 is the cube.
class Bricard {
  public:
    static constexpr int bars = 5;
    static constexpr double width = 5e-5, across = 1.0 / 12; // inertia of a bar about its length, across it

    struct Turn {
        double theta, phi, theta_rate, phi_rate; // rates: by psi
    };
    static Turn turn(double psi) {
        const double c = std::cos(psi), s = std::sin(psi);
        double rho = 1.6;
        for (int i = 0; i < 30; ++i)
            rho +=
                (std::cos(rho * c) + std::cos(rho * s) - 1) / (c * std::sin(rho * c) + s * std::sin(rho * s));
        const double a = rho * c, b = rho * s, sa = std::sin(a), sb = std::sin(b);
        const double rho_rate = rho * (s * sa - c * sb) / (c * sa + s * sb);
        const double a_rate = rho_rate * c - rho * s, b_rate = rho_rate * s + rho * c;
        return {a + b, a - b, a_rate + b_rate, a_rate - b_rate};
    }

    static const std::array<Vec3, 7>& corners() {
        static const std::array<Vec3, 7> all{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 1, 1),
                                             Vec3(0, 1, 1), Vec3(0, 0, 1), Vec3(0, 0, 0)};
        return all;
    }
    /// Axes of the joints at the corners, along the cube; joint 1 at the first.
    static const std::array<Vec3, 6>& axes() {
        static const std::array<Vec3, 6> all{Vec3(0, 1, 0),  Vec3(0, 0, 1),  Vec3(-1, 0, 0),
                                             Vec3(0, -1, 0), Vec3(0, 0, -1), Vec3(1, 0, 0)};
        return all;
    }

    struct Bar {
        Mat3 turned;       // from the cube
        Vec3 centre, v, w; // global; v, w: by psi
    };
    struct Pose {
        std::array<Bar, bars> bar;
        double open; // the sixth bar against its place
    };
    static Pose pose(double psi) {
        const Turn now = turn(psi);
        Pose out;
        Mat3 R = Mat3::Identity();
        Vec3 p = Vec3::Zero(), w = Vec3::Zero(), v0 = Vec3::Zero(); // v0: of the point at the origin
        for (int i = 0; i < 6; ++i) {
            const double angle = i % 2 ? now.phi - pi / 2 : pi / 2 - now.theta,
                         rate = i % 2 ? now.phi_rate : -now.theta_rate;
            const Vec3 axis = R * axes()[i], point = R * corners()[i] + p;
            const Mat3 own = Eigen::AngleAxisd(angle, axes()[i]).toRotationMatrix();
            p += R * (corners()[i] - own * corners()[i]);
            R = R * own;
            w += rate * axis;
            v0 -= rate * axis.cross(point);
            if (i < bars) {
                const Vec3 centre = R * (0.5 * (corners()[i] + corners()[i + 1])) + p;
                out.bar[i] = {R, centre, v0 + w.cross(centre), w};
            }
        }
        out.open = (R - Mat3::Identity()).norm() + p.norm();
        return out;
    }
    /// Twice the kinetic energy at psi' = 1, and the height of all mass centres.
    static double inertia(double psi) {
        double sum = 0;
        const Pose now = pose(psi);
        for (int i = 0; i < bars; ++i) {
            const Bar& b = now.bar[i];
            const double along = b.w.dot(b.turned * (corners()[i + 1] - corners()[i]));
            sum += b.v.squaredNorm() + across * (b.w.squaredNorm() - along * along) + width * along * along;
        }
        return sum;
    }
    static double height(double psi) {
        double sum = 0;
        for (const Bar& b : pose(psi).bar)
            sum += b.centre.z();
        return sum;
    }

    static Mat3 bar_axes(int i) { // along the cube: x along the bar
        const Vec3 x = corners()[i + 1] - corners()[i], y = axes()[i];
        Mat3 out;
        out << x, y, x.cross(y);
        return out;
    }
    static Model model(double psi, double rate) {
        const Pose start = pose(psi);
        Model model;
        model.name = "bricard";
        for (int i = 0; i < bars; ++i) {
            const Bar& b = start.bar[i];
            const Mat3 A = b.turned * bar_axes(i);
            Body body = make_body(fmt::format("bar{}", i + 1), 1, Vec3(width, across, across), b.centre);
            body.orientation = euler_parameters(A);
            body.velocity = rate * b.v;
            body.angular_velocity = A.transpose() * (rate * b.w);
            model.bodies.push_back(body);
        }
        for (int i = 0; i < 6; ++i) {
            const int at = i < bars ? i : bars - 1; // of a bar that the joint belongs to
            const Bar& b = start.bar[at];
            const Vec3 to_corner = corners()[i] - 0.5 * (corners()[at] + corners()[at + 1]);
            const std::string before = i == 0 ? "ground" : fmt::format("bar{}", i);
            const std::string after = i == bars ? "ground" : fmt::format("bar{}", i + 1);
            model.joints.push_back(make_joint(fmt::format("J{}", i + 1), JointKind::revolute, before, after,
                                              b.centre + b.turned * to_corner, b.turned * axes()[i]));
        }
        return model;
    }
};

} // namespace gudgeon::hard
