// The equations of motion as explicit integrators see them: x' = N(x) w, w' from forces, z' of friction
// states.
//
// Two formulations stand behind it, one virtual call per evaluation:
//   Cartesian  x = q (7 per moving body), w = u (6 per moving body), all constraints by multipliers;
//   tree       x = joint coordinates s, w = joint speeds of a spanning tree (core/spanning_tree.hpp); tree
//              joints hold exactly, multipliers close the loops.
// Constraints are kept by one of two means of the integrator: terms `extra` in G u' = gamma + extra (rk4), or
// close() after each step. An object belongs to one thread of use; what it finds depends on its arguments
// alone (and on factors kept for symbolic reuse, which visit() saves), so rejected steps leave no trace.
#pragma once

#include "core/archive_state.hpp"
#include "core/state.hpp"
#include "solvers/integrator.hpp"
#include "solvers/linear_solver.hpp"

#include <memory>
#include <string>

namespace gudgeon {

/// Rates at one instant. Sized by MotionEquations::make_rates().
struct MotionRates {
    VecX coordinates; // x'
    VecX speeds;      // w'
    VecX states;      // z' of the friction states, m/s
    VecX powers;      // as State::work, W
    VecX lambda;      // multipliers, one per row of the system; where they are not known: left alone
    void visit(Archive& archive) { archive(coordinates, speeds, states, powers, lambda); }
};

class MotionEquations {
  public:
    virtual ~MotionEquations() = default;
    MotionEquations() = default;
    MotionEquations(const MotionEquations&) = delete;
    MotionEquations& operator=(const MotionEquations&) = delete;

    virtual const System& system() const = 0;
    virtual Formulation formulation() const = 0;
    virtual const char* linear_solver() const = 0;

    virtual int coordinates() const = 0;
    virtual int speeds() const = 0;
    MotionRates make_rates() const; // all zero

    /// Coordinates and speeds of a state (q and u alone are read); those of a tree join on to its joints
    /// exactly, dropping what the state leaves open there. x and w get their sizes.
    virtual void load(const State& state, VecX& x, VecX& w) = 0;
    /// q and u of the state, Euler parameters of unit length; the rest of it is left alone.
    virtual void store(const VecX& x, const VecX& w, State& state) = 0;
    /// Poses and velocities of all bodies into ws.motion.
    virtual void set_motion(const VecX& x, const VecX& w, Workspace& ws) = 0;

    /// All rates at (t, x, w, z); x need not be normalised. Reads ws.angles, ws.contacts, ws.external and, as
    /// a first guess, ws.lambda; sets ws.z = z. extra: one per row (m/s2, 1/s2) added to the right-hand side
    /// of the acceleration equations, null for none; ignored where nothing can_drift(). Leaves ws.motion and
    /// ws.f and, where something can drift, ws.phi, ws.rate and ws.rows. Numbers that are not finite are the
    /// caller's to find (all_finite()); core/bad_numbers.hpp names them.
    virtual FactorStatus rates(double t, const VecX& x, const VecX& w, const VecX& z, const VecX* extra,
                               Workspace& ws, MotionRates& out) = 0;

    /// Change of w' by `extra` alone, by the matrix of the last rates(), which were at x; zero where nothing
    /// drifts.
    virtual void respond(const Workspace& ws, const VecX& extra, VecX& speeds) = 0;

    /// u' of all bodies (System's layout) with these w', at the last rates().
    virtual void body_accelerations(const Workspace& ws, const VecX& speed_rates, VecX& out) = 0;

    /// Some row of the system is kept by multipliers alone: x and w can leave it.
    virtual bool can_drift() const = 0;

    /// Least change of x, then of w, in the mass norm until |Phi| and G u + dPhi/dt are at round-off. False:
    /// did not close; x and w are then of no use. At once true where nothing can drift.
    virtual bool close(double t, VecX& x, VecX& w, Workspace& ws) = 0;
    /// Euler parameters to unit length.
    virtual void normalise(VecX& x) const = 0;

    /// Largest decay of a friction state at the last rates(), 1/s (0: none): explicit steps beyond 2.8 over
    /// it are unstable.
    double largest_decay() const { return decay_.size() ? decay_.maxCoeff() : 0.0; }

    /// "joint B (displacement along x)" or "body rod" for FactorStatus::column.
    virtual std::string name_of(int column) const = 0;
    /// Writes the counts and times of all evaluations so far.
    virtual void report(Statistics& statistics) const = 0;
    virtual void visit(Archive& archive) = 0;

  protected:
    /// Powers and z' at ws.motion; lambda: of drives, null for none.
    void find_powers_and_states(double t, const VecX& z, const double* lambda, Workspace& ws,
                                MotionRates& out);
    /// Some coordinate of a joint is a function of time: its multiplier does work.
    static bool has_drives(const System& system);

    VecX source_, decay_; // of the friction states
    PhaseTimes seconds_;  // what the formulations spend beside their solvers
};

bool all_finite(const MotionRates& rates);

/// formulation: tree, or any other word for Cartesian coordinates. options: threads, redundant. The system
/// must outlive the equations.
std::unique_ptr<MotionEquations> make_motion_equations(const System& system,
                                                       const IntegratorOptions& options);

} // namespace gudgeon
