// Clocks, and what the settings of a measured run are.
#pragma once

#include "solvers/simulation.hpp"

#include <string>
#include <vector>

namespace gudgeon::bench {

/// CPU time of this process, all threads, s.
double cpu_seconds();
double wall_seconds();

double median(std::vector<double> values);

struct Settings {
    std::string integrator = "gear";
    double rtol = 1e-6; // and atol
    double step = 0;    // rk4
    std::string formulation = "saddle-point";
};

SimulationOptions simulation_options(const Settings& settings);

} // namespace gudgeon::bench
