#include "solvers/error_norm.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gudgeon {

namespace {
// Keeps the worst body; a NaN wins and stays.
void keep_worst(ErrorNorm::Value& worst, double sum, int body) {
    if (!std::isnan(worst.norm) && !(sum <= worst.norm))
        worst = {sum, body};
}
/// The worst of the bodies, whatever the number of threads: the first of equals.
template <class Sum> ErrorNorm::Value worst_body(int bodies, int threads, Sum&& sum) {
    constexpr std::ptrdiff_t grain = 512;
    constexpr int pieces = 16;
    if (threads <= 1 || bodies < threads * grain) {
        ErrorNorm::Value worst;
        for (int i = 0; i < bodies; ++i)
            keep_worst(worst, sum(i), i);
        return worst;
    }
    std::array<ErrorNorm::Value, pieces> found;
    for_ranges(pieces, std::min(threads, pieces), 1, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t k = begin; k < end; ++k)
            for (int i = static_cast<int>(bodies * k / pieces); i < bodies * (k + 1) / pieces; ++i)
                keep_worst(found[k], sum(i), i);
    });
    ErrorNorm::Value worst;
    for (const ErrorNorm::Value& piece : found)
        if (piece.body >= 0)
            keep_worst(worst, piece.norm, piece.body);
    return worst;
}

ErrorNorm::Value root(ErrorNorm::Value worst) {
    worst.norm = std::sqrt(worst.norm / 13);
    return worst;
}

// Position, orientation as one, velocities; a NaN is the largest.
int largest_part(const Vec3& position, double orientation, const Vec6& velocity) {
    Eigen::Matrix<double, 10, 1> parts;
    parts << position.cwiseAbs(), std::abs(orientation), velocity.cwiseAbs();
    int worst = 0;
    for (int k = 0; k < 10; ++k) {
        if (std::isnan(parts[k]))
            return k;
        if (parts[k] > parts[worst])
            worst = k;
    }
    return worst;
}
} // namespace

ErrorNorm::ErrorNorm(const System& system, double rtol, double atol, int threads)
    : moving_(system.moving), threads_(threads), rtol_(rtol), atol_(atol),
      q_weight_(VecX::Ones(system.positions())), u_weight_(VecX::Ones(system.velocities())),
      z_weight_(VecX::Ones(system.friction_states())), z_scale_(system.state_scales) {}

void ErrorNorm::set_scale(const VecX& q, const VecX& u, const VecX& z) {
    constexpr std::ptrdiff_t grain = 8192;
    for_ranges(q.size(), threads_, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t j = begin; j < end; ++j)
            q_weight_[j] = 1 / (rtol_ * std::abs(q[j]) + atol_);
    });
    for_ranges(u.size(), threads_, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t j = begin; j < end; ++j)
            u_weight_[j] = 1 / (rtol_ * std::abs(u[j]) + atol_);
    });
    for (Eigen::Index j = 0; j < z.size(); ++j)
        z_weight_[j] = 1 / (rtol_ * std::abs(z[j]) + atol_ * z_scale_[j]);
}

ErrorNorm::Value ErrorNorm::difference(const VecX& q, const VecX& q2, const VecX& u, const VecX& u2,
                                       double factor) const {
    Value worst = worst_body(moving_, threads_, [&](int i) {
        const double sum = (q.segment<7>(7 * i) - q2.segment<7>(7 * i))
                               .cwiseProduct(q_weight_.segment<7>(7 * i))
                               .squaredNorm() +
                           (u.segment<6>(6 * i) - u2.segment<6>(6 * i))
                               .cwiseProduct(u_weight_.segment<6>(6 * i))
                               .squaredNorm();
        return sum * factor * factor;
    });
    if (const int i = worst.body; i >= 0) {
        const Eigen::Matrix<double, 7, 1> dq =
            (q.segment<7>(7 * i) - q2.segment<7>(7 * i)).cwiseProduct(q_weight_.segment<7>(7 * i));
        worst.component = largest_part(
            dq.head<3>(), dq.tail<4>().norm(),
            (u.segment<6>(6 * i) - u2.segment<6>(6 * i)).cwiseProduct(u_weight_.segment<6>(6 * i)));
    }
    return root(worst);
}

ErrorNorm::Value ErrorNorm::increment(const double* step, const double* du) const {
    const double rotation_weight = 0.5 / (rtol_ + atol_); // |dp| = |dtheta| / 2, |p| = 1
    Value worst = worst_body(moving_, threads_, [&](int i) {
        const Eigen::Map<const Vec6> x(step + 6 * std::ptrdiff_t(i)), v(du + 6 * std::ptrdiff_t(i));
        return x.head<3>().cwiseProduct(q_weight_.segment<3>(7 * i)).squaredNorm() +
               rotation_weight * rotation_weight * x.tail<3>().squaredNorm() +
               v.cwiseProduct(u_weight_.segment<6>(6 * i)).squaredNorm();
    });
    if (const int i = worst.body; i >= 0) {
        const Eigen::Map<const Vec6> x(step + 6 * std::ptrdiff_t(i)), v(du + 6 * std::ptrdiff_t(i));
        worst.component =
            largest_part(x.head<3>().cwiseProduct(q_weight_.segment<3>(7 * i)),
                         rotation_weight * x.tail<3>().norm(), v.cwiseProduct(u_weight_.segment<6>(6 * i)));
    }
    return root(worst);
}

const char* ErrorNorm::component_name(int component) {
    static constexpr std::array<const char*, 10> names{"x",  "y",  "z",  "orientation", "vx",
                                                       "vy", "vz", "wx", "wy",          "wz"};
    return component >= 0 && component < std::ssize(names) ? names[component] : "unknown";
}

ErrorNorm::Value ErrorNorm::rates(const VecX& q, const VecX& u) const {
    Value worst;
    for (int i = 0; i < moving_; ++i) {
        const double sum = q.segment<7>(7 * i).cwiseProduct(q_weight_.segment<7>(7 * i)).squaredNorm() +
                           u.segment<6>(6 * i).cwiseProduct(u_weight_.segment<6>(6 * i)).squaredNorm();
        keep_worst(worst, sum, i);
    }
    return root(worst);
}

ErrorNorm::Value ErrorNorm::states(const VecX& dz) const {
    Value worst;
    for (Eigen::Index j = 0; j < dz.size(); ++j) {
        const double x = dz[j] * z_weight_[j];
        keep_worst(worst, x * x, -1);
    }
    return root(worst);
}

} // namespace gudgeon
