// Equations of motion in joint coordinates (AU 1-4): w' of open trees by the articulated-body recursion, of
// trees with closed loops, drives, or friction pressed by reactions from the accelerations of the bodies.
//
// There the saddle-point system of all bodies and all rows is solved (index1_equations.hpp): cost linear in
// the length of a chain of loops, where the constraints in joint space would couple all of them. w' is taken
// out of u' joint by joint: relative accelerations along the freedoms, less the velocity products. Reactions
// of all joints come with it. The same matrix closes loops: with -Phi of the cut rows on its right-hand side
// it gives the least displacements of the bodies that move along the joints, and those move s.
#pragma once

#include "solvers/motion_equations.hpp"

namespace gudgeon {

std::unique_ptr<MotionEquations> make_tree_motion(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
