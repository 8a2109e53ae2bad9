// States that satisfy the constraints: projection in the mass norm, accelerations and reactions.
#pragma once

#include "core/sparse.hpp"
#include "core/state.hpp"
#include "solvers/cholmod_solver.hpp"

#include <utility>
#include <vector>

namespace gudgeon {

/// Solves with N = G W G^T, W the inverse mass matrix (zero along coordinates that are held).
/// One object per thread of use; the pattern is analysed once.
class ConsistentSolver {
  public:
    explicit ConsistentSolver(const System& system);

    /// Least change of q in the mass norm to |Phi| <= tolerance (m, rad). False: did not close.
    bool project_positions(double t, VecX& q, const VecX& u, Workspace& ws, double tolerance = 1e-13);

    /// Least change of u in the mass norm to G u + dPhi/dt = 0 at q.
    bool project_velocities(double t, const VecX& q, VecX& u, Workspace& ws);

    /// Accelerations and multipliers from the acceleration equations (AP 1) at a consistent state:
    /// M u' + G^T lambda = f, G u' = gamma. Where rows repeat each other the multipliers are the least ones
    /// (redundancy.hpp says in which measure). False: no finite solution.
    bool accelerations(double t, const VecX& q, const VecX& u, Workspace& ws, VecX& acceleration,
                       VecX& lambda);

    /// Coordinates held in the two projections: bits as in System::hold; all zero by default.
    void hold(std::vector<unsigned> bits) { hold_ = std::move(bits); }

    /// Adds beta to the diagonal of N, relative to it: lets redundant rows pass in the projections.
    void regularise(double beta) { beta_ = beta; }

    /// Rows may repeat each other: N gets a small diagonal E, each solve is repeated until the residual is
    /// gone, and multipliers lose what moves nothing. Happens by itself at the first singular N.
    void soften();
    bool soft() const { return !soft_weight_.empty(); }
    /// Rows that repeat others, by the pivots of the last N; 0 for rows that are not soft.
    int deficiency() const;

    /// G u' - gamma of the last accelerations(): what no accelerations can meet, 0 but at singular positions
    /// where velocities belong to no motion.
    const VecX& unmet() const { return unmet_; }

    /// Longest change of one coordinate in an iteration of project_positions.
    static constexpr double unlimited = 1e300;
    void limit_move(double longest) { largest_move_ = longest; }

    double worst_position() const { return worst_position_; }
    double worst_velocity() const { return worst_velocity_; }

  private:
    CscPattern build_pattern();
    bool factor(const Workspace& ws, int held_shift, double beta);
    FactorStatus factor_once(const Workspace& ws, int held_shift, double beta, double smallest_pivot);
    void place_softness();
    void solve_normal(VecX& x);
    void drop_idle_part(VecX& lambda);
    void solve_accelerations(double t, Workspace& ws, VecX& acceleration, VecX& lambda);
    Mat3 held_root(int body, int held_shift) const;
    void apply_inverse_mass(int held_shift, VecX& x) const;
    void solve_step(const Workspace& ws, const VecX& residual, int held_shift);

    const System& system_;
    NormalSolver normal_;
    std::vector<int> slot_;  // twelve per row: entry of B = G W^{1/2}, rows of G by columns of u; -1: none
    std::vector<Mat3> root_; // inverse inertia = root root^T
    std::vector<double> values_;
    std::vector<unsigned> hold_;
    double beta_ = 0, worst_position_ = 0, worst_velocity_ = 0;
    double largest_move_ = unlimited;
    VecX nu_, step_, gamma_, scale_, unmet_;
    std::vector<int> soft_slot_;          // of the square roots of E
    std::vector<double> soft_weight_, E_; // measure of the multipliers; E = softness times it, one per row
    VecX idle_;
};

} // namespace gudgeon
