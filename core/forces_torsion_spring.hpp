// Torsion spring and damper on an angle of a joint.
//
//   moment g = k (q - q0) + c q' about the joint's axis, -g on b and +g on a,
//
// q the unwrapped turn of b relative to a (relative_motion.hpp, angle::). A table (moment against
// q - q0, N m against rad) replaces k. Elastic energy: the integral from q = q0; dissipated power c q'^2.
#pragma once

#include "core/curve.hpp"
#include "core/force_batch.hpp"
#include "core/system.hpp"

#include <memory>

namespace gudgeon {

struct TorsionSpringKernel {
    struct Element : ForceElement {
        AngleFrames frames{};
        int angle = 0;                     // number in System::angles
        double stiffness = 0, damping = 0; // N m/rad, N m s/rad
        double free_angle = 0;             // rad
        std::shared_ptr<const Spline> table;
    };
    static constexpr const char* name = "torsion-spring";
    static constexpr CouplingMask coupling = angle::coupling;

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
};

std::unique_ptr<ForceBatch> build_torsion_springs(const CompileContext& context);

} // namespace gudgeon
