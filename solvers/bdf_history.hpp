// Past points of a multistep method on a variable grid, and the weights of its polynomials.
#pragma once

#include "core/archive.hpp"
#include "core/types.hpp"

#include <array>
#include <span>

namespace gudgeon {

/// Lagrange weights: value at t of the polynomial through `times` is sum w_i y_i.
void interpolation_weights(std::span<const double> times, double t, double* w);

/// Backward differentiation: slope at t of the polynomial through (t, y) and past points is
/// a0 y + sum a_i y_i. Returns a0, fills a_i.
double bdf_weights(std::span<const double> past, double t, double* a);

/// Integral over [from, to] of the polynomial through `times`: sum w_i y_i.
void integration_weights(std::span<const double> times, double from, double to, double* w);

/// Ring of the newest points (t, q, u, lambda, friction states z); point 0 is the newest. No allocation after
/// reserve().
class BdfHistory {
  public:
    static constexpr int capacity = 7; // order 5 is weighed by six points, besides the next

    void reserve(Eigen::Index q_size, Eigen::Index u_size, Eigen::Index rows, Eigen::Index states = 0,
                 int threads = 1);
    void clear() { points_ = 0; }

    int points() const { return points_; }
    double time(int i) const { return slot(i).t; }
    const VecX& q(int i) const { return slot(i).q; }
    const VecX& u(int i) const { return slot(i).u; }
    /// Times of the newest n points.
    std::span<const double> times(int n) const;

    /// Storage for the point being computed; push() makes it the newest.
    const VecX& next_q() const { return slots_[(head_ + 1) % capacity].q; }
    const VecX& next_u() const { return slots_[(head_ + 1) % capacity].u; }
    const VecX& next_lambda() const { return slots_[(head_ + 1) % capacity].lambda; }
    const VecX& next_z() const { return slots_[(head_ + 1) % capacity].z; }
    VecX& next_z() { return slots_[(head_ + 1) % capacity].z; }
    VecX& next_q() { return slots_[(head_ + 1) % capacity].q; }
    VecX& next_u() { return slots_[(head_ + 1) % capacity].u; }
    VecX& next_lambda() { return slots_[(head_ + 1) % capacity].lambda; }
    void push(double t);

    /// q = sum w_i q_i, u = sum w_i u_i over the newest n points.
    void combine(int n, const double* w, VecX& q, VecX& u) const;
    void combine_lambda(int n, const double* w, VecX& lambda) const;
    void combine_z(int n, const double* w, VecX& z) const;

    void visit(Archive& archive) { archive(slots_, times_, head_, points_); }

  private:
    struct Slot {
        double t = 0;
        VecX q, u, lambda, z;
        void visit(Archive& archive) { archive(t, q, u, lambda, z); }
    };
    const Slot& slot(int i) const { return slots_[(head_ - i + 2 * capacity) % capacity]; }

    std::array<Slot, capacity> slots_;
    std::array<double, capacity> times_{};
    int head_ = 0, points_ = 0, threads_ = 1;
};

} // namespace gudgeon
