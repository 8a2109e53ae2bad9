// `gudgeon statics` and `gudgeon modes`.
#pragma once

#include "app/arguments.hpp"
#include "app/console.hpp"

namespace gudgeon {

/// Equilibrium, reactions and forces: a table, and in the folder statics.json and equilibrium.json (the model
/// that starts there). Returns Exit::ok, or Exit::stopped where there is none.
int statics(const RestArguments& arguments, const Console& console);

/// Eigenfrequencies, damping ratios and shapes: a table, and in the folder modes.json and modes.csv.
int modes(const RestArguments& arguments, const Console& console);

} // namespace gudgeon
