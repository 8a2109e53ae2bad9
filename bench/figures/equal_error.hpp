// CPU time at equal error: what the runs at given tolerances cost where they meet the same error.
#pragma once

#include "bench/figures/table.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::figures {

/// One run. Points of an integrator come from the loosest tolerance (longest step) to the tightest.
struct WorkPoint {
    std::string integrator;
    double error;   // m
    double seconds; // CPU time
};

/// CPU time of an integrator at an error, interpolated between the logarithms of the tightest two
/// neighbouring runs that embrace it. All below: that of the loosest; the tightest above: NaN.
double seconds_at_error(const std::vector<WorkPoint>& points, const std::string& integrator, double error);

class EqualErrorTable {
  public:
    explicit EqualErrorTable(const std::vector<std::string>& integrators);
    void add(const std::string& problem, const std::vector<WorkPoint>& points);
    /// folder/equal_error.csv and .txt
    void write(const std::filesystem::path& folder) const;

  private:
    std::vector<std::string> integrators_;
    Table table_;
};

} // namespace gudgeon::figures
