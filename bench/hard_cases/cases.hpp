// The themes of the hard cases, one file each.
#pragma once

#include "bench/hard_cases/hard_case.hpp"

namespace gudgeon::hard {

std::vector<HardCase> linkage_cases();
std::vector<HardCase> scale_cases();
std::vector<HardCase> singular_cases();
std::vector<HardCase> long_time_cases();
std::vector<HardCase> quiet_cases();
std::vector<HardCase> contact_cases();
std::vector<HardCase> load_cases();

/// In the order of the report.
inline std::vector<std::vector<HardCase> (*)()> themes() {
    return {linkage_cases, singular_cases, scale_cases, long_time_cases,
            quiet_cases,   contact_cases,  load_cases};
}

} // namespace gudgeon::hard
