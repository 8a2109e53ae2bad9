// All force batches a model file can ask for.
#pragma once

#include "core/system.hpp"

#include <vector>

namespace gudgeon {

/// The builders of core and the bushings, to be given to compile().
std::vector<ForceBatchBuilder> standard_force_builders();

} // namespace gudgeon
