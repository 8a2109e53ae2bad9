// Mechanisms that pass singular positions.
#pragma once

#include "core/model.hpp"

#include <vector>

namespace gudgeon::hard {

/// Crank and rod of 1 m and 1 kg, slider of 1 kg on the x axis; crank at this angle above it, rising at a
/// rate. In space: a ball between crank and rod and a cross at the slider, so that no row repeats another.
Model equal_bars(double angle, double rate, bool in_space);

/// Two shafts at a right angle, along X and Y, joined by a cross, the second with its mass centre 0.1 m off
/// its axis: sin(turn of the first) sin(turn of the second) = 0.
Model square_shafts(double angle, double rate);

/// The ready four-bar laid flat along +x, its cranks turning about +Y at these rates (rad/s), the couplers
/// between their tops.
Model flat_chain(const std::vector<double>& rates);

} // namespace gudgeon::hard
