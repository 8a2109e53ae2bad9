// The linearised equations of a mechanism at a state, as modes need them.
#pragma once

#include "solvers/constrained_matrix.hpp"

#include <complex>

namespace gudgeon {

class Linearised {
  public:
    Linearised(const System& system, const State& state);

    const System& system() const { return system_; }
    /// w = (p, r / sigma) of y = (x, v / sigma): (A - sigma B)^-1 B in first-order form.
    void factor(double sigma); // throws std::runtime_error where it is singular
    double sigma() const { return sigma_; }
    void shift_invert(const double* y, double* w);

    void mass_of(const VecX& x, VecX& out) const { mass_times(system_, x, out); }
    void damping_of(const VecX& x, VecX& out) const { blocks_times(system_, ws_.lin.C, x, out); }
    void stiffness_of(const VecX& x, VecX& out) const { blocks_times(system_, ws_.lin.S, x, out); }
    /// Dense matrices, for small mechanisms.
    MatX mass() const, damping() const, stiffness() const, rows() const;

    double cancelling(const VecX& x) const { return cancelling_stiffness(system_, ws_, x); }
    double stiffness_scale() const { return scale_; } // 1/s2
    /// Root of the quadratic form of x nearest to s.
    std::complex<double> refined(const Eigen::VectorXcd& x, std::complex<double> s) const;

  private:
    const System& system_;
    mutable Workspace ws_;
    ConstrainedMatrix matrix_;
    double sigma_ = 0, scale_ = 1;
    VecX x_, v_, mx_, cx_, force_, none_;
};

} // namespace gudgeon
