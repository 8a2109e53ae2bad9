// Energies from powers known at five points of a step: Gauss-Lobatto quadrature (order 8) over the
// step, the integral of the polynomial through the five points inside it.
#pragma once

#include "core/types.hpp"

#include <array>

namespace gudgeon {

class PowerIntegral {
  public:
    static constexpr int points = 5;
    /// Where in the step the powers are wanted: 0, ..., 1.
    static const std::array<double, points> node;

    /// Begins a new step of length h (s) where the last one ended. powers[0]: its beginning, W; each holds
    /// all the powers that are integrated side by side.
    void step(double h, const std::array<VecX, points>& powers);
    void restart(const VecX& energies);

    /// J at a share of the step, 0 to 1.
    VecX at(double share) const;
    const VecX& end() const { return end_; }

  private:
    VecX begin_, end_;
    double h_ = 0;
    std::array<VecX, points> powers_{};
};

} // namespace gudgeon
