// Applied forces and torques: a vector times a function of time.
//
// Fixed: components along the global axes. Following: components along the axes of the body, so that the
// vector turns with it. Input power: force times the velocity of its point, torque times the angular
// velocity.
#pragma once

#include "core/force_batch.hpp"
#include "core/system.hpp"
#include "core/time_function.hpp"

#include <memory>
#include <optional>

namespace gudgeon {

struct AppliedElement : ForceElement { // a: the ground, b: the body
    Vec3 point = Vec3::Zero();         // m, body frame
    Vec3 force = Vec3::Zero();         // N, at the point
    Vec3 torque = Vec3::Zero();        // N m
    SharedPart<TimeFunction> time;     // absent: constant 1
};

template <bool follows> struct AppliedForceKernel {
    using Element = AppliedElement;
    static constexpr const char* name = follows ? "applied force, following" : "applied force";
    static constexpr CouplingMask coupling = follows ? coupling_bit(2, 3) : coupling_bit(3, 3);

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
};

template <bool follows> std::unique_ptr<ForceBatch> build_applied_forces(const CompileContext& context);

} // namespace gudgeon
