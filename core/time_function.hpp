// Functions of time for drives, applied forces and roads: value and two derivatives.
#pragma once

#include "core/curve.hpp"

#include <variant>

namespace gudgeon {

/// Value, first and second time derivative at one instant.
struct TimeValue {
    double value = 0;
    double rate = 0;
    double acceleration = 0;
};

/// f = value
struct ConstantFunction {
    double value = 1;
};

/// f = offset + amplitude sin(2 pi frequency t + phase); frequency in Hz, phase in rad.
struct HarmonicFunction {
    double amplitude = 1;
    double frequency = 1;
    double phase = 0;
    double offset = 0;
};

/// From `from` at t <= start to `to` at t >= end by the quintic 10 s^3 - 15 s^4 + 6 s^5 (C2).
struct SmoothStepFunction {
    double start = 0;
    double end = 1;
    double from = 0;
    double to = 1;
};

/// f = value + rate max(t - start, 0): a drive at constant speed. At t = start the rate is already there.
struct RampFunction {
    double value = 0;
    double rate = 1;
    double start = 0;
};

/// Shape-preserving spline through the points (x: times, y: values); constant beyond the ends, which it
/// meets with zero rate. A table that is no curve gives zero and is refused by validate().
class TableFunction {
  public:
    explicit TableFunction(Table table);
    const Table& table() const { return table_; }
    const Spline& spline() const { return spline_; }

  private:
    Table table_;
    Spline spline_;
};

using TimeFunction =
    std::variant<ConstantFunction, HarmonicFunction, SmoothStepFunction, RampFunction, TableFunction>;

TimeValue evaluate(const TimeFunction& f, double t);

} // namespace gudgeon
