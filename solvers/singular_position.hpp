// Singular positions: poses in which constraint rows that are independent elsewhere repeat each other, such
// as the flat position of a parallelogram. The mechanism has more than one way to go on there.
#pragma once

#include "core/assembly.hpp"
#include "solvers/klu_solver.hpp"

#include <string>
#include <vector>

namespace gudgeon {

/// What the constraints resist least at a pose, of what they resist at all: a velocity v of unit kinetic
/// energy times two, and multipliers w of unit length with w^T G v = sigma > 0, the smallest singular value
/// of G M^-1/2 above 1e-4 of the others. A singular position on the way is where w^T G v changes its sign.
class WeakestRows {
  public:
    explicit WeakestRows(const System& system);

    /// At q (velocities u matter to no holonomic row); by inverse iteration. False: no such direction.
    bool find(double t, const VecX& q, const VecX& u, Workspace& ws);
    double sigma() const { return sigma_; }
    /// w^T G v at another pose.
    double along(double t, const VecX& q, const VecX& u, Workspace& ws);
    const VecX& rows() const { return w_; }

  private:
    void apply(VecX& z, const Workspace& ws);

    const System& system_;
    SaddleMatrix saddle_;
    KluSolver klu_;
    std::vector<double> values_, rhs_;
    VecX w_, v_, part_;
    double sigma_ = 0;
};

/// "'A' (displacement along h), 'B' (...)": the rows with the largest numbers, at most six.
std::string names_of_rows(const System& system, const VecX& number);

/// Rows that come to repeat each other within this time (s) of a state, by its velocities carried on and
/// back; empty: none. w^T G v falls to a small share there or changes its sign.
std::string singular_rows(const System& system, const State& state, double within);

/// Why no motion, or no single one, begins at a state whose rows repeat each other; empty: one does. At a
/// singular position accelerations exist only for velocities along one of the branches; at rest the forces
/// decide, unless what they begin is along none of them.
std::string undecided_start(const System& system, const State& state);

} // namespace gudgeon
