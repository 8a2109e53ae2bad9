// The kernels of Gudgeon that are counted, by group.
#pragma once

#include "counted.hpp"

namespace gudgeon::regression {

using Kernels = std::vector<counted::Kernel>;

Kernels joint_kernels();   // every kind of perfect joint, drives
Kernels contact_kernels(); // bushings, strips, balls, slots
Kernels law_kernels();     // normal laws, friction laws
Kernels system_kernels();  // residual, derivatives, matrix, factorisations, solutions
Kernels step_kernels();    // steps of the integrators

} // namespace gudgeon::regression
