// What every gap between two bodies owes, whatever its shape.
#pragma once

#include "contact/point_contact.hpp"
#include "core/force_tools.hpp"

namespace gudgeon::test {

/// A smooth normal force f(depth, rate) with both derivatives.
struct SmoothForce {
    double f, by_depth, by_rate;
    SmoothForce(double depth, double rate)
        : f(3 + 40 * depth + 70 * depth * depth + (2 + 9 * depth) * rate),
          by_depth(40 + 140 * depth + 9 * rate), by_rate(2 + 9 * depth) {}
};

template <class Point> PairWrench wrench_of(const Pair& m, const Point& point) {
    const ContactPoint c = point(m);
    const double rate = depth_gradient(m[0], m[1], c).times(m[0], m[1])(0);
    return point_wrench(m[0], m[1], c.p, SmoothForce(c.depth, rate).f * c.n);
}

/// point: Pair -> ContactPoint, rates: (Pair, its point) -> ContactPointRates.
template <class Point, class Rates>
void check_contact(const Pair& m, const Point& point, const Rates& rates_of, double tolerance = 1e-8) {
    const BodyMotion &a = m[0], &b = m[1];
    const ContactPoint c = point(m);
    const ContactPointRates rates = rates_of(m, c);
    EXPECT_NEAR(c.n.norm(), 1, 1e-14);

    const auto depth = [&](const Pair& x) { return MatX::Constant(1, 1, point(x).depth); };
    const auto place = [&](const Pair& x) { return MatX(point(x).p); };
    const auto normal = [&](const Pair& x) { return MatX(point(x).n); };
    const auto rate = [&](const Pair& x) {
        return MatX(depth_gradient(x[0], x[1], point(x)).times(x[0], x[1]));
    };
    const Gradient<1> gradient = depth_gradient(a, b, c);
    EXPECT_LT(error(dense(gradient), jacobian(m, depth, moved)), tolerance);
    EXPECT_LT(error(dense(rates.p), jacobian(m, place, moved)), tolerance);
    EXPECT_LT(error(dense(rates.n), jacobian(m, normal, moved)), tolerance);
    EXPECT_LT(error(dense(depth_rate_gradient(a, b, c, rates, gradient)), jacobian(m, rate, moved)),
              tolerance);

    // depth' = -n . (v_a - v_b) at the point.
    const Vec3 va = a.v + (a.A * a.w).cross(c.p - a.r), vb = b.v + (b.A * b.w).cross(c.p - b.r);
    EXPECT_NEAR(rate(m)(0), -c.n.dot(va - vb), 1e-12);

    const SmoothForce law(c.depth, rate(m)(0));
    const auto wrench = [&](const Pair& x) { return MatX(dense(wrench_of(x, point))); };
    BlockMatrix C = zero_blocks(), S = zero_blocks();
    add_normal_linearisation(a, b, c, rates, law.f, law.by_depth, law.by_rate, C, S);
    EXPECT_LT(error(dense(C), -jacobian(m, wrench, pushed)), tolerance);
    EXPECT_LT(error(dense(S), -jacobian(m, wrench, moved)), tolerance);

    // One line of action: no resultant; and the wrench is conjugate to the depth.
    const PairWrench w = wrench_of(m, point);
    EXPECT_LT(resultant(w, m).norm(), 1e-13 * (1 + 10 * dense(w).norm()));
    EXPECT_LT((dense(w).transpose() + law.f * dense(gradient)).norm(), 1e-13 * (1 + dense(w).norm()));
}

/// Puts point sb of b at the given place.
inline void place_b(Pair& m, const Vec3& sb, const Vec3& place) { m[1].r = place - m[1].A * sb; }

/// Turns b so that its axis points along a global direction.
inline void point_axis_b(Pair& m, const Vec3& axis, const Vec3& direction) {
    const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(m[1].A * axis, direction).toRotationMatrix();
    m[1].p = euler_parameters(turn * m[1].A).normalized();
    m[1].A = rotation(m[1].p);
}

inline bool finite(const ContactPoint& c) {
    return std::isfinite(c.depth) && c.p.allFinite() && c.n.allFinite();
}
inline bool finite(const ContactPointRates& r) { return dense(r.p).allFinite() && dense(r.n).allFinite(); }

} // namespace gudgeon::test
