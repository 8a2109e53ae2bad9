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

/// f = value + rate max(t - start, 0): a drive at constant speed.
struct RampFunction {
    double value = 0;
    double rate = 1;
    double start = 0;
};

/// Shape-preserving spline through (times, values); constant beyond the ends.
struct TableFunction {
    Table table;
};

using TimeFunction =
    std::variant<ConstantFunction, HarmonicFunction, SmoothStepFunction, RampFunction, TableFunction>;

TimeValue evaluate(const TimeFunction& f, double t);

} // namespace gudgeon
