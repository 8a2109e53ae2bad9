// The tables; bench/README.md says what their columns mean.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::figures {

struct Options {
    std::filesystem::path out = "figures", reference = GUDGEON_REFERENCE, data = GUDGEON_BENCH_DATA;
    std::vector<std::string> integrators{"gear", "radau", "auto", "ida", "rk4"};
    std::vector<std::string> problems; // empty: all
    std::vector<double> tolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
    std::vector<int> bodies{10, 30, 100, 300, 1000, 3000, 10000};
    std::vector<int> units{1, 4, 16, 64};
    std::vector<double> targets{1e-3, 1e-5, 1e-7}; // m, chassis height
    std::vector<std::string> formulations{"saddle-point", "augmented-lagrangian"};
    std::vector<std::string> formulation_integrators{"gear", "radau"};
    std::vector<std::string> formulation_mechanisms{"chain", "suspension-chain"};
    double formulation_end = 0.1; // s
    double formulation_rtol = 1e-5;
    int repeats = 7;    // of a timed run
    double budget = 20; // s of CPU time for the repeats of one line
};

void work_precision(const Options& options);
void suspension(const Options& options);
void formulations(const Options& options);

} // namespace gudgeon::figures
