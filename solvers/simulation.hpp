// A mechanism being simulated: model in, states and samples out. The way in for other programs.
//
//   gudgeon::Simulation sim(gudgeon::read_model("chain.json"));
//   while (sim.time() < 1) { sim.advance_to(sim.time() + 0.01); use(sim.sample()); }
//
// One object per thread of use; several objects share nothing. Nothing is printed, nothing exits.
#pragma once

#include "core/sample.hpp"
#include "core/user_force.hpp"
#include "solvers/initial.hpp"
#include "solvers/integrator.hpp"
#include "solvers/redundancy.hpp"
#include "solvers/statics.hpp"

#include <functional>
#include <iosfwd>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace gudgeon {

enum class Start { as_given, equilibrium };

struct SimulationOptions {
    std::string integrator = "gear";
    Start start = Start::as_given; // equilibrium: statics.hpp, at rest but for what drives ask
    IntegratorOptions integration;
    std::vector<UserForce> user_forces;
    std::function<void(const ContactEvent&)> on_contact; // starts, ends and rejected starts of contacts
};

/// The mechanism cannot be assembled; what() names the joints.
class AssemblyError : public std::runtime_error {
  public:
    AssemblyError(const std::string& what, AssemblyReport report)
        : std::runtime_error(what), report_(std::move(report)) {}
    const AssemblyReport& report() const { return report_; }

  private:
    AssemblyReport report_;
};

/// There is no equilibrium to start from; what() names the bodies that accelerate.
class EquilibriumError : public std::runtime_error {
  public:
    EquilibriumError(const std::string& what, StaticsReport report)
        : std::runtime_error(what), report_(std::move(report)) {}
    const StaticsReport& report() const { return report_; }

  private:
    StaticsReport report_;
};

class Simulation {
  public:
    /// Compiles, assembles, finds redundancy, prepares the integrator. Throws ModelError, AssemblyError,
    /// EquilibriumError, std::invalid_argument (unknown integrator), BadNumberError (core/bad_numbers.hpp:
    /// forces that are no numbers).
    explicit Simulation(Model model, SimulationOptions options = {});
    ~Simulation();
    Simulation(Simulation&&) noexcept;

    const System& system() const;
    const AssemblyReport& assembly() const;
    const RedundancyReport& redundancy() const;
    /// Changes of the rank that samples showed, singular positions among them; at most 100.
    const std::vector<RankChange>& rank_changes() const;
    /// How the start was found where it is an equilibrium; null: as given.
    const StaticsReport* statics() const;
    /// What to know of the start (notices.hpp): contacts that begin deep, clearances of zero.
    const std::vector<std::string>& notices() const;
    const Statistics& statistics() const;
    const char* integrator_name() const;
    /// Methods used so far with the reasons (auto), or the one that was asked for.
    std::vector<IntegratorUse> integrator_uses() const;
    const char* linear_solver() const;
    const char* formulation() const;
    Integrator& integrator();

    double time() const; // of the last advance_to
    /// Steps exactly to t >= time(). On failure the state stays at the last accepted step.
    StepOutcome advance_to(double t);

    /// Steps freely until t lies inside the last accepted step, never beyond t_end; then sample(t).
    /// Cheaper than advance_to for closely spaced output: steps do not end at output times.
    StepOutcome advance_past(double t, double t_end);

    /// Sample at the present time, or at a time inside the last step after advance_past. The reference
    /// stays valid until the next call. Throws std::runtime_error where the constraints cannot be closed.
    const Sample& sample();
    const Sample& sample_at(double t);

    /// State at time(), to be saved; restore() goes on from a saved state (the integrator starts anew).
    State state() const;
    void restore(const State& state);

    /// Everything: a simulation of the same model, options and user forces that loads it goes on to the last
    /// bit as the one that saved it would have (ida starts anew, see Integrator::goes_on_exactly). load()
    /// throws ArchiveError (core/archive.hpp) for what is truncated, damaged, of another version, model or
    /// options, and the object is of no more use then but for another load(). Errors of save() show in the
    /// stream.
    void save(std::ostream& stream);
    void load(std::istream& stream);
    /// Both, as a part of an archive.
    void visit(Archive& archive);

    /// Load on a body from outside, kept until changed: force at the mass centre (N, global), moment
    /// (N m, global). The integrator restarts, since forces jump.
    void set_load(const std::string& body, const Vec3& force, const Vec3& moment);

    /// M, C = -df/du, K = -df/dq + d(G^T lambda)/dq, G at the present state; rows and columns as
    /// velocities u (6 per moving body), d/dq along body-frame rotations.
    struct Matrices {
        CscMatrix M, C, K, G;
    };
    Matrices matrices();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon
