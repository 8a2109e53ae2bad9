#include "solvers/bdf_history.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

void interpolation_weights(std::span<const double> times, double t, double* w) {
    const std::size_t n = times.size();
    for (std::size_t i = 0; i < n; ++i) {
        double above = 1, below = 1; // one division a weight
        for (std::size_t j = 0; j < n; ++j)
            if (j != i) {
                above *= t - times[j];
                below *= times[i] - times[j];
            }
        w[i] = above / below;
    }
}

double bdf_weights(std::span<const double> past, double t, double* a) {
    const std::size_t n = past.size();
    double a0 = 0;
    for (std::size_t i = 0; i < n; ++i)
        a0 += 1 / (t - past[i]);
    for (std::size_t i = 0; i < n; ++i) {
        a[i] = 1 / (past[i] - t);
        for (std::size_t j = 0; j < n; ++j)
            if (j != i)
                a[i] *= (t - past[j]) / (past[i] - past[j]);
    }
    return a0;
}

void integration_weights(std::span<const double> times, double from, double to, double* w) {
    // Gauss-Legendre with four points is exact to degree 7
    constexpr std::size_t most_points = 8;
    static constexpr double node[2] = {0.3399810435848563, 0.8611363115940526};
    static constexpr double weight[2] = {0.6521451548625461, 0.3478548451374538};
    const std::size_t n = times.size();
    std::array<double, most_points> at{};
    std::fill(w, w + n, 0.0);
    const double half = 0.5 * (to - from), middle = 0.5 * (to + from);
    for (int k = 0; k < 2; ++k)
        for (const double sign : {-1.0, 1.0}) {
            interpolation_weights(times, middle + sign * half * node[k], at.data());
            for (std::size_t i = 0; i < n; ++i)
                w[i] += half * weight[k] * at[i];
        }
}

void BdfHistory::reserve(Eigen::Index q_size, Eigen::Index u_size, Eigen::Index rows, Eigen::Index states,
                         int threads) {
    threads_ = threads;
    for (Slot& s : slots_) {
        s.q = VecX::Zero(q_size);
        s.u = VecX::Zero(u_size);
        s.lambda = VecX::Zero(rows);
        s.z = VecX::Zero(states);
    }
}

std::span<const double> BdfHistory::times(int n) const {
    return {times_.data(), static_cast<std::size_t>(n)};
}

void BdfHistory::push(double t) {
    head_ = (head_ + 1) % capacity;
    slots_[head_].t = t;
    points_ = std::min(points_ + 1, capacity - 1); // one slot stays free for the next point
    for (int i = 0; i < points_; ++i)
        times_[i] = slot(i).t;
}

namespace {

constexpr std::ptrdiff_t grain = 8192; // numbers for a thread

template <int N>
void combine_range(const double* w, const std::array<const double*, BdfHistory::capacity>& in, double* y,
                   std::ptrdiff_t begin, std::ptrdiff_t end) {
    for (std::ptrdiff_t j = begin; j < end; ++j) {
        double s = w[0] * in[0][j];
        for (int i = 1; i < N; ++i)
            s += w[i] * in[i][j];
        y[j] = s;
    }
}

void combine_vectors(int n, const double* w, const std::array<const double*, BdfHistory::capacity>& in,
                     int threads, VecX& out) {
    // fixed lengths let the compiler use vector instructions
    static constexpr std::array ranges{combine_range<1>, combine_range<2>, combine_range<3>, combine_range<4>,
                                       combine_range<5>, combine_range<6>, combine_range<7>};
    const auto range = ranges[n - 1];
    double* y = out.data();
    for_ranges(out.size(), threads, grain,
               [&](std::ptrdiff_t begin, std::ptrdiff_t end) { range(w, in, y, begin, end); });
}

} // namespace

void BdfHistory::combine(int n, const double* w, VecX& q, VecX& u) const {
    std::array<const double*, capacity> in{};
    for (int i = 0; i < n; ++i)
        in[i] = slot(i).q.data();
    combine_vectors(n, w, in, threads_, q);
    for (int i = 0; i < n; ++i)
        in[i] = slot(i).u.data();
    combine_vectors(n, w, in, threads_, u);
}

void BdfHistory::combine_z(int n, const double* w, VecX& z) const {
    std::array<const double*, capacity> in{};
    for (int i = 0; i < n; ++i)
        in[i] = slot(i).z.data();
    combine_vectors(n, w, in, threads_, z);
}

void BdfHistory::combine_lambda(int n, const double* w, VecX& lambda) const {
    std::array<const double*, capacity> in{};
    for (int i = 0; i < n; ++i)
        in[i] = slot(i).lambda.data();
    combine_vectors(n, w, in, threads_, lambda);
}

} // namespace gudgeon
