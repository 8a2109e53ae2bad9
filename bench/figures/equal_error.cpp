#include "bench/figures/equal_error.hpp"

#include <cmath>

namespace gudgeon::figures {

namespace {

std::vector<std::string> columns(const std::vector<std::string>& integrators) {
    std::vector<std::string> names{"problem", "error"};
    names.insert(names.end(), integrators.begin(), integrators.end());
    names.insert(names.end(), {"gear_over_radau", "auto_over_better"});
    return names;
}

} // namespace

double seconds_at_error(const std::vector<WorkPoint>& points, const std::string& integrator, double error) {
    const WorkPoint* tighter = nullptr;
    for (auto point = points.rbegin(); point != points.rend(); ++point) {
        if (point->integrator != integrator)
            continue;
        if (point->error > error) {
            if (!tighter)
                return std::nan("");
            const double share = std::log(error / tighter->error) / std::log(point->error / tighter->error);
            return tighter->seconds * std::pow(point->seconds / tighter->seconds, share);
        }
        tighter = &*point;
    }
    return tighter ? tighter->seconds : std::nan("");
}

EqualErrorTable::EqualErrorTable(const std::vector<std::string>& integrators)
    : integrators_(integrators), table_(columns(integrators)) {}

void EqualErrorTable::add(const std::string& problem, const std::vector<WorkPoint>& points) {
    for (const double error : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
        std::vector<std::string> cells{problem, cell(error)};
        for (const std::string& integrator : integrators_)
            cells.push_back(cell(seconds_at_error(points, integrator, error)));
        const double gear = seconds_at_error(points, "gear", error),
                     radau = seconds_at_error(points, "radau", error),
                     chosen = seconds_at_error(points, "auto", error);
        cells.push_back(cell(gear / radau));
        cells.push_back(cell(chosen / std::fmin(gear, radau)));
        table_.add(cells);
    }
}

void EqualErrorTable::write(const std::filesystem::path& folder) const {
    table_.write(folder, "equal_error", "CPU time (s) at equal error (m), interpolated between tolerances.");
}

} // namespace gudgeon::figures
