#include "core/curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {

/// Slopes before limiting: the parabola through three neighbours; at the ends its end slope.
std::vector<double> three_point_slopes(const std::vector<double>& width, const std::vector<double>& secant) {
    const std::size_t n = secant.size(); // intervals
    std::vector<double> slope(n + 1, secant[0]);
    if (n == 1)
        return slope;
    for (std::size_t i = 1; i < n; ++i)
        slope[i] = (width[i] * secant[i - 1] + width[i - 1] * secant[i]) / (width[i - 1] + width[i]);
    slope[0] = 2 * secant[0] - slope[1];
    slope[n] = 2 * secant[n - 1] - slope[n - 1];
    return slope;
}

/// Fritsch-Carlson: slopes take the sign of their secants, then shrink into the circle of radius 3.
void limit_slopes(const std::vector<double>& secant, std::vector<double>& slope) {
    const std::size_t n = secant.size();
    for (std::size_t i = 0; i <= n; ++i) {
        const double left = secant[i > 0 ? i - 1 : 0];
        const double right = secant[i < n ? i : n - 1];
        if (left * right <= 0 || slope[i] * left < 0)
            slope[i] = 0;
    }
    for (std::size_t i = 0; i < n; ++i) {
        if (secant[i] == 0)
            continue;
        const double radius = std::hypot(slope[i], slope[i + 1]) / std::abs(secant[i]);
        if (radius > 3) {
            slope[i] *= 3 / radius;
            slope[i + 1] *= 3 / radius;
        }
    }
}

} // namespace

std::optional<TableProblem> find_problem(const Table& table) {
    const auto& [x, y] = table;
    if (x.size() < 2)
        return TableProblem{"/x", fmt::format("a table of {} points", x.size()), "at least 2 points"};
    if (x.size() != y.size())
        return TableProblem{"/y", fmt::format("{} values of y for {} of x", y.size(), x.size()),
                            "as many values of y as of x"};
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (!std::isfinite(x[i]))
            return TableProblem{fmt::format("/x/{}", i), fmt::format("{} is not finite", x[i]),
                                "finite numbers"};
        if (!std::isfinite(y[i]))
            return TableProblem{fmt::format("/y/{}", i), fmt::format("{} is not finite", y[i]),
                                "finite numbers"};
        if (i > 0 && x[i] <= x[i - 1])
            return TableProblem{fmt::format("/x/{}", i), fmt::format("{} after {}", x[i], x[i - 1]),
                                "x strictly increasing"};
    }
    return std::nullopt;
}

Spline::Spline(const Table& table, Ends ends) : x_(table.x), y_(table.y) {
    if (const auto problem = find_problem(table))
        throw std::invalid_argument(
            fmt::format("table{}: {}; allowed: {}", problem->where, problem->problem, problem->allowed));
    const std::size_t n = x_.size() - 1;
    std::vector<double> width(n), secant(n);
    for (std::size_t i = 0; i < n; ++i) {
        width[i] = x_[i + 1] - x_[i];
        secant[i] = (y_[i + 1] - y_[i]) / width[i];
    }
    slope_ = three_point_slopes(width, secant);
    if (ends == Ends::constant)
        slope_.front() = slope_.back() = 0;
    limit_slopes(secant, slope_);

    area_.assign(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        area_[i + 1] = area_[i] + width[i] * (y_[i] + y_[i + 1]) / 2 +
                       width[i] * width[i] * (slope_[i] - slope_[i + 1]) / 12;
    at_zero_ = primitive(0);
}

Spline::Piece Spline::piece(double x) const {
    if (x < x_.front())
        return {x - x_.front(), y_.front(), slope_.front(), 0, 0, 0};
    if (x >= x_.back())
        return {x - x_.back(), y_.back(), slope_.back(), 0, 0, area_.back()};
    const auto i = static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin()) - 1;
    const double h = x_[i + 1] - x_[i];
    const double secant = (y_[i + 1] - y_[i]) / h;
    return {x - x_[i],
            y_[i],
            slope_[i],
            (3 * secant - 2 * slope_[i] - slope_[i + 1]) / h,
            (slope_[i] + slope_[i + 1] - 2 * secant) / (h * h),
            area_[i]};
}

double Spline::primitive(double x) const {
    const Piece p = piece(x);
    return p.area + p.s * (p.y + p.s * (p.slope / 2 + p.s * (p.c2 / 3 + p.s * p.c3 / 4)));
}

CurveValue Spline::operator()(double x) const {
    if (empty())
        return {};
    const Piece p = piece(x);
    return {p.y + p.s * (p.slope + p.s * (p.c2 + p.s * p.c3)), p.slope + p.s * (2 * p.c2 + p.s * 3 * p.c3),
            primitive(x) - at_zero_};
}

double Spline::curvature(double x) const {
    if (empty())
        return 0;
    const Piece p = piece(x);
    return 2 * p.c2 + 6 * p.c3 * p.s;
}

} // namespace gudgeon
