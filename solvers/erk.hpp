// Explicit Runge-Kutta methods of order 5 and 8 with error control, for scenes without stiff parts: erk5 and
// erk8; erk takes the one that needs less work at its tolerance.
//
// Coefficients: explicit_pair.hpp. Either formulation (motion_equations.hpp). Positions and velocities are
// projected onto the constraints that can drift after every step that passes the error test. A step is
// rejected by error, by constraints that do not close, and by contacts that begin too deep
// (contact_watch.hpp), like those of the implicit methods. Dense output is the pair's own.
#pragma once

#include "solvers/contact_watch.hpp"
#include "solvers/explicit_pair.hpp"
#include "solvers/hermite_motion.hpp"
#include "solvers/motion_equations.hpp"

#include <array>
#include <memory>

namespace gudgeon {

/// Coordinates, speeds, friction states and energies in one vector, so that stages are summed in one pass.
class Erk final : public Integrator {
  public:
    Erk(const System& system, const IntegratorOptions& options, const char* name, int order);

    const char* name() const override { return name_; }
    const char* linear_solver() const override { return equations_->linear_solver(); }
    const char* formulation() const override { return formulation_name(equations_->formulation()); }
    const State& state() const override { return now_.state; }
    Workspace& workspace() override { return ws_; }
    const Statistics& statistics() const override;
    void set_on_contact(std::function<void(const ContactEvent&)> f) override {
        watch_.on_contact = std::move(f);
    }
    void start(const State& state) override;
    StepOutcome advance(double t_stop) override;
    void kink() override { fresh_ = false; }
    void interpolate(double t, State& out) const override;
    void visit(Archive& archive) override;
    bool goes_on_exactly() const override { return true; }

  private:
    struct Point {
        State state;
        VecX y;            // x, w, z, work
        VecX acceleration; // u' of the bodies; only where something can touch
        void visit(Archive& archive) { archive(state, y, acceleration); }
    };
    struct Attempt {
        double t, h; // end and length
        bool last;   // ends at a stop
    };

    void refresh();
    void weigh();
    void first_step();
    double smallest_step() const;
    Attempt next_attempt(double t_stop);
    bool attempt(const Attempt& trial);
    bool find_stages(double t, double h, int first, int end) const;
    bool rates(double t, const VecX& y, VecX& slope) const;
    void combine(const VecX& from, const std::vector<PairTerm>& row, double h, VecX& out) const;
    double error_of(double h);
    bool close_end(double t);
    void finish(const Attempt& trial);
    void accept(const Attempt& trial, double error);
    bool reject(StepReason reason, const Attempt& trial, double factor, double error);
    StepOutcome stuck(const Attempt& trial) const;
    void dense_stages() const;
    std::array<long, 3> work_so_far() const;
    static StepEnd end_of(const Point& point) {
        return {point.state.t, point.state.q, point.state.u, point.acceleration};
    }

    const System& system_;
    const IntegratorOptions options_;
    const char* const name_;
    const ExplicitPair& pair_;
    const std::unique_ptr<MotionEquations> equations_;
    const Eigen::Index x_, w_, z_; // sizes
    mutable Workspace ws_;
    ContactWatch watch_;
    Point before_, now_, next_;       // begin and end of the last step; the step being tried
    mutable std::vector<VecX> slope_; // stages: of the last accepted step, then of the one being tried
    VecX first_slope_;                // at now_
    mutable MotionRates rates_;
    mutable VecX x_now_, w_now_, z_now_, y_; // scratch
    mutable std::vector<double> dense_weight_;
    mutable FactorStatus status_; // of the last evaluation that failed
    VecX weight_, external_;
    std::vector<double> error_sum_;
    mutable std::array<long, 3> output_work_{}; // evaluations, (re)factorisations of dense_stages()
    mutable int known_ = 0;                     // stages of the last accepted step that are there
    bool fresh_ = false;                        // first_slope_ is that of now_
    double h_ = 0, error_ = 1;
    StepReason reason_ = StepReason::none; // of the last rejection
    std::string trouble_;                  // what was no number in it
    StepOutcome started_;
    mutable Statistics statistics_;
};

std::unique_ptr<Integrator> make_erk(const System& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_erk5(const System& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_erk8(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
