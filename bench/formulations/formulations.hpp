// The table of formulations; README.md says what its columns mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::formulations {

struct Options {
    std::filesystem::path out = "results/formulations";
    std::vector<int> bodies{10, 30, 100, 300, 1000, 3000, 10000};
    std::vector<std::string> formulations{"saddle-point", "saddle-point-klu", "augmented-lagrangian"};
    std::vector<std::string> integrators{"gear", "radau"};
    std::vector<std::string> mechanisms{"chain", "suspension-chain", "four-bar"};
    double end = 0.1; // s
    double rtol = 1e-5;
    int repeats = 7;    // of a timed run
    double budget = 20; // s of CPU time for the repeats of one line
};

/// Writes formulations.csv and .txt into options.out, anew after every line.
void compare_all(const Options& options);

} // namespace gudgeon::formulations
