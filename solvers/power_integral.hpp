// Energies from powers known at five points of a step: Gauss-Lobatto quadrature (order 8) over the
// step, the integral of the polynomial through the five points inside it.
#pragma once

#include <array>

namespace gudgeon {

class PowerIntegral {
  public:
    static constexpr int points = 5;
    /// Where in the step the powers are wanted: 0, ..., 1.
    static const std::array<double, points> node;

    /// Begins a new step of length h (s) where the last one ended. powers[0]: its beginning, W.
    void step(double h, const std::array<double, points>& powers);
    void restart(double energy);

    /// J at a share of the step, 0 to 1.
    double at(double share) const;
    double end() const { return end_; }

  private:
    double begin_ = 0, end_ = 0, h_ = 0;
    std::array<double, points> powers_{};
};

} // namespace gudgeon
