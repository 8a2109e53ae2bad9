// Times that a step must not pass: where something given as a function of time stirs after a rest.
#pragma once

#include "core/model.hpp"

#include <vector>

namespace gudgeon {

/// While all is at rest steps grow without limit, and one that ends beyond a pulse sees nothing of it. So
/// steps end where a constant stretch of a drive, force, actuator or road ends, and where the first change
/// after it is over: the next point of a table, the end of a smooth step. From there error control knows.
/// Increasing, s.
std::vector<double> break_times(const Model& model);

} // namespace gudgeon
