// Friction laws: coefficient vector mu against slip velocity v, force on the sliding side -N mu.
//
//   coulomb         mu = mu_k v/|v|, linear below a threshold speed v0: mu_k v/v0 (Ambrosio; continuous)
//   coulomb-smooth  mu = mu_k (3/2 s - 1/2 s^3) v/|v|, s = |v|/v0 <= 1 (C1 at the threshold)
//   lugre           mu = sigma0 z + sigma1 z' + sigma2 v,  z' = v - sigma0 |v|/g(|v|) z   (AU 14-15)
//                   g = mu_k + (mu_s - mu_k) exp(-(|v|/v_s)^exponent)
//   dahl            lugre with sigma1 = sigma2 = 0 and g = mu_k
//
// The slip velocity has one component along a line (D = 1) or lies in a plane of contact (D = 3, m/s). z is
// the bristles' deflection (m), sigma0 in 1/m, sigma1 and sigma2 in s/m: force per normal force. AU 15 is
// written with |v| where the paper prints v sgn(v). A coulomb law creeps under load by v0 F/(mu_k N); the
// laws with bristles do not: below mu_k they settle at z = F/(sigma0 N).
//
// Energy: with a varying normal force the bristles' deflection stores no energy that could be had back, so
// all friction power N mu.v counts as dissipated; with bristles it may be negative for an instant, while
// they spring back, by at most 1/2 sigma0 z^2 N altogether.
//
// Where N = 0 (bodies apart) bristles relax as free ones do, z' = -(sigma0/sigma1) z, at most by
// `free_decay`.
#pragma once

#include "core/model.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

enum class FrictionKind { coulomb, coulomb_smooth, bristles };

struct FrictionLaw {
    FrictionKind kind = FrictionKind::coulomb;
    double kinetic = 0, statics = 0; // mu_k, mu_s
    double speed = 1, exponent = 2;  // m/s: threshold or Stribeck speed
    double sigma0 = 0, sigma1 = 0, sigma2 = 0;

    bool has_state() const { return kind == FrictionKind::bristles; }
    /// Deflection that changes mu by 1, m.
    double state_scale() const { return 1 / sigma0; }
    /// Decay of the bristles of bodies that do not touch, 1/s.
    double free_decay() const {
        constexpr double most = 1e4;
        return sigma1 > 0 ? std::min(sigma0 / sigma1, most) : most;
    }
};

/// Of a friction that validate() has passed.
FrictionLaw compile_friction(const Friction& friction);

/// mu and its derivatives at a slip velocity and a deflection; z' = source - decay z with source = v.
template <int D> struct FrictionValue {
    using Vector = Eigen::Matrix<double, D, 1>;
    using Matrix = Eigen::Matrix<double, D, D>;
    Vector mu = Vector::Zero();
    Matrix by_speed = Matrix::Zero();      // d mu / dv at fixed z
    double by_state = 0;                   // d mu / dz, times the unit matrix
    double decay = 0;                      // 1/s
    Matrix rate_by_speed = Matrix::Zero(); // d z' / dv
};

template <int D>
FrictionValue<D> evaluate_friction(const FrictionLaw& law, const Eigen::Matrix<double, D, 1>& v,
                                   const Eigen::Matrix<double, D, 1>& z) {
    FrictionValue<D> out;
    const auto unit = FrictionValue<D>::Matrix::Identity();
    const double speed = v.norm();
    if (law.kind != FrictionKind::bristles) {
        const double s = speed / law.speed;
        double factor = law.kinetic / law.speed, slope = 0; // mu = factor v, slope = d factor/d speed / speed
        if (s >= 1) {
            factor = law.kinetic / speed;
            slope = -factor / (speed * speed);
        } else if (law.kind == FrictionKind::coulomb_smooth) {
            slope = -factor / (law.speed * law.speed);
            factor *= 1.5 - 0.5 * s * s;
        }
        out.mu = factor * v;
        out.by_speed = factor * unit + slope * v * v.transpose();
        return out;
    }
    const double power = law.statics > law.kinetic ? std::pow(speed / law.speed, law.exponent) : 0;
    const double rise = (law.statics - law.kinetic) * std::exp(-power), g = law.kinetic + rise;
    out.decay = law.sigma0 * speed / g;
    // d decay/d speed = sigma0 (1/g - speed g'/g^2), speed g' = -rise exponent power
    const double decay_slope = law.sigma0 * (g + rise * law.exponent * power) / (g * g);
    out.rate_by_speed = unit;
    if (speed > 0)
        out.rate_by_speed -= z * (decay_slope / speed * v).transpose();
    out.mu = law.sigma0 * z + law.sigma1 * (v - out.decay * z) + law.sigma2 * v;
    out.by_speed = law.sigma1 * out.rate_by_speed + law.sigma2 * unit;
    out.by_state = law.sigma0 - law.sigma1 * out.decay;
    return out;
}

} // namespace gudgeon
