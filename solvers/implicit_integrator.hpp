// What the implicit integrators share: matrix, norm, state, closing of the constraints, messages.
#pragma once

#include "core/assembly.hpp"
#include "solvers/consistent.hpp"
#include "solvers/contact_watch.hpp"
#include "solvers/error_norm.hpp"
#include "solvers/formulation.hpp"
#include "solvers/integrator.hpp"
#include "solvers/step_coordinates.hpp"

#include <algorithm>

namespace gudgeon {

/// Largest magnitude, 0 of none.
inline double largest(const Eigen::Ref<const VecX>& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

class StageMatrix;

class ImplicitIntegrator : public Integrator {
  public:
    ImplicitIntegrator(const System& system, const IntegratorOptions& options);

    const char* linear_solver() const override { return solver_.name(); }
    const char* formulation() const override { return formulation_name(formulation_); }
    StepOutcome advance(double t_stop) override;
    const State& state() const override { return state_; }
    const Statistics& statistics() const override;
    void visit(Archive& archive) override;
    bool goes_on_exactly() const override { return formulation_ != Formulation::augmented_lagrangian; }
    Workspace& workspace() override { return ws_; }
    void set_on_contact(std::function<void(const ContactEvent&)> f) override {
        watch_.on_contact = std::move(f);
    }

  protected:
    static constexpr double round_off = 1e-15; // of residuals, relative to coordinates and velocities
    static constexpr double loose_multipliers = 0.03;
    static constexpr double closed = 1e-10; // m, m/s, rad: what every accepted step keeps

    enum class Corrector { converged, slow, singular, non_finite };

    /// A step to be tried: its end, its length, whether it ends at t_stop.
    struct Trial {
        double t, h;
        bool last;
    };

    /// One try of a step of h_; not ok: the run cannot go on.
    virtual StepOutcome attempt(double t_stop, bool& accepted) = 0;
    /// x and w (step_coordinates.hpp) at the end of the step being tried.
    virtual const VecX& end_q() const = 0;
    virtual const VecX& end_u() const = 0;
    /// Motion of a body at a time inside the step being tried.
    virtual void motion_in_step(double t, int body, BodyMotion& out) const = 0;
    /// The same beyond the last accepted step, by its polynomial.
    virtual void motion_carried_on(double t, int body, BodyMotion& out) const = 0;
    /// That of all bodies into ws_.motion.
    virtual void carry_on(double t) = 0;
    /// ws_.motion at that end.
    void set_end_motion() { coordinates_->set_motion(end_q(), end_u(), ws_); }
    /// Moves that end by a solution in rhs_: velocity and multiplier change; position correction.
    virtual void move_end() = 0;
    /// How far move_end() moves coordinates for a change of velocities, s.
    virtual double q_per_u() const = 0;
    /// A new matrix for the end of the step, unless it is new already; false if none can be made.
    virtual bool renew_matrix(double t) = 0;

    /// Rows may repeat each other from now on (SaddleMatrix, ConsistentSolver).
    virtual void soften();
    bool soft() const { return soft_; }
    /// A singular matrix of independent rows, or a singular position ahead where sweeps fail again and again,
    /// is no reason for a shorter step: soft rows and the step again. h: of the step.
    bool softened(Corrector result, double h);
    void close_state();
    /// Takes out of multipliers what moves nothing, with the present matrix; columns in rhs_ as long as one.
    void drop_idle_part(VecX& lambda);
    /// Largest change of multipliers that counts as none, of their size. Drives take their work, friction its
    /// force from them: then they are wanted to the tolerance.
    double multiplier_share() const {
        return driven_ ? std::min(loose_multipliers, 10 * options_.rtol) : loose_multipliers;
    }
    /// In joint coordinates.
    bool on_tree() const { return coordinates_->kept_rows() != nullptr; }
    /// Residuals of the constraints as right-hand sides, 0 where a tree joint keeps the row.
    void put_rows(Eigen::Ref<VecX> velocity, Eigen::Ref<VecX> position) const;
    /// The same, and 0 where soft rows are closed already: near a
    /// singular position a correction of round-off would move the mechanism by much more than it closes.
    void put_open_rows(Eigen::Ref<VecX> velocity, Eigen::Ref<VecX> position) const;
    /// Solves for changes of velocities, multipliers and positions that close both kinds of constraints to
    /// second order: rhs_ holds residuals of momentum and velocity, then of position. The coordinates move by
    /// q_per_u times the change of the velocities besides the position correction.
    void solve_second_order(double q_per_u, int columns);
    /// m/s, rad/s: a smaller change of the velocity constraints is not worth a solve, far below the tolerance
    /// as it is, and closed at the end of the step. Soft rows: round-off.
    double negligible_rate() const {
        return soft_ ? 1e-15 * (1 + largest(state_.u)) : std::max(1e-11, 1e-3 * options_.rtol);
    }
    /// Factors the assembled K with hardly any softness: for keep_free_part().
    bool factor_nearly_hard();
    /// Takes out of a change of velocities or poses what the rows in ws_ do not allow, by the present matrix.
    void keep_free_part(VecX& x);
    /// Largest change of a generalised force by a change of the multipliers.
    double force_of(const VecX& lambda);

    /// Consistent accelerations at state_ (zero where there are none), multipliers into state_, angles.
    void begin(const State& state, VecX& acceleration);
    /// z' of the friction states at ws_.motion and ws_.z into z_rate_.
    void find_state_rates(double t);
    bool has_states() const { return system_.friction_states() > 0; }
    /// h_ on, or to t_stop where that is near or passed.
    Trial next_trial(double t_stop) const;
    /// The next try after a step of h that did not converge, its rows being soft.
    double other_landing(double h);
    /// Ends the trial where the motion carried on foresees that a contact would begin too deep.
    void end_at_contact(Trial& trial);
    /// A contact begins too deep in the step that passed the error test (ws_.motion: its end): counted, and
    /// h_ set for the next try.
    bool contact_too_deep(const Trial& trial, int order);
    /// The smallest step worth trying at the present time.
    double smallest_step() const;
    /// Position and velocity constraints at the end of the step to round-off, by solves of the same matrix
    /// without new forces. False: they stay open.
    bool close_constraints(double t);
    void count_rejection(StepReason reason, double t, int order, double error);
    void count_acceptance(double t, double h, int order, double error);
    /// One step by Newton's method with new derivatives at every stage and iteration (exact_step.hpp).
    template <class Linearise, class Apply>
    Corrector iterate_exactly(StageMatrix& matrix, int& iterations, Linearise&& linearise, Apply&& apply);
    StepOutcome failure(StepReason reason, const std::string& what);
    /// How far along the motion singular positions are looked for, s.
    double way_to_look() const;
    std::string worst_part() const;
    /// Remembers for the message where a number went wrong, at ws_.motion.
    void note_bad_number(double t);
    /// The outcome of a factorisation, remembered if it failed; t: of the linearisation in ws_.
    Corrector factored(const FactorStatus& status, double t);
    static StepReason reason_of(Corrector result);

    const System& system_;
    IntegratorOptions options_;
    mutable Statistics statistics_;
    Workspace ws_;
    SaddleMatrix saddle_;
    const Formulation formulation_; // in use
    const std::unique_ptr<LinearSolver> linear_;
    LinearSolver& solver_; // linear_, for K
    const std::shared_ptr<ConsistentSolver> projections_;
    ConsistentSolver& consistent_; // projections_
    ErrorNorm norm_;
    const std::unique_ptr<StepCoordinates> coordinates_;
    ContactWatch watch_;
    const ContactWatch::MotionAt motion_at_, carried_on_;
    std::vector<double> values_; // of K
    State state_;
    /// Two columns over (u, lambda): momentum and velocity residuals; zero and position residuals.
    VecX rhs_;
    VecX source_, decay_, z_rate_; // of the friction states
    double h_ = 0;                 // next step
    double full_h_ = 0;            // step that a new contact cut short, 0: none
    double phi_worst_ = 0, rate_worst_ = 0;
    ErrorNorm::Value error_, increment_;
    int rejections_in_row_ = 0;
    int failures_ = 0; // of the corrector, since the last step worth the name
    std::size_t landings_ = 0;
    double failed_landing_ = 0; // s, first of the steps that did not converge
    bool soft_ = false;
    bool driven_ = false; // some coordinate is prescribed, or friction feeds on reactions
    VecX pushed_;         // G^T x
    VecX turn_;           // a third column over (u, lambda)
    VecX pose_change_, rate_change_;
    std::string trouble_; // what went wrong in the tries since the last accepted step; empty: nothing special
};

} // namespace gudgeon
