// What a user should know of a start before trusting the run: contacts that begin inside one another, joints
// whose clearance is zero.
#pragma once

#include "core/state.hpp"
#include "core/system.hpp"

#include <string>
#include <vector>

namespace gudgeon {

/// One sentence each, joints named; empty where there is nothing to say. The deepest contact of a joint
/// stands for all of them.
std::vector<std::string> start_notices(const System& system, const State& state);

} // namespace gudgeon
