// What the integrators of fixed steps share: the loop, contacts, dense output, messages.
//
// A fixed step cannot be rejected: contacts that begin too deep are counted, and a run whose velocities jump
// next to a singular position of the constraints, where the motion may leave its branch, stops. Dense output:
// quintic in positions (values, rates, accelerations at both ends), cubic in velocities, friction states and
// energies, linear in multipliers.
#pragma once

#include "solvers/contact_watch.hpp"
#include "solvers/integrator.hpp"

namespace gudgeon {

class FixedStepIntegrator : public Integrator {
  public:
    /// options.step: the step, 0 for 1e-3 s; the last step before a stop is shortened to end there exactly.
    /// Throws std::invalid_argument for a step that is negative or not finite.
    FixedStepIntegrator(const System& system, const IntegratorOptions& options, const char* name, int order);

    const char* name() const override { return name_; }
    const State& state() const override { return now_.state; }
    Workspace& workspace() override { return ws_; }
    void set_on_contact(std::function<void(const ContactEvent&)> f) override {
        watch_.on_contact = std::move(f);
    }
    void start(const State& state) override;
    StepOutcome advance(double t_stop) override;
    void interpolate(double t, State& out) const override;

  protected:
    /// What is known at one end of a step.
    struct Point {
        State state;
        VecX acceleration;
        VecX powers; // as State::work
        VecX z_rate; // of the friction states
        // of methods on MotionEquations: its coordinates and speeds, their rates
        VecX coordinates, speeds, coordinate_rate, speed_rate;
        void visit(Archive& archive) {
            archive(state, acceleration, powers, z_rate, coordinates, speeds, coordinate_rate, speed_rate);
        }
    };

    /// A run begins at the state of this point: what finish_point() takes beside it.
    virtual void enter(Point&) {}
    /// From now_ to all of next_.
    virtual StepOutcome take_step(double h, double t_end) = 0;
    /// Accelerations, multipliers and the rest of a point by its time, coordinates, velocities and z.
    virtual StepOutcome finish_point(Point& point) = 0;

    /// Violations at ws_ into the statistics.
    void record_violations();
    /// z' of the friction states at ws_.motion and ws_.z; left alone where there are none.
    void find_state_rates(double t, VecX& out);
    /// What at ws_ is no finite number; not ok in any case.
    StepOutcome bad_number(double t);
    /// The state outside of the matrices of the method.
    void visit_steps(Archive& archive);

    const System& system_;
    const double step_;
    Workspace ws_;
    ContactWatch watch_;
    Point before_, now_, next_; // begin and end of the last step; the step being taken
    VecX source_, decay_;       // of the friction states
    VecX external_;             // loads now_ was evaluated with
    mutable Statistics statistics_;

  private:
    StepOutcome follow_contacts();
    StepOutcome check_branch();
    void record(const StepOutcome& outcome, double h, double t_end);
    void motion_inside(double t, int body, BodyMotion& out);

    const char* const name_;
    const int order_;
    const long max_steps_;
    const ContactWatch::MotionAt motion_at_;
    State inside_;    // of the last step, for the watch
    double jump_ = 0; // of the velocities' slope in the last step, times the step
    StepOutcome started_;
};

} // namespace gudgeon
