// Tyre: a vertical spring-damper between a point of a body and the road below it.
//
//   y = z - z_ref - z_road,  z_road = road(t) + profile(x),  x, z the point's global coordinates
//   F_z = preload - k y - c y'   on the body at the point; bilateral, no horizontal force
//
// The profile is constant beyond its ends. Elastic energy 1/2 k y^2 - preload y, dissipated power c y'^2,
// input power F_z z_road' (what the road does by moving, or by its slope under a point that drives on).
#pragma once

#include "core/force_batch.hpp"
#include "core/system.hpp"
#include "core/time_function.hpp"

#include <memory>
#include <optional>

namespace gudgeon {

struct TyreElement : ForceElement { // a: the ground, b: the body
    Vec3 point = Vec3::Zero();      // m, body frame
    double stiffness = 0, damping = 0, preload = 0;
    double reference = 0; // m
    SharedPart<TimeFunction> road;
    std::shared_ptr<const Spline> profile;
};

/// A point at the mass centre couples no rotation: its batch declares fewer blocks.
template <bool at_mass_centre> struct TyreKernel {
    using Element = TyreElement;
    static constexpr const char* name = at_mass_centre ? "tyre at the mass centre" : "tyre";
    static constexpr CouplingMask coupling =
        at_mass_centre ? coupling_bit(2, 2)
                       : coupling_bit(2, 2) | coupling_bit(2, 3) | coupling_bit(3, 2) | coupling_bit(3, 3);

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
};

/// The tyres with their point at the mass centre of the body, or the others.
template <bool at_mass_centre> std::unique_ptr<ForceBatch> build_tyres(const CompileContext& context);

} // namespace gudgeon
