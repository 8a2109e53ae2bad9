// Scalar characteristic y(x) of springs, bushings and tables: linear or a shape-preserving spline.
#pragma once

#include "core/equality.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace gudgeon {

/// Value, slope and integral from 0 (stored energy of a force against displacement).
struct CurveValue {
    double value = 0;
    double slope = 0;
    double integral = 0;
};

/// What the user wrote: at least two points, x strictly increasing, all finite.
struct Table {
    std::vector<double> x;
    std::vector<double> y;
    bool empty() const { return x.empty(); }
    GUDGEON_EQUALITY(Table)
};

/// What keeps a table from being a curve. where: JSON pointer inside the table ("/x/2").
struct TableProblem {
    std::string where, problem, allowed;
};
std::optional<TableProblem> find_problem(const Table& table);

/// Monotone piecewise cubic through the points (Fritsch & Carlson, SIAM J. Numer. Anal. 17, 1980, eq. 3.2
/// and the circle alpha^2 + beta^2 <= 9 of section 4): no overshoot between points, C1 everywhere.
/// Slopes at the points start from the three-point formula. Beyond the ends the curve continues with
/// the end slope (Ends::linear, force curves) or stays constant (Ends::constant, time tables: the
/// slopes at both ends are zero then). Two points with linear ends are a straight line.
class Spline {
  public:
    enum class Ends { linear, constant };

    Spline() = default;
    /// Throws std::invalid_argument if find_problem(table) finds one.
    Spline(const Table& table, Ends ends);

    /// The integral is exact and measured from x = 0, inside the table or not. An empty spline is zero.
    CurveValue operator()(double x) const;
    /// Second derivative of the curve (jumps at the points: the value to the right of x).
    double curvature(double x) const;
    bool empty() const { return x_.empty(); }

  private:
    struct Piece {
        double s = 0; // x - x_[i]
        double y = 0, slope = 0, c2 = 0, c3 = 0;
        double area = 0;
    };
    Piece piece(double x) const;
    double primitive(double x) const; // integral from x_[0]

    std::vector<double> x_, y_, slope_, area_; // area_[i]: integral from x_[0] to x_[i]
    double at_zero_ = 0;                       // primitive(0)
};

} // namespace gudgeon
