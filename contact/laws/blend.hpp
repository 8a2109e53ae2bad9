// Bushing, then hard contact (AP 50, after the free flight). With d the depth into the bushing of thickness
// T, s = d - T, x = s / W over the width W:
//   f = f_b(d)                        s <= 0
//   f = (1 - w) f_b(d) + w f_c(s)     0 < s < W
//   f = f_c(s)                        s >= W
// w = x: weighted sum as printed; w = 3 x^2 - 2 x^3: C1, no kink at either end. f_b is linear or tabulated
// with damping, f_c any single law. Units and signs as in these laws. The bushing's part vanishes beyond T +
// W: where f_c(W) < f_b(T) the force falls over the width, as the formula says; choose W so that it does not.
//
// Two starting speeds: that of the whole contact and that of the hard part, which begins at s = 0.
// Stored: the integral of (1 - w) e_b + w e_c, e the elastic parts, in closed form.
#pragma once

#include "contact/laws/single_law.hpp"

namespace gudgeon {

class Blend {
  public:
    using Bushing = std::variant<Linear, Tabulated>;

    /// thickness > 0 and width > 0 in m.
    Blend(Bushing bushing, SingleLaw hard, double thickness, double width, bool smooth);

    /// inner.depth = outer.depth - thickness, inner.rate = outer.rate.
    NormalForce operator()(const Indentation& outer, const Indentation& inner) const;

    double thickness() const { return thickness_; }
    double width() const { return width_; }
    /// The same with a hard part that follows, at rest, the loading curve of this one.
    Blend loading() const;

  private:
    struct Weight {
        double value, slope; // 1, 1/m
    };
    Weight weight(double s) const;
    double bushing_ramp_energy(double s) const;
    double hard_ramp_energy(double s, const NormalForce& hard) const;

    Bushing bushing_;
    SingleLaw hard_;
    double thickness_, width_;
    bool smooth_;
    double bushing_energy_ = 0;    // J, of the bushing once the ramp is passed
    double bushing_thickness_ = 0; // J, at the beginning of the ramp
    double hard_missing_ = 0;      // J, what the ramp kept from the hard part, per elastic factor
};

} // namespace gudgeon
