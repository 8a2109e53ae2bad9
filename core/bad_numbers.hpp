// Where numbers went wrong, and what things are called in messages.
#pragma once

#include "core/state.hpp"

#include <stdexcept>
#include <string>

namespace gudgeon {

/// A force, a drive or a coordinate is no finite number; what() names the element, the time and the state.
class BadNumberError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// What is no finite number at ws.motion, ws.z, ws.lambda and ws.external, with the state of the bodies it
/// acts on; empty: everything is finite. Looks at every element: for messages only. Leaves forces and
/// constraints of ws changed.
std::string find_bad_number(const System& system, double t, Workspace& ws);

/// "joint 'B' (displacement along h) between 'crank' and 'rod'"
std::string constraint_name(const System& system, int row);
/// Of an unknown of the saddle-point equations (velocities, then multipliers): "body 'rod' (vx)" or a
/// constraint.
std::string unknown_name(const System& system, int unknown);
/// "joint 'B' (strip 3)"
std::string contact_name(const System& system, int channel);

} // namespace gudgeon
