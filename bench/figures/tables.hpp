// The tables; bench/README.md says what their columns mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::figures {

struct Options {
    std::filesystem::path out = "figures";
    std::vector<std::string> integrators{"gear", "radau", "auto", "ida", "rk4"};
    std::vector<std::string> scaling_integrators{"gear"}; // ida has eight times the factors on chains
    std::vector<int> bodies{10, 30, 100, 300, 1000, 3000, 10000};
    std::vector<std::string> formulations{"saddle-point", "augmented-lagrangian"};
    std::vector<std::string> formulation_integrators{"gear", "radau"};
    std::vector<std::string> formulation_mechanisms{"chain", "suspension-chain"};
    double formulation_end = 0.1; // s
    double scaling_rtol = 1e-5;
    int steps = 200;    // counted steps of the scaling table
    int repeats = 7;    // of a timed run
    double budget = 20; // s of CPU time for the repeats of one line
};

void scaling(const Options& options);
void formulations(const Options& options);

/// Resident memory of this process in bytes (Linux, /proc/self/status): now and at its largest.
struct Memory {
    double now = 0, peak = 0;
};
Memory resident_memory();

/// Runs a mechanism of about this many bodies for a few steps and prints what its memory grew by; the
/// scaling table calls it in a process of its own.
int print_memory(const std::string& mechanism, int bodies);

} // namespace gudgeon::figures
