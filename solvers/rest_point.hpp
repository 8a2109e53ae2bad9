// A mechanism at rest at one pose: forces, the part of them that no constraint takes up, stiffness.
#pragma once

#include "solvers/consistent.hpp"
#include "solvers/constrained_matrix.hpp"

#include <vector>

namespace gudgeon {

class RestPoint {
  public:
    /// Time and angle branches are those of the state; contacts push elastically.
    RestPoint(const System& system, const State& state, const std::vector<int>& dependent);

    /// Forces, multipliers and what is left over at a pose. False: a force is not finite or the mass matrix
    /// with the constraints is singular.
    bool evaluate(const VecX& q);

    VecX left;   // f - G^T lambda of the last evaluate(), tangential to the constraints
    VecX lambda; // least in M^-1 what is left over
    double
    force_scale() const; // the largest force or moment that acts (N, N m), of bodies, batches, reactions

    /// S at the last evaluated pose, with its multipliers; C is zero.
    void linearise();
    /// Largest entry of S, N/m and N m.
    double largest_stiffness() const;
    FactorStatus factor(double a);
    /// (x, multipliers) of [a M + S, G^T; G, 0].
    void solve(VecX& force, VecX& residual) { matrix_.solve(force, residual); }
    void solve(MatX& force) { matrix_.solve(force); }
    void stiffness_times(const VecX& x, VecX& out) const;

    /// Angle branches follow the pose; call at every accepted step.
    void follow_angles();

    /// Potential and elastic energy (J) at the last evaluated pose.
    double energy();
    /// Work per step of what stores none of it (J): applied forces, actuators.
    double applied_work(const VecX& q, const VecX& step);

    const VecX& rest() const { return rest_; } // zero velocities
    double largest_constraint() const;
    /// Least frequency squared that matters, 1/s2: largest acceleration of a free body over the size.
    double stiffness_scale() const { return stiffness_scale_; }
    double size() const { return size_; } // m, of the mechanism
    Workspace& workspace() { return ws_; }
    const Workspace& workspace() const { return ws_; }
    int factorisations() const;

  private:
    void find_scales(const State& state);

    const System& system_;
    Workspace ws_;
    ConstrainedMatrix mass_, matrix_;
    VecX rest_, acceleration_, residual_;
    double t_, size_ = 0, stiffness_scale_ = 1;
};

/// Largest distance between bodies and joints of a mechanism, m; 0.1 for a single point.
double mechanism_size(const System& system);
/// Median distance of a body's mass centre to its farthest joint, m; that of the mechanism where there is
/// none.
double body_size(const System& system);

} // namespace gudgeon
