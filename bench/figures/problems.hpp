// Mechanisms with independent reference solutions.
#pragma once

#include "core/model.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace gudgeon::figures {

struct Problem {
    std::string name;      // in the tables
    std::string mechanism; // ready mechanism and its parameters
    std::map<std::string, std::string> parameters;
    double end = 1;                             // s
    std::vector<std::string> channels;          // compared, m
    std::vector<double> times;                  // of the comparison, s
    std::vector<std::vector<double>> reference; // [channel][time]; empty: no reference
    std::vector<double> rk4_steps;              // s

    Model model() const;
};

/// pendulum, slider-crank, heavy-top, chain-4, chain-16, suspension-1, suspension-4, hmmwv-corner.
/// folder: the reference tables (tests/data/reference); data: those made by this program with another
/// method (bench/data). Throws std::runtime_error for a missing table.
std::vector<Problem> reference_problems(const std::filesystem::path& folder,
                                        const std::filesystem::path& data);

/// suspension-chain of any size, without reference unless a table exists for it.
Problem suspension_problem(int units, const std::filesystem::path& folder);

} // namespace gudgeon::figures
