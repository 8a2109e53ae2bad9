// SUNDIALS IDA (Hindmarsh et al. 2005; variable-order, fixed-leading-coefficient BDF) with its KLU
// interface on the full stabilised index-2 form (ida_equations.hpp): the second opinion on gear.
//
// Error test: root mean square over all coordinates and velocities of error / (rtol |y| + atol); the
// multipliers take part neither in it nor in Newton's convergence test. At its steps the
// constraints hold to about the tolerance (IDA keeps old matrices and trusts an old rate of convergence),
// not to round-off as with gear. IDA does not notice when its order is limited by stability (lightly damped
// fast modes); where that makes it slow, lower options.max_order.
//
// Loads set from outside between steps and other jumps: call start(), as IDA keeps its history else.
#pragma once

#include "solvers/integrator.hpp"

namespace gudgeon {

/// options.step: the largest step, 0 for none. Throws std::invalid_argument for options IDA refuses.
std::unique_ptr<Integrator> make_ida(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
