// Explicit Runge-Kutta pairs with dense output: coefficients only.
//
//   Dormand & Prince 5(4), 6 stages, J. Comp. Appl. Math. 6 (1980); dense output of order 4 (Shampine);
//   Dormand & Prince 8(5, 3), 12 stages, with 3 further ones dense output of order 7: Hairer, Norsett,
//   Wanner, Solving Ordinary Differential Equations I, 2nd ed., II.5 and II.6 (DOP853).
//
// Stage j is k_j = f(t + c_j h, y + h sum a_ji k_i). The row after the last stage holds the weights of the
// step itself, so that k at its end, which is the first stage of the next step, is one more stage.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace gudgeon {

struct PairTerm {
    int stage;
    double weight;
};

struct ExplicitPair {
    const char* name;
    int order;                                // of the step
    int error_order;                          // the error estimate falls with this power of h
    int stages;                               // of the step: y at its end is row number `stages` of a
    int dense_stages;                         // further ones, after the one at the end
    std::vector<double> c;                    // stages + 1 + dense_stages
    std::vector<std::vector<PairTerm>> a;     // rows of the same number, entries that are not zero
    std::vector<std::vector<PairTerm>> error; // one or two estimates, h times these sums of stages
    std::vector<std::vector<double>>
        powers; // dense output: weight of stage j at x is sum powers[j][i] x^(i+1)

    int all_stages() const { return stages + 1 + dense_stages; }
    /// Weights of all stages for y(t + x h) = y(t) + h sum w_j k_j, 0 <= x <= 1; w has all_stages().
    void dense_weights(double x, std::span<double> w) const;
};

/// order: 5 or 8. Throws std::invalid_argument for another.
const ExplicitPair& explicit_pair(int order);

} // namespace gudgeon
