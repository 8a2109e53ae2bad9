// Radau IIA, three stages, order 5 (Hairer & Wanner 1996, IV.8 and VII.4), on the stabilised index-2
// equations of gear.hpp, with an adaptive step.
//
// Stage values: velocities u_n + V_i, coordinates q_n moved by Z_i = h A (T u)_j + X_i, multipliers L_i.
// Friction states follow the motion exactly: their collocation equations are linear once it is known.
// The X_i close Phi at the stages (they are the integral of the T M^-1 G^T mu term). With A^-1 = T Lambda
// T^-1 the simplified Newton iteration splits into one real and one complex system of the same form as
// Gear's: K(s) = [s M + C + S/s, G^T; G, 0], s = an eigenvalue of A^-1 over h.
#pragma once

#include "core/archive_state.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/block_solver.hpp"
#include "solvers/implicit_integrator.hpp"
#include "solvers/stage_matrix.hpp"

#include <array>
#include <complex>

namespace gudgeon {

class Radau final : public ImplicitIntegrator {
  public:
    Radau(const System& system, const IntegratorOptions& options);

    const char* name() const override { return "radau"; }
    void start(const State& state) override;
    void visit(Archive& archive) override;
    void interpolate(double t, State& out) const override;
    const Statistics& statistics() const override;

  private:
    static constexpr int stages = 3;
    /// q and u of the bodies at the start and the stages, on a tree with contacts.
    using BodyStages = std::array<State, stages + 1>;

    // radau.cpp: steps and control
    void analyse_complex();
    void soften() override;
    StepOutcome attempt(double t_stop, bool& accepted) override;
    double first_step(const VecX& acceleration) const;
    ErrorNorm::Value estimate_error(double t, double h);
    void accept(double t, double h, double error);

    // radau_corrector.cpp: the stage equations
    void predict(double h);
    Corrector correct(double t, double h);
    Corrector refresh_matrices(double h);
    Corrector refresh_real_matrix(double h);
    void linearise_in_step();
    void stage_residual(int stage, double t, double h);
    void solve_increments(double h);
    void solve_complex(std::complex<double> q_per_u);
    bool multipliers_settled() const;
    bool turn_to_velocities(double h);
    bool turn_to_velocity(const StepCoordinates::Piece& piece, const Mat3& hA);
    void settle_states(double t, double h);
    void start_forces();
    ErrorNorm::Value state_error(double t, double lag);
    void stage_coordinates(int stage, VecX& q) const;
    void note_bodies();
    void put_between(const BodyStages& bodies, const std::array<double, 4>& w, int body,
                     BodyMotion& out) const;
    void motion_in_step(double t, int body, BodyMotion& out) const override;
    void motion_carried_on(double t, int body, BodyMotion& out) const override;
    void carry_on(double t) override;
    void put_beyond(int body, const Vec6& step, const Vec6& u, BodyMotion& out) const;
    void move_end() override;
    double q_per_u() const override { return 0; }
    bool renew_matrix(double) override { return true; } // the next try gets new ones
    const VecX& end_q() const override { return q_end_; }
    const VecX& end_u() const override { return u_end_; }

    // radau_exact.cpp: the same with derivatives at every stage
    Corrector correct_exactly(double t, double h);
    ErrorNorm::Value free_error(double h);
    Corrector finish_exactly(double t, double h);
    void linearise_stages(double t, double h);
    void couple_stages(double h);
    void move_stages();

    std::unique_ptr<StageMatrix> exact_; // made when first needed
    ComplexBlockSolver complex_;         // of the complex matrix, or, with the augmented Lagrangian ...
    std::unique_ptr<AugmentedPairSolver> pair_; // ... this
    std::vector<std::complex<double>> complex_values_;
    State previous_;                  // beginning of the last accepted step
    VecX x_, w_;                      // of state_
    VecX previous_x_, previous_w_;    // of previous_
    BodyStages bodies_, last_bodies_; // of the step being tried, of the last accepted one

    std::array<VecX, stages> V_, Z_, X_, lambda_; // of the step being tried
    std::array<VecX, stages> stage_rhs_;          // per stage: momentum and velocity residual; positions
    std::vector<std::complex<double>> complex_rhs_, complex_turn_;
    VecX q_stage_, u_stage_, q_end_, u_end_, speeds_, momentum_, slope_, error_u_, error_q_, f_start_, rate_;
    std::array<VecX, stages> z_, source_i_, decay_i_; // friction states at the stages, their terms
    VecX z_matrix_decay_, z_step_, error_z_;
    double lambda_change_ = 0;       // of the last sweep
    double z_change_ = 0;            // norm, in the last settle_states()
    std::array<VecX, stages> power_; // as State::work

    // memory between steps; the collocation polynomials of the last accepted step
    std::array<VecX, stages> last_V_, last_Z_, last_lambda_, last_z_;
    VecX last_lambda_start_;
    double last_h_ = 0, matrix_h_ = 0, matrix_t_ = 0;
    double contraction_ = 0.1, last_error_ = 1e-2;
    double failed_h_ = 0; // step for which the corrector failed last, slowly forgotten
    int steps_since_failure_ = 0;
    int sweeps_ = 0;
    double step_tried_ = 0;
    bool have_last_ = false, matrix_current_ = false;
};

std::unique_ptr<Integrator> make_radau(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
