#include "solvers/cartesian_motion.hpp"

#include "core/assembly.hpp"
#include "solvers/consistent.hpp"
#include "solvers/index1_equations.hpp"
#include "solvers/step_coordinates.hpp"

#include <optional>

namespace gudgeon {

namespace {

class CartesianMotion final : public MotionEquations {
  public:
    CartesianMotion(const System& system, const IntegratorOptions& options)
        : system_(system), equations_(system, rows_of(options)), driven_(has_drives(system)),
          redundant_(options.redundant) {}

    const System& system() const override { return system_; }
    Formulation formulation() const override { return Formulation::saddle_point; }
    const char* linear_solver() const override { return "klu"; }
    int coordinates() const override { return system_.positions(); }
    int speeds() const override { return system_.velocities(); }

    void load(const State& state, VecX& x, VecX& w) override {
        x = state.q;
        w = state.u;
    }
    void store(const VecX& x, const VecX& w, State& state) override {
        state.q = x;
        state.u = w;
        normalise(state.q);
    }
    void set_motion(const VecX& x, const VecX& w, Workspace& ws) override {
        gudgeon::set_motion(system_, x, w, ws);
    }

    FactorStatus rates(double t, const VecX& x, const VecX& w, const VecX& z, const VecX* extra,
                       Workspace& ws, MotionRates& out) override;
    void respond(const Workspace& ws, const VecX& extra, VecX& speeds) override {
        equations_.respond(ws, extra, speeds);
    }
    void body_accelerations(const Workspace&, const VecX& speed_rates, VecX& out) override {
        out = speed_rates;
    }

    bool can_drift() const override { return system_.row_count() > 0; }
    bool close(double t, VecX& x, VecX& w, Workspace& ws) override;
    void normalise(VecX& x) const override { normalise_orientations(system_, x); }

    std::string name_of(int column) const override { return equations_.name_of(column); }
    void report(Statistics& statistics) const override {
        equations_.report(statistics);
        statistics.seconds.evaluate += seconds_.evaluate;
    }
    void visit(Archive& archive) override { archive(equations_, decay_, seconds_); }

  private:
    const System& system_;
    Index1Equations equations_;
    const bool driven_, redundant_;
    std::optional<ConsistentSolver> consistent_; // made where close() is asked for
};

FactorStatus CartesianMotion::rates(double t, const VecX& x, const VecX& w, const VecX& z, const VecX* extra,
                                    Workspace& ws, MotionRates& out) {
    ws.z = z;
    gudgeon::set_motion(system_, x, w, ws);
    const FactorStatus status = equations_.solve(t, ws, extra, out.speeds, out.lambda);
    if (!status.ok())
        return status;
    coordinate_rates(system_, x, w, out.coordinates);
    find_powers_and_states(t, z, driven_ ? out.lambda.data() : nullptr, ws, out);
    return status;
}

bool CartesianMotion::close(double t, VecX& x, VecX& w, Workspace& ws) {
    if (!consistent_) {
        consistent_.emplace(system_);
        if (redundant_)
            consistent_->soften();
    }
    normalise(x);
    return consistent_->project_positions(t, x, w, ws) && consistent_->project_velocities(t, x, w, ws);
}

} // namespace

std::unique_ptr<MotionEquations> make_cartesian_motion(const System& system,
                                                       const IntegratorOptions& options) {
    return std::make_unique<CartesianMotion>(system, options);
}

} // namespace gudgeon
