#include "solvers/tree_motion.hpp"

#include "core/assembly.hpp"
#include "core/tree_kinematics.hpp"
#include "solvers/articulated_body.hpp"
#include "solvers/consistent.hpp"
#include "solvers/index1_equations.hpp"
#include "solvers/phase_timer.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace gudgeon {

namespace {

constexpr int most_closing = 25;
constexpr double closed = 1e-13;      // m, rad
constexpr double closed_rate = 1e-14; // m/s, rad/s, relative to the speeds
constexpr double long_move = 0.3;     // rad, m: an iteration turns no joint further

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

class TreeMotion final : public MotionEquations {
  public:
    TreeMotion(const System& system, const IntegratorOptions& options);

    const System& system() const override { return system_; }
    Formulation formulation() const override { return Formulation::tree; }
    const char* linear_solver() const override { return equations_ ? "klu" : "none"; }
    int coordinates() const override { return tree_.coordinates(); }
    int speeds() const override { return tree_.speeds(); }

    void load(const State& state, VecX& x, VecX& w) override { tree_.take(state.q, state.u, x, w); }
    void store(const VecX& x, const VecX& w, State& state) override {
        tree_.set_motion(x, w, stored_motion_, stored_links_);
        tree_.store(stored_motion_, state.q, state.u);
    }
    void set_motion(const VecX& x, const VecX& w, Workspace& ws) override {
        tree_.set_motion(x, w, ws.motion, links_);
    }

    FactorStatus rates(double t, const VecX& x, const VecX& w, const VecX& z, const VecX* extra,
                       Workspace& ws, MotionRates& out) override;
    void respond(const Workspace& ws, const VecX& extra, VecX& speeds) override;
    void body_accelerations(const Workspace& ws, const VecX& speed_rates, VecX& out) override;

    bool can_drift() const override { return tree_.tree().cut_rows > 0; }
    bool close(double t, VecX& x, VecX& w, Workspace& ws) override;
    void normalise(VecX& x) const override { tree_.normalise(x); }

    std::string name_of(int column) const override { return equations_ ? equations_->name_of(column) : ""; }
    void report(Statistics& statistics) const override;
    void visit(Archive& archive) override;

  private:
    bool close_positions(double t, VecX& x, const VecX& w, Workspace& ws);
    bool close_speeds(double t, const VecX& x, VecX& w, Workspace& ws);
    bool close_all(double t, VecX& x, VecX& w, Workspace& ws);
    double open_rows(const VecX& residual);

