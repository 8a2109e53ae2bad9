// Chooses between explicit Runge-Kutta in joint coordinates, Gear's method and Radau IIA, at the start and
// again on the way.
//
// Explicit, where the formulation is left to the program or is that of trees: open trees without contacts and
// bristles, and no force on a single body faster than the motion itself. There erk needs a third to a tenth
// of the time at equal error. Where its steps come to be rejected again and again, Radau takes over and does
// not hand back.
//
// Measured at equal error: Radau needs two to five times less work wherever there are stiff, lightly damped
// modes (BDF of order 3 to 5 is unstable there), and as much as Gear's method, within a third either way, on
// smooth motions. So Radau begins; Gear's method takes over where Radau's steps are rejected again and
// again on a smooth motion, and hands back where its own order falls. Where Radau's sweeps fail although
// the step is accurate (tolerances near round-off), Gear's method takes over for good.
#pragma once

#include "solvers/integrator.hpp"

namespace gudgeon {

class AutoIntegrator final : public Integrator {
  public:
    AutoIntegrator(const System& system, const IntegratorOptions& options);

    const char* name() const override { return "auto"; }
    const char* linear_solver() const override { return active_->linear_solver(); }
    const char* formulation() const override { return active_->formulation(); }
    void start(const State& state) override;
    StepOutcome advance(double t_stop) override;
    void kink() override { active_->kink(); }
    const State& state() const override { return active_->state(); }
    void interpolate(double t, State& out) const override { active_->interpolate(t, out); }
    void set_on_contact(std::function<void(const ContactEvent&)> f) override { on_contact_ = std::move(f); }
    const Statistics& statistics() const override;
    void visit(Archive& archive) override;
    bool goes_on_exactly() const override { return active_->goes_on_exactly(); }
    Workspace& workspace() override { return active_->workspace(); }
    std::vector<IntegratorUse> uses() const override { return uses_; }

  private:
    enum class Method { erk, radau, gear };
    struct Choice {
        Method method;
        std::string why;
    };
    struct Window { // since the last look
        long steps = 0, rejected = 0, not_converged = 0, order_sum = 0;
        double error_sum = 0; // of the accepted steps, 1 is the limit
        void visit(Archive& archive) { archive(steps, rejected, not_converged, order_sum, error_sum); }
    };

    Choice first_choice(const State& state);
    void use(const Choice& choice, const State& state);
    Integrator& method(Method wanted);
    bool explicit_serves(const State& state, Workspace& ws) const;
    void activate(Integrator& method);
    void look_at_the_run();

    const System& system_;
    IntegratorOptions options_;
    std::unique_ptr<Integrator> erk_, radau_, gear_;
    std::unique_ptr<Integrator>& place(Method method) {
        return method == Method::erk ? erk_ : method == Method::radau ? radau_ : gear_;
    }
    Integrator* active_ = nullptr;
    std::vector<IntegratorUse> uses_;
    Window window_;
    double fastest_ = 0; // rad/s, of the lightly damped local modes at the start
    int changes_ = 0;
    bool radau_barred_ = false; // its sweeps failed for good
    mutable Statistics statistics_;
    std::function<void(const ContactEvent&)> on_contact_;
};

std::unique_ptr<Integrator> make_auto(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
