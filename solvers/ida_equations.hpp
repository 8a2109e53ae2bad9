// The equations of motion as F(t, y, y') = 0, stabilised index 2 (Gear, Gupta & Leimkuhler 1985), in the
// full form a general DAE code wants. Internal to the ida integrator and its tests.
//
// Unknowns y = (q, u, z, lambda, mu, nu): 7 and 6 per moving body, the friction states, 2 per constraint
// row, 1 per moving body; equations in the same order:
//
//   r' - v + (M^-1 G^T mu)_r                                 = 0
//   p' - 1/2 L(p)^T (omega' - (M^-1 G^T mu)_theta) + 2 p nu  = 0
//   M u' - f(q, u, z, lambda, t) + G^T lambda                = 0
//   z' - source(q, u) + decay(q, u) z                        = 0
//   G u + dPhi/dt                                            = 0
//   Phi(q, t)                                                = 0
//   p.p - 1                                                  = 0
//
// nu keeps the Euler parameters at unit length in the way mu keeps Phi = 0; both vanish in the exact
// solution. Forces and constraints are those of p / |p|.
#pragma once

#include "core/assembly.hpp"

#include <span>
#include <string>
#include <vector>

namespace gudgeon {

class IdaEquations {
  public:
    explicit IdaEquations(const System& system, Rows rows = Rows::independent, int threads = 1);

    int size() const { return nu0_ + system_.moving; }
    int u0() const { return u0_; }
    int z0() const { return z0_; }
    int lambda0() const { return lambda0_; } // first multiplier, and first velocity constraint
    int mu0() const { return mu0_; }         // first position constraint
    int nu0() const { return nu0_; }

    /// q, u, z and lambda of a state; mu = nu = 0.
    void pack(const State& state, double* y) const;
    /// q (normalised), u, z and lambda into a state.
    void unpack(const double* y, State& state) const;
    /// q' = T(q) u, u' = acceleration and z', the rest zero: y' where mu = nu = 0. Reads ws.motion for z'.
    void pack_rates(double t, const double* y, const VecX& acceleration, double* ydot);

    /// Pose, velocity and multipliers of y into the workspace.
    void set(const double* y);
    const VecX& lambda() const { return lambda_; }

    /// F at (t, y, y'). False where it is not finite.
    bool residual(double t, const double* y, const double* ydot, double* out);

    /// dF/dy + cj dF/dy', compressed by columns; d(M^-1 G^T)/dq mu is left out as mu is about zero,
    /// and d(z')/dq.
    const CscPattern& pattern() const { return pattern_; }
    void jacobian(double t, double cj, const double* y, std::span<double> values);

    /// "body rod" or "joint B (displacement along x)": where an unknown or an equation belongs.
    std::string name_of(int unknown) const;

    Workspace& workspace() { return ws_; }

  private:
    template <class Emit> void visit(double cj, Emit&& emit) const;
    template <class Emit> void visit_softness(double cj, Emit&& emit) const;
    template <class Emit> void visit_body(int i, double cj, Emit&& emit) const;
    template <class Emit> void visit_blocks(Emit&& emit) const;
    template <class Emit> void visit_states(double cj, Emit&& emit) const;
    template <class Emit> void visit_reactions(Emit&& emit) const;
    template <class Emit> void visit_side(int row, int side, Emit&& emit) const;
    void build_pattern();

    const System& system_;
    Rows rows_;
    const int u0_, z0_, lambda0_, mu0_, nu0_;
    Workspace ws_;
    VecX q_, u_, lambda_, mu_, nu_, drift_; // drift = M^-1 G^T mu
    VecX source_, decay_;                   // of the friction states
    std::vector<double> rate_rows_;         // d(G u)/dq, 12 per row
    std::vector<Eigen::Matrix<double, 3, 4>> turn_;
    CscPattern pattern_;
    std::vector<int> slot_; // of each visited coefficient, in the order of the visit
};

} // namespace gudgeon
