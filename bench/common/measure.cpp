#include "bench/common/measure.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>

namespace gudgeon::bench {

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
    if (values.empty())
        return std::numeric_limits<double>::quiet_NaN();
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

SimulationOptions simulation_options(const Settings& settings) {
    SimulationOptions options;
    options.integrator = settings.integrator;
    options.integration.rtol = options.integration.atol = settings.rtol;
    options.integration.step = settings.step;
    options.integration.formulation = formulation_named(settings.formulation);
    return options;
}

} // namespace gudgeon::bench
