#include "core/time_function.hpp"

#include <cmath>

namespace gudgeon {

namespace {

struct Evaluator {
    double t;

    TimeValue operator()(const ConstantFunction& f) const { return {f.value, 0, 0}; }

    TimeValue operator()(const HarmonicFunction& f) const {
        const double omega = 2 * 3.14159265358979323846 * f.frequency;
        const double s = f.amplitude * std::sin(omega * t + f.phase);
        const double c = f.amplitude * std::cos(omega * t + f.phase);
        return {f.offset + s, omega * c, -omega * omega * s};
    }

    TimeValue operator()(const SmoothStepFunction& f) const {
        if (t <= f.start)
            return {f.from, 0, 0};
        if (t >= f.end)
            return {f.to, 0, 0};
        const double length = f.end - f.start;
        const double rise = f.to - f.from;
        const double s = (t - f.start) / length;
        return {f.from + rise * s * s * s * (10 + s * (-15 + 6 * s)),
                rise * 30 * s * s * (1 - s) * (1 - s) / length,
                rise * 60 * s * (1 - s) * (1 - 2 * s) / (length * length)};
    }

    TimeValue operator()(const RampFunction& f) const {
        if (t < f.start)
            return {f.value, 0, 0};
        return {f.value + f.rate * (t - f.start), f.rate, 0};
    }

    TimeValue operator()(const TableFunction& f) const {
        const CurveValue c = f.spline()(t);
        return {c.value, c.slope, f.spline().curvature(t)};
    }
};

} // namespace

TableFunction::TableFunction(Table table) : table_(std::move(table)) {
    if (!find_problem(table_))
        spline_ = Spline(table_, Spline::Ends::constant);
}

TimeValue evaluate(const TimeFunction& f, double t) { return std::visit(Evaluator{t}, f); }

} // namespace gudgeon
