// Eigenfrequencies, damping ratios and mode shapes of a mechanism linearised about a state.
//
//   (s^2 M + s C + S) x + G^T mu = 0,   G x = 0
//
// x: 6 per moving body, m (global) and rad. C = -df/du with the gyroscopic terms of the spins of the state,
// S = -df/dq + d(G^T lambda)/dq with its multipliers. Rotations are taken about axes that do not turn with
// the bodies, so a rotor that spins about an axis of symmetry has constant coefficients. About a state that
// changes by itself the roots are those of the instant.
//
// Small mechanisms: dense, in coordinates of the null space of G. Large ones: Arnoldi's method with implicit
// restarts (Spectra) on (A - sigma B)^-1 B of the first-order form, by sparse LU of the saddle-point matrix
// sigma^2 M + sigma C + S; what is found is deflated and the search goes on until nothing is missing, so
// repeated roots come out as often as they occur.
#pragma once

#include "core/state.hpp"

#include <complex>
#include <string>
#include <vector>

namespace gudgeon {

struct ModesOptions {
    int count = 10;        // modes beside the neutral ones, lowest |s| first; 0: all of a small mechanism
    int dense_up_to = 300; // velocities
};

struct Mode {
    enum class Kind { neutral, vibration, overdamped, unstable } kind;
    std::complex<double> root; // 1/s; of a pair the one with the positive imaginary part
    /// Six per moving body: displacement (m, global) and rotation (rad, body axes); largest entry 1.
    Eigen::VectorXcd shape;

    double omega() const { return std::abs(root); }               // rad/s, undamped
    double damped_omega() const { return std::abs(root.imag()); } // rad/s
    double hertz() const { return damped_omega() / (2 * pi); }    // Hz, of the vibration as it is seen
    double damping() const { return omega() > 0 ? -root.real() / omega() : 0; } // ratio; < 0: grows
};

const char* mode_kind_name(Mode::Kind kind);

struct ModesReport {
    std::vector<Mode> modes; // neutral ones first, then by omega
    int neutral = 0, unstable = 0;
    std::string solver; // "dense", "arnoldi"
    double shift = 0;   // 1/s
};

/// Throws std::runtime_error where the constrained matrix stays singular or the search does not converge.
ModesReport find_modes(const System& system, const State& state, const ModesOptions& options = {});

/// The same model without friction anywhere: at rest friction has no linearisation but its regularisation's.
Model without_friction(Model model);

} // namespace gudgeon
