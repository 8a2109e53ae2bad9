// Explicit Runge-Kutta methods of order 5 and 8 with error control, for scenes without stiff parts: erk5 and
// erk8; erk takes the one that needs less work at its tolerance.
//
// Coefficients: explicit_pair.hpp. Either formulation (motion_equations.hpp). Positions and velocities are
// projected onto the constraints that can drift after every step that passes the error test. A step is
// rejected by error, by constraints that do not close, and by contacts that begin too deep
// (contact_watch.hpp), like those of the implicit methods. Dense output is the pair's own.
#pragma once

#include "solvers/integrator.hpp"

#include <memory>

namespace gudgeon {

std::unique_ptr<Integrator> make_erk(const System& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_erk5(const System& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_erk8(const System& system, const IntegratorOptions& options);

} // namespace gudgeon
