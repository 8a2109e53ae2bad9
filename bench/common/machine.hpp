// What the times depend on.
#pragma once

#include <nlohmann/json.hpp>

namespace gudgeon::bench {

/// processor, cores, load (of the last minute), compiler, build, version, date (UTC); commit where the
/// environment's GUDGEON_COMMIT tells it.
nlohmann::json describe_machine();

/// Average of the last minute; 0 where it is not known.
double load_now();

} // namespace gudgeon::bench
