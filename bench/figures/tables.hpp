// The tables; bench/README.md says what their columns mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::figures {

struct Options {
    std::filesystem::path out = "figures";
    std::vector<int> bodies{10, 30, 100, 300, 1000, 3000, 10000};
    std::vector<std::string> formulations{"saddle-point", "saddle-point-klu", "augmented-lagrangian"};
    std::vector<std::string> formulation_integrators{"gear", "radau"};
    std::vector<std::string> formulation_mechanisms{"chain", "suspension-chain", "four-bar"};
    double formulation_end = 0.1; // s
    double formulation_rtol = 1e-5;
    int repeats = 7;    // of a timed run
    double budget = 20; // s of CPU time for the repeats of one line
};

void formulations(const Options& options);

} // namespace gudgeon::figures
