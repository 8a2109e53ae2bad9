// Scalar characteristic y(x) of springs, bushings and tables: linear or a shape-preserving spline.
#pragma once

#include <span>
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
};

/// Monotone piecewise cubic (Fritsch-Carlson slopes): no overshoot between points, C1. Beyond the
/// ends it continues with the end slope (force curves) or stays constant (time tables).
class Spline {
  public:
    enum class Ends { linear, constant };

    Spline() = default;
    Spline(const Table& table, Ends ends);

    CurveValue operator()(double x) const;
    /// Second derivative of the curve (jumps at the points).
    double curvature(double x) const;
    bool empty() const { return x_.empty(); }

  private:
    std::size_t interval(double x) const;
    double primitive(double x) const; // integral from x_[0]

    std::vector<double> x_, y_, slope_, area_; // area_[i]: integral from x_[0] to x_[i]
    double at_zero_ = 0;                       // primitive(0)
    Ends ends_ = Ends::linear;
};

} // namespace gudgeon
