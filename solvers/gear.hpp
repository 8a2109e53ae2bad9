// Gear's method: variable-order (1-5), variable-step BDF of the stabilised index-2 equations
//   q' = T(q) u - T(q) M^-1 G^T mu,  M u' = f - G^T lambda,  0 = Phi,  0 = G u + dPhi/dt
// (Gear, Gupta & Leimkuhler 1985; Gear 1971). Each sweep of the corrector solves with one matrix
//   K = [a0 M + C + S/a0, G^T; G, 0]
// for the velocity and multiplier change (from the momentum and velocity residuals) and for a position
// correction that closes Phi in K's metric; mu itself never appears.
#pragma once

#include "solvers/bdf_history.hpp"
#include "solvers/implicit_integrator.hpp"
#include "solvers/stage_matrix.hpp"

namespace gudgeon {

class Gear final : public ImplicitIntegrator {
  public:
    Gear(const System& system, const IntegratorOptions& options);

    const char* name() const override { return "gear"; }
    void start(const State& state) override;
    void visit(Archive& archive) override;
    void interpolate(double t, State& out) const override;
    void kink() override { kink_ = state_.t; }

  private:
    // gear.cpp: steps and control
    StepOutcome attempt(double t_stop, bool& accepted) override;
    double first_step(const VecX& q_rate, const VecX& u_rate);
    void forgive_stiff_part(double constant);
    void accept(double t, double h, double error);
    void push_bodies(const VecX& q, const VecX& u, double t);
    void shorten(double t, double h);
    void choose_next(double error);
    double error_at_order(int order, const VecX& q, const VecX& u);
    void integrate_powers(double t);
    void weigh_matrix();
    double work() const; // so far, in sweeps

    // gear_corrector.cpp: one implicit step
    void predict(double t);
    Corrector correct(double t);
    Corrector refresh_matrix(double t);
    void residual(double t);
    void settle_states(double t);
    bool multipliers_settled();
    void move_end() override;
    bool renew_matrix(double t) override;
    double q_per_u() const override { return 1 / a0_; }
    const VecX& end_q() const override { return history_.next_q(); }
    const VecX& end_u() const override { return history_.next_u(); }
    StepFormula formula() const { return {a0_, beta_q_, beta_u_}; }
    /// History of q and u of the bodies, where contacts ask for it.
    const BdfHistory& bodies() const { return on_tree() ? bodies_ : history_; }
    void motion_in_step(double t, int body, BodyMotion& out) const override;
    void motion_carried_on(double t, int body, BodyMotion& out) const override;
    void carry_on(double t) override;

    // gear_exact.cpp: the same with new derivatives at every iteration
    Corrector correct_exactly(double t);
    ErrorNorm::Value free_error(double t, double constant);
    bool take_exact_solution();
    Corrector finish_exactly(double t);
    void linearise_end(double t);

    BdfHistory history_;                 // of x and w
    BdfHistory bodies_;                  // on a tree with contacts
    std::unique_ptr<StageMatrix> exact_; // made when first needed

    // the step being tried
    int order_ = 1;
    double kink_ = -1e300;       // s, end of the last step in which a contact began, or kink()
    bool contact_begun_ = false; // the last accepted step was that one
    int step_order_ = 1;         // of the last accepted step
    double t_try_ = 0, a0_ = 0;
    std::array<double, BdfHistory::capacity> a_{};
    VecX q_predicted_, u_predicted_, beta_q_, beta_u_;
    VecX z_predicted_, beta_z_, z_change_;
    VecX momentum_, step_, speeds_;
    mutable VecX q_between_, u_between_;
    State end_; // q and u of the bodies

    // memory between steps
    double matrix_a0_ = 0;  // a0 of the factored matrix, 0: none
    int lambda_points_ = 1; // of the multipliers' predictor
    bool matrix_fresh_ = false, refresh_wanted_ = false;
    double contraction_ = 0.5;
    double matrix_work_ = 0; // sweeps of the steps accepted with the present matrix, and its making
    int matrix_steps_ = 0;   // those steps
    double work_before_ = 0; // this try
    int real_points_ = 0;    // of the history, without the one made up at the start
    int order_cap_ = 5, cap_steps_ = 0;
    long last_rejection_ = -1000;
    int steps_at_order_ = 0;

    std::array<double, BdfHistory::capacity> power_t_{};
    std::array<VecX, BdfHistory::capacity> power_; // as State::work
    int powers_ = 0;
};

std::unique_ptr<Integrator> make_gear(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
