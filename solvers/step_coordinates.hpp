// The coordinates in which an implicit method writes a step: x, w with x' = N(x) w.
//
// Two formulations:
//   Cartesian  x = q (7 per moving body), w = u (6 per moving body);
//   tree       x = s, w = joint speeds of a spanning tree (core/tree_kinematics.hpp); its joints hold
//   exactly.
// History, predictor and formulas of the method are in x and w. Forces, residuals and the matrix
//   K = [a M + C + S/a, G^T; G, 0]
// are those of the bodies and of all rows either way: of a tree the rows that its joints keep have 0 on the
// right, so that what K gives for the bodies lies along the joints, and their relative motions are the
// changes of w. Multipliers of all joints come with it. Errors and increments are measured on the bodies, so
// that a tolerance means the same in both.
#pragma once

#include "core/archive.hpp"
#include "core/state.hpp"
#include "solvers/error_norm.hpp"
#include "solvers/integrator.hpp"

#include <memory>

namespace gudgeon {

/// Rates at the end of a step by its formula: x' = a x + bx, w' = a w + bw.
struct StepFormula {
    double a; // 1/s
    const VecX& bx;
    const VecX& bw;
};

class StepCoordinates {
  public:
    virtual ~StepCoordinates() = default;
    StepCoordinates() = default;
    StepCoordinates(const StepCoordinates&) = delete;
    StepCoordinates& operator=(const StepCoordinates&) = delete;

    virtual int coordinates() const = 0;
    virtual int speeds() const = 0;

    /// x and w of a state, sized; what a state leaves open in tree joints is dropped.
    virtual void load(const State& state, VecX& x, VecX& w) = 0;
    /// q and u of a state.
    virtual void store(const VecX& x, const VecX& w, State& state) = 0;
    virtual void normalise(VecX& x) const = 0;
    /// x moved along N(x), Euler parameters by exact rotations.
    virtual void shift(const VecX& step, VecX& x) const = 0;
    /// What turns or moves alone: so many coordinates with x' = w, then Euler parameters with an angular
    /// velocity or not; first ones in x and w.
    struct Piece {
        int x, w, straight;
        bool turns;
    };
    const std::vector<Piece>& pieces() const { return pieces_; }
    /// ws.motion of all bodies; what follows is at this motion. x need not be normalised.
    virtual void set_motion(const VecX& x, const VecX& w, Workspace& ws) = 0;
    /// x' and w', at accelerations u' of the bodies that keep the constraints.
    virtual void rates(const VecX& x, const VecX& w, const VecX& acceleration, VecX& x_rate,
                       VecX& w_rate) = 0;

    /// f - M u' of the bodies (6 each) with these w', at the beginning of momentum.
    virtual void momentum_residual(const VecX& w_rate, const VecX& f, VecX& momentum) = 0;
    /// f -= M u' with w' = 0
    virtual void take_out_products(VecX&) {}

    // Gear's method
    /// x and w of the first sweep: w as predicted, x fitted to it. predicted_x: normalised.
    virtual void begin_step(const StepFormula& formula, VecX& predicted_x, const VecX& predicted_w, VecX& x,
                            VecX& w) = 0;
    /// w moved by changes of body velocities, x by the formula and by changes of poses beyond it. How far:
    /// body poses along T(q) and body velocities, 6 per body, valid until the next call.
    struct Moved {
        const double* poses;
        const double* velocities;
    };
    virtual Moved move(const StepFormula& formula, const double* velocities, const double* poses, VecX& x,
                       VecX& w) = 0;

    /// The matrix is made at this motion: what comes out of it is read here.
    virtual void hold() {}
    /// Changes of w for changes of body velocities out of the matrix (what follows them is not read).
    virtual void speeds_of(const VecX& velocities, VecX& w) = 0;
    /// Body velocities for changes of w.
    virtual void velocities_of(const VecX& w, VecX& velocities) = 0;
    /// The motion that the three above and below are at, where nothing else is asked of it.
    virtual void go_to(const VecX&, const VecX&) {}
    /// Norm of a step along N and a change of w.
    virtual ErrorNorm::Value measure(const ErrorNorm& norm, const VecX& step, const VecX& w) = 0;
    /// Norm of factor times (x - x2, w - w2).
    virtual ErrorNorm::Value distance(const ErrorNorm& norm, const VecX& x, const VecX& x2, const VecX& w,
                                      const VecX& w2, double factor) = 0;

    /// Per row of the system: a tree joint keeps it; null where none is kept.
    virtual const std::vector<bool>* kept_rows() const { return nullptr; }
    /// Some row is kept by the sweeps alone.
    virtual bool can_drift() const = 0;

    virtual void visit(Archive&) {}

  protected:
    std::vector<Piece> pieces_;
};

/// q' = T(q) u, all 7 numbers of each body.
void coordinate_rates(const System& system, const VecX& q, const VecX& u, VecX& rates);
/// Euler parameters of all bodies to unit length.
void normalise_orientations(const System& system, VecX& q);

/// formulation: tree, or any other word for Cartesian coordinates. The system must outlive them.
std::unique_ptr<StepCoordinates> make_step_coordinates(const System& system, Formulation formulation,
                                                       int threads);

} // namespace gudgeon
