// The exact Newton matrix of all stages of an implicit step on the stabilised index-2 equations (gear.hpp):
// each stage with its own derivatives. Where stages lie on both sides of a singular position of the
// constraints no single matrix serves them all: the small singular values of G change their sign in between.
//
// Unknowns of stage i: changes of velocities v, poses p (along T(q)), multipliers l, and of the multipliers m
// of the position constraints. Rows:
//   momentum    sum_j a_ij M v_j + C_i v_i + S_i p_i + G_i^T l_i
//   poses       sum_j M (P_ij p_j - V_ij v_j) - G_i^T m_i
//   velocity    G_i v_i + R_i p_i - E l_i,   R = d(G u)/dq
//   position    G_i p_i - E m_i
// E as in SaddleMatrix, but smaller: it serves rows that repeat others always; rows that repeat others at the
// singular position only are to be solved next to it.
#pragma once

#include "core/assembly.hpp"
#include "solvers/klu_solver.hpp"

#include <Eigen/Core>

#include <memory>
#include <span>
#include <vector>

namespace gudgeon {

class StageMatrix {
  public:
    static constexpr double softness = 1e-12; // of the diagonal of G M^-1 G^T / a

    StageMatrix(const System& system, int stages);

    /// Derivatives of a stage: ws after linearise() and evaluate_rate_rows() there. Friction states are left
    /// out of them.
    void set_stage(int stage, const Workspace& ws);
    /// a_ij (1/s), and the translations' part of V_ij (s); their part of P_ij is the unit matrix.
    void couple(const Eigen::MatrixXd& momentum, const Eigen::MatrixXd& translation);
    /// Rotations of a body: P_ij and V_ij (s).
    Mat3& pose_turn(int i, int j, int body) { return pose_turn_[index(i, j, body)]; }
    Mat3& rate_turn(int i, int j, int body) { return rate_turn_[index(i, j, body)]; }

    /// Factors depend on nothing before the last start_over().
    FactorStatus factor();
    void start_over() { klu_->forget_pivots(); }

    /// Right-hand side, then solution: parts of a stage.
    Eigen::Ref<VecX> velocities(int stage) { return rhs_.segment(stage * n_, n_); }
    Eigen::Ref<VecX> poses(int stage) { return rhs_.segment((stages_ + stage) * n_, n_); }
    Eigen::Ref<VecX> multipliers(int stage) { return rhs_.segment(2 * stages_ * n_ + stage * m_, m_); }
    Eigen::Ref<VecX> position_multipliers(int stage) {
        return rhs_.segment(2 * stages_ * n_ + (stages_ + stage) * m_, m_);
    }
    void solve() { klu_->solve({rhs_.data(), static_cast<std::size_t>(rhs_.size())}); }
    /// out = M^-1 G_i^T x
    void drift(int stage, const Eigen::Ref<const VecX>& x, VecX& out) const;

    const LinearSolverCounts& counts() const { return klu_->counts(); }

  private:
    struct Stage {
        std::vector<double> C, S, rows, rate_rows;
        std::vector<Linearisation::ReactionCoupling> reactions;
    };
    std::size_t index(int i, int j, int body) const {
        return (static_cast<std::size_t>(i) * stages_ + j) * system_.moving + body;
    }
    /// Calls put(row, column, value) for every entry, always in the same order; entries may repeat.
    template <class Put> void each_entry(Put&& put) const;
    template <class Put> void inertia_entries(int i, int j, Put&& put) const;
    template <class Put> void force_entries(int i, Put&& put) const;
    template <class Put> void row_entries(int i, Put&& put) const;
    void analyse();
    std::vector<int> ordering() const;

    const System& system_;
    const int stages_, n_, m_;
    std::vector<Stage> stage_;
    Eigen::MatrixXd momentum_, translation_;
    std::vector<Mat3> pose_turn_, rate_turn_;
    CscPattern pattern_;
    std::vector<int> slot_; // one per call of put
    std::vector<double> values_;
    VecX rhs_;
    std::unique_ptr<KluSolver> klu_;
};

} // namespace gudgeon
