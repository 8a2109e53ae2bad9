// Tabulated: f = table(d) + c d' (damped.hpp). The table starts at (0, 0) and never falls; between its points
// a monotone cubic, beyond the last one its end slope (core/curve.hpp).
#pragma once

#include "contact/laws/damped.hpp"

#include <memory>
#include <vector>

namespace gudgeon {

struct Tabulated {
    struct Data {
        Spline curve;              // N against m
        std::vector<double> knots; // m, where its third derivative jumps
    };
    std::shared_ptr<const Data> data;
    double damping = 0; // N s/m

    Tabulated(const Table& table, double damping_)
        : data(std::make_shared<Data>(Data{Spline(table, Spline::Ends::linear), table.x})),
          damping(damping_) {}

    NormalForce operator()(const Indentation& c) const {
        if (!(c.depth > 0))
            return {};
        return damped_force(data->curve(c.depth), damping, c.rate);
    }
};

} // namespace gudgeon
