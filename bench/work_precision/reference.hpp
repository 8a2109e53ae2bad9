// Makes the converged references of bench/data anew.
#pragma once

#include "bench/work_precision/problems.hpp"

namespace gudgeon::work_precision {

/// Runs the problem by both of its methods, steps ending at the times of comparison, and writes both files
/// with a head that tells how they were made and by how much they differ. Nothing to do where the problem
/// has a reference from elsewhere. Throws std::runtime_error where a run stops.
void make_references(const Problem& problem, const std::filesystem::path& data);

} // namespace gudgeon::work_precision
