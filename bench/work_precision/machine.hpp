// What the times depend on.
#pragma once

#include <nlohmann/json.hpp>

namespace gudgeon::work_precision {

/// processor, cores, load (of the last minute), compiler, build, version, date (UTC); commit where the
/// environment's GUDGEON_COMMIT tells it.
nlohmann::json describe_machine();

} // namespace gudgeon::work_precision
