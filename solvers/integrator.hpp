// One interface for all integrators of the equations of motion.
#pragma once

#include "core/archive_state.hpp"
#include "core/assembly.hpp"
#include "core/state.hpp"

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <string>

namespace gudgeon {

class ConsistentSolver;

/// What a step does with a contact that is new in it (contact_watch.hpp): keep it if it starts shallow,
/// end the step where it starts, or take it as it comes.
enum class Onset { threshold, root, ignored };
const char* onset_name(Onset onset);
/// Throws std::invalid_argument for an unknown word.
Onset onset_named(const std::string& word);

/// How gear and radau solve their linear systems, the same equations either way (formulation.hpp); tree:
/// joint coordinates of a spanning tree instead of those of the bodies (motion_equations.hpp for explicit
/// methods, step_coordinates.hpp for gear and radau).
enum class Formulation { saddle_point, saddle_point_klu, augmented_lagrangian, tree, automatic };
const char* formulation_name(Formulation formulation);
/// Throws std::invalid_argument for an unknown word.
Formulation formulation_named(const std::string& word);

struct IntegratorOptions {
    double rtol = 1e-6; // error of a step relative to each coordinate and velocity ...
    double atol = 1e-6; // ... plus this (m, m/s, rad/s, 1 for Euler parameters)
    double step = 0;    // rk4: the step (0: 1e-3 s); elsewhere the largest step (0: none)
    int max_order = 5;  // gear, ida
    int threads = 1;
    Onset onset = Onset::threshold;
    Formulation formulation = Formulation::saddle_point;
    long max_steps = std::numeric_limits<long>::max();
    bool redundant = false; // rows of the start repeat each other; set by Simulation
    /// Projections of the same system, shared with who samples (one thread at a time); none: made anew.
    std::shared_ptr<ConsistentSolver> projections = nullptr;
};

inline Rows rows_of(const IntegratorOptions& options) {
    return options.redundant ? Rows::soft : Rows::independent;
}

/// Where the time goes, in seconds.
struct PhaseTimes {
    double evaluate = 0; // forces and constraints
    double assemble = 0; // derivatives and matrix values
    double factor = 0;
    double solve = 0;
    double control = 0; // predictor, error test, step and order
    double contact = 0; // contacts looked ahead for, begun, ended and remembered
    double output = 0;  // interpolation, projection and accelerations at samples
    void visit(Archive& archive) { archive(evaluate, assemble, factor, solve, control, contact, output); }
};

struct Statistics {
    long steps = 0;
    long rejected_error = 0, rejected_newton = 0, rejected_contact = 0;
    double softened_at = std::numeric_limits<double>::quiet_NaN(); // s, where rows became soft on the way
    long deep_starts = 0;       // contacts that began too deep and were taken all the same
    long newton_sweeps = 0;     // evaluations of the whole residual followed by a solve
    long constraint_polish = 0; // extra solves that only close the constraints
    long evaluations = 0;       // of the forces
    long factorisations = 0, refactorisations = 0;
    // of the augmented Lagrangian (linear_solver.hpp)
    long cholmod_factorisations = 0, cholmod_solves = 0, cholmod_iterations = 0, klu_fallbacks = 0;
    long nnz_matrix = 0, nnz_factors = 0;
    std::array<long, 9> order_histogram{}; // accepted steps by order
    double smallest_step = std::numeric_limits<double>::infinity(), largest_step = 0;
    double constraint_position_max = 0, constraint_velocity_max = 0; // at accepted steps
    PhaseTimes seconds;

    void visit(Archive& archive);

    /// Work of two integrators that shared a run.
    Statistics& operator+=(const Statistics& other);
};

/// Which method ran from when on, and why it was chosen.
struct IntegratorUse {
    double from; // s
    std::string name, why;
    void visit(Archive& archive) { archive(from, name, why); }
};

/// Why a step was rejected or a run stopped.
enum class StepReason {
    none,
    error_test,
    newton,
    contact,
    singular,
    non_finite,
    step_too_small,
    constraints
};

/// In words: "accepted", "error", ...
const char* step_reason_name(StepReason reason);

struct StepOutcome {
    bool ok = true;
    StepReason reason = StepReason::none;
    std::string message; // when, where, which body or joint was worst; empty when ok
};

/// Called after every attempted step (history for the user); accepted or with the reason against it.
struct StepRecord {
    double t, h; // t: end of the step
    int order;
    StepReason reason; // none: accepted
    double error;      // weighted error of the step, 1 is the limit
};

/// A contact begins, ends, or began too deep, so that the step was rejected.
struct ContactEvent {
    enum class Kind { start, end, rejected, deep } kind; // deep: too deep, but the step was taken
    double t;                                            // s; rejected: end of the rejected step
    int channel;                                         // in System::contacts
    double depth;                                        // m or rad, when first seen
    double speed;                                        // m/s or rad/s
};

class Integrator {
  public:
    virtual ~Integrator() = default;
    Integrator() = default;
    Integrator(const Integrator&) = delete;
    Integrator& operator=(const Integrator&) = delete;

    virtual const char* name() const = 0;
    virtual const char* linear_solver() const = 0;
    /// As in use: never automatic.
    virtual const char* formulation() const { return formulation_name(Formulation::saddle_point); }

    /// Begins at a consistent state (positions, velocities, multipliers; see consistent.hpp). Also called
    /// after a discontinuity: history is dropped, statistics go on.
    virtual void start(const State& state) = 0;

    /// One accepted step that does not pass t_stop, or the reason why there is none.
    virtual StepOutcome advance(double t_stop) = 0;

    /// Forces, or their rates, jump at the present time: what lies behind foretells less of what comes.
    virtual void kink() {}

    /// State at the end of the last accepted step.
    virtual const State& state() const = 0;

    /// State at a time inside the last accepted step, by the method's own interpolant (constraints hold
    /// to the tolerance; project_state() closes them).
    virtual void interpolate(double t, State& out) const = 0;

    /// Saves or loads all that the next steps depend on, and the statistics. Loading wants an integrator of
    /// the same kind, system and options that was started somewhere; on_step and on_contact stay its own.
    /// Here: the state alone, from which loading starts anew. Throws ArchiveError.
    virtual void visit(Archive& archive);
    /// A loaded integrator takes the same steps to the last bit; false: it starts anew.
    virtual bool goes_on_exactly() const { return false; }

    virtual const Statistics& statistics() const = 0;
    virtual Workspace& workspace() = 0; // external loads are set here

    /// The methods used so far; empty: this one alone.
    virtual std::vector<IntegratorUse> uses() const { return {}; }

    /// Every attempted step is told to this function where set.
    std::function<void(const StepRecord&)> on_step;

    /// Contact events where set; before start().
    virtual void set_on_contact(std::function<void(const ContactEvent&)>) {}
};

/// Names accepted by make_integrator, the first is the default.
const std::vector<std::string>& integrator_names();

/// Explicit methods: rk4, erk, erk5, erk8.
bool is_explicit(const std::string& integrator);

/// Methods that know Formulation::tree: these, gear, radau and auto.
bool works_on_tree(const std::string& integrator);

/// Throws std::invalid_argument for an unknown name and for a formulation the method does not know,
/// ModelError where constraints repeat each other and the method does not take that in joint coordinates. The
/// system must outlive the integrator.
std::unique_ptr<Integrator> make_integrator(const std::string& name, const System& system,
                                            const IntegratorOptions& options);

} // namespace gudgeon
