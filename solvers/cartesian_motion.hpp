// Equations of motion in the coordinates of the bodies, constraints by multipliers (index1_equations.hpp).
#pragma once

#include "solvers/motion_equations.hpp"

namespace gudgeon {

std::unique_ptr<MotionEquations> make_cartesian_motion(const System& system,
                                                       const IntegratorOptions& options);

} // namespace gudgeon
