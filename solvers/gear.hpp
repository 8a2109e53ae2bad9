// Gear's method: variable-order (1-5), variable-step BDF of the stabilised index-2 equations
//   q' = T(q) u - T(q) M^-1 G^T mu,  M u' = f - G^T lambda,  0 = Phi,  0 = G u + dPhi/dt
// (Gear, Gupta & Leimkuhler 1985; Gear 1971). Each sweep of the corrector solves with one matrix
//   K = [a0 M + C + S/a0, G^T; G, 0]
// for the velocity and multiplier change (from the momentum and velocity residuals) and for a position
// correction that closes Phi in K's metric; mu itself never appears.
#pragma once

#include "core/assembly.hpp"
#include "solvers/bdf_history.hpp"
#include "solvers/consistent.hpp"
#include "solvers/error_norm.hpp"
#include "solvers/integrator.hpp"
#include "solvers/klu_solver.hpp"

namespace gudgeon {

class Gear final : public Integrator {
  public:
    Gear(const System& system, const IntegratorOptions& options);

    const char* name() const override { return "gear"; }
    const char* linear_solver() const override { return solver_.name(); }
    void start(const State& state) override;
    StepOutcome advance(double t_stop) override;
    const State& state() const override { return state_; }
    void interpolate(double t, State& out) const override;
    const Statistics& statistics() const override;
    Workspace& workspace() override { return ws_; }

  private:
    enum class Corrector { converged, slow, singular, non_finite };

    // gear.cpp: steps and control
    double first_step(const VecX& q_rate, const VecX& u_rate, double t_stop);
    StepOutcome attempt(double t_stop, bool& accepted);
    void accept(double t, double h, double error);
    void choose_next(double error);
    double error_at_order(int order, const VecX& q, const VecX& u);
    void reject(StepReason reason, double error);
    StepOutcome failure(StepReason reason, const std::string& what) const;
    void integrate_powers(double t);

    // gear_corrector.cpp: one implicit step
    void predict(double t);
    Corrector correct(double t);
    Corrector refresh_matrix(double t);
    void residual(double t);
    void apply_increment();
    void turn_to_velocity(int body, double* step);
    bool close_constraints(double t);
    std::string worst_part() const;

    const System& system_;
    IntegratorOptions options_;
    mutable Statistics statistics_;
    Workspace ws_;
    SaddleMatrix saddle_;
    KluSolver solver_;
    ConsistentSolver consistent_;
    ErrorNorm norm_;
    std::vector<double> values_; // of K
    State state_;
    BdfHistory history_;

    // the step being tried
    int order_ = 1;
    double h_ = 0, t_try_ = 0, a0_ = 0;
    std::array<double, BdfHistory::capacity> a_{};
    VecX q_predicted_, u_predicted_, beta_q_, beta_u_, drift_;
    VecX momentum_, rhs_, step_;
    double phi_worst_ = 0, rate_worst_ = 0;
    ErrorNorm::Value error_, increment_;

    // memory between steps
    double matrix_a0_ = 0; // a0 of the factored matrix, 0: none
    bool matrix_fresh_ = false, refresh_wanted_ = false;
    double contraction_ = 0.5;
    int real_points_ = 0; // of the history, without the one made up at the start
    int order_cap_ = 5, cap_steps_ = 0;
    long last_rejection_ = -1000;
    int steps_at_order_ = 0, rejections_in_row_ = 0;

    std::array<double, BdfHistory::capacity> power_t_{}, dissipated_power_{}, input_power_{};
    int powers_ = 0;
};

std::unique_ptr<Integrator> make_gear(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
