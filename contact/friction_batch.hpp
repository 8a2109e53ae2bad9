// Friction along one relative coordinate c of two bodies: a direction fixed in the first one (force kind
// "friction"), the displacement or the unwrapped angle of a joint.
//
//   slip v = l c', l = 1 for a displacement, the pin's radius (m) for an angle
//   force on c: -l N mu(v), N the given normal force or the magnitude of the reaction force of a perfect
//   joint's own constraints (without drives): a pin of radius R brakes with R mu N, a slider with mu N.
//   Reaction moments press too in a real joint; they are left out.
//
// B^T times it acts on the bodies, B the gradient of c; laws in friction_law.hpp. Not in S: how source and
// decay of the bristles change with the pose at fixed velocities, and how a reaction turns with its joint.
#pragma once

#include "contact/friction_law.hpp"
#include "contact/limits.hpp"

namespace gudgeon {

template <class Measure> struct FrictionKernel {
    struct Element : ForceElement {
        Measure measure;
        FrictionLaw law;
        double lever = 1;                    // m/rad or 1
        double normal_force = 0;             // N, where it is given
        int state = -1;                      // number in Evaluation::z
        std::array<int, 3> rows{-1, -1, -1}; // whose multipliers make the normal force
    };
    static constexpr const char* name = "friction";
    static constexpr CouplingMask coupling = Measure::coupling;

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
    static Linearisation::StateCoupling state_coupling(const Evaluation& e, const Element& x);
    /// -df/dlambda of x.rows[k].
    static Gradient<1> by_multiplier(const Evaluation& e, const Element& x, int k);
    static void state_terms(const Evaluation& e, const Element& x, double& source, double& decay);
};

template <class Measure> class FrictionBatch final : public ForceBatchOf<FrictionKernel<Measure>> {
  public:
    using Kernel = FrictionKernel<Measure>;
    void declare_states(std::vector<double>& scales) override;
    void state_terms(const Evaluation& e, double* source, double* decay) const override;
    void add_linearisation(const Evaluation& e, Linearisation& lin) const override;
};

/// Forces of kind "friction" and friction on displacements of joints.
ForceBatchBuilder displacement_friction_builder();
/// Friction on angles of joints.
ForceBatchBuilder angle_friction_builder();

} // namespace gudgeon