    const System& system_;
    TreeKinematics tree_;
    ArticulatedBody articulated_;
    std::optional<Index1Equations> equations_; // where more than the tree is needed
    std::optional<ConsistentSolver> repeated_; // closes loops whose rows repeat each other
    const bool driven_;
    std::vector<LinkMotion> links_; // at the last rates()
    std::vector<LinkMotion> stored_links_;
    std::vector<BodyMotion> stored_motion_;
    VecX acceleration_, products_, target_, speeds_, q_, u_;
    long evaluations_ = 0;
};

TreeMotion::TreeMotion(const System& system, const IntegratorOptions& options)
    : system_(system), tree_(system), articulated_(system, tree_.tree()), driven_(has_drives(system)),
      links_(tree_.make_links()), stored_links_(links_), stored_motion_(system.start),
      acceleration_(VecX::Zero(system.velocities())), products_(acceleration_),
      target_(VecX::Zero(system.row_count())), speeds_(VecX::Zero(tree_.speeds())),
      q_(VecX::Zero(system.positions())), u_(VecX::Zero(system.velocities())) {
    if (can_drift() || system.reaction_friction)
        equations_.emplace(system, rows_of(options));
    if (can_drift() && options.redundant) {
        repeated_.emplace(system);
        repeated_->soften();
    }
}

FactorStatus TreeMotion::rates(double t, const VecX& x, const VecX& w, const VecX& z, const VecX* extra,
                               Workspace& ws, MotionRates& out) {
    ws.z = z;
    {
        const PhaseTimer timer(seconds_.evaluate);
        set_motion(x, w, ws);
        tree_.rates(x, w, out.coordinates);
    }
    FactorStatus status;
    if (equations_) {
        status = equations_->solve(t, ws, can_drift() ? extra : nullptr, acceleration_, out.lambda);
        if (!status.ok())
            return status;
        tree_.products(ws.motion, links_, products_);
        acceleration_ -= products_;
        tree_.project(ws.motion, links_, acceleration_, out.speeds);
    } else {
        ++evaluations_;
        {
            const PhaseTimer timer(seconds_.evaluate);
            evaluate_forces(system_, t, ws);
        }
        const PhaseTimer timer(seconds_.solve);
        articulated_.solve(links_, ws.motion, ws.f, out.speeds);
    }
    find_powers_and_states(t, z, driven_ ? out.lambda.data() : nullptr, ws, out);
    return status;
}

void TreeMotion::respond(const Workspace& ws, const VecX& extra, VecX& speeds) {
    if (!equations_) {
        speeds.setZero();
        return;
    }
    equations_->respond(ws, extra, acceleration_);
    tree_.project(ws.motion, links_, acceleration_, speeds);
}

void TreeMotion::body_accelerations(const Workspace& ws, const VecX& speed_rates, VecX& out) {
    tree_.products(ws.motion, links_, products_);
    tree_.expand(ws.motion, links_, speed_rates, out);
    out += products_;
}

bool TreeMotion::close(double t, VecX& x, VecX& w, Workspace& ws) {
    normalise(x);
    if (repeated_)
        return close_all(t, x, w, ws);
    return !can_drift() || (close_positions(t, x, w, ws) && close_speeds(t, x, w, ws));
}

// Next to singular positions K^-1 of the cut rows alone is of no use; the bodies are projected onto all rows
// with their soft ones, and the joints then hold in them too.
bool TreeMotion::close_all(double t, VecX& x, VecX& w, Workspace& ws) {
    tree_.set_motion(x, w, stored_motion_, stored_links_);
    tree_.store(stored_motion_, q_, u_);
    if (!repeated_->project_positions(t, q_, u_, ws) || !repeated_->project_velocities(t, q_, u_, ws))
        return false;
    tree_.take(q_, u_, x, w);
    return true;
}

// The residuals of the cut rows into target_, the largest of them returned.
double TreeMotion::open_rows(const VecX& residual) {
    const std::vector<bool>& kept = tree_.tree().kept;
    for (Eigen::Index r = 0; r < residual.size(); ++r)
        target_[r] = kept[static_cast<std::size_t>(r)] ? 0.0 : -residual[r];
    return largest(target_);
}

bool TreeMotion::close_positions(double t, VecX& x, const VecX& w, Workspace& ws) {
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < most_closing; ++i) {
        set_motion(x, w, ws);
        evaluate_constraints(system_, t, nullptr, true, ws);
        const double open = open_rows(ws.phi);
        // round-off of long coordinates sets a floor: stop when a step no longer helps there
        if (open <= closed || (open <= 1e3 * closed && open > 0.5 * last))
            return true;
        if (!std::isfinite(open) || !equations_->prepare(ws).ok())
            return false;
        last = open;
        respond(ws, target_, speeds_);
        if (const double longest = largest(speeds_); longest > long_move)
            speeds_ *= long_move / longest;
        tree_.move(speeds_, x);
    }
    return false;
}

bool TreeMotion::close_speeds(double t, const VecX& x, VecX& w, Workspace& ws) {
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < most_closing; ++i) {
        set_motion(x, w, ws);
        evaluate_constraints(system_, t, nullptr, i == 0, ws);
        const double open = open_rows(ws.rate), floor = closed_rate * (1 + largest(w));
        if (open <= floor || (open <= 1e3 * floor && open > 0.5 * last))
            return true;
        if (!std::isfinite(open) || open > 0.5 * last || (i == 0 && !equations_->prepare(ws).ok()))
            return false;
        last = open;
        respond(ws, target_, speeds_);
        w += speeds_;
    }
    return false;
}

void TreeMotion::report(Statistics& statistics) const {
    if (equations_) {
        equations_->report(statistics);
        statistics.seconds.evaluate += seconds_.evaluate;
        return;
    }
    statistics.evaluations = evaluations_;
    statistics.seconds.evaluate = seconds_.evaluate;
    statistics.seconds.solve = seconds_.solve;
}

void TreeMotion::visit(Archive& archive) {
    archive(tree_, evaluations_, seconds_, decay_);
    if (equations_)
        archive(*equations_);
}

} // namespace

std::unique_ptr<MotionEquations> make_tree_motion(const System& system, const IntegratorOptions& options) {
    return std::make_unique<TreeMotion>(system, options);
}

} // namespace gudgeon
