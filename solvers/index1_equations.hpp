// Accelerations and multipliers from the acceleration equations (AP 1, AU 8):
//
//   [ M  G^T ] [ u'     ]   [ f             ]
//   [ G  0   ] [ lambda ] = [ gamma + extra ]
//
// by sparse LU of the saddle-point matrix, whose pattern is analysed once.
#pragma once

#include "core/assembly.hpp"
#include "solvers/integrator.hpp"
#include "solvers/klu_solver.hpp"

#include <string>
#include <vector>

namespace gudgeon {

class Index1Equations {
  public:
    explicit Index1Equations(const System& system, Rows rows = Rows::independent);

    /// Where rows repeat each other (told at first, or found by a singular matrix) any multipliers that give
    /// the motion will do. At ws.motion. Leaves the forces in ws.f, Phi and G u + dPhi/dt in ws.phi and
    /// ws.rate, G in ws.rows. extra: one per row (m/s2), null for none. acceleration and lambda have their
    /// sizes already.
    FactorStatus solve(double t, Workspace& ws, const VecX* extra, VecX& acceleration, VecX& lambda);

    /// The matrix of respond() at ws.rows without the rest of a solve.
    FactorStatus prepare(const Workspace& ws);

    /// Change of the accelerations by `extra` alone, with the matrix of the last solve() or prepare().
    void respond(const Workspace& ws, const VecX& extra, VecX& acceleration);

    /// Writes the counts and times of all solves so far.
    void report(Statistics& statistics) const;

    void visit(Archive& archive);

    /// "joint B (displacement along x)" or "body rod" for a column without a pivot.
    std::string name_of(int column) const;

  private:
    void settle_reactions(double t, Workspace& ws, VecX& acceleration, VecX& lambda);

    void use(Rows rows);
    FactorStatus factor(const Workspace& ws);
    void close_rows(const Workspace& ws, const VecX& target);

    const System& system_;
    Rows rows_;
    SaddleMatrix matrix_;
    KluSolver klu_;
    std::vector<double> values_;
    VecX gamma_, unknowns_, solution_, acceleration_, target_, residual_;
    long evaluations_ = 0;
    PhaseTimes seconds_;
};

/// What a message calls a constraint row: joint and direction.
std::string row_name(const System& system, int row);

} // namespace gudgeon
