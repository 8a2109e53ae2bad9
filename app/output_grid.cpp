#include "app/output_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon {

OutputGrid::OutputGrid(double end, double every) : end_(end), every_(every) {
    constexpr double most = 1e8;
    const double ratio = end / every;
    if (!(ratio <= most))
        throw std::invalid_argument(
            fmt::format("{} s every {} s are more than {} output times", end, every, most));
    const double whole = std::floor(ratio + 1e-6);
    const bool rest = ratio - whole > 1e-6;
    intervals_ = std::max<std::size_t>(1, static_cast<std::size_t>(whole) + rest);
}

} // namespace gudgeon
