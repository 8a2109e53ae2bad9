// Random pairs of bodies and independent numerical differentiation for the kernel tests.
#pragma once

#include "core/batch.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <random>

namespace gudgeon::test {

using Pair = std::array<BodyMotion, 2>;
using Mat12 = Eigen::Matrix<double, 12, 12>;
using Vec12 = Eigen::Matrix<double, 12, 1>;

inline Vec3 random_vector(std::mt19937& rng, double size = 1) {
    std::uniform_real_distribution<double> range(-size, size);
    const double x = range(rng), y = range(rng), z = range(rng);
    return {x, y, z};
}

inline Vec4 random_orientation(std::mt19937& rng) {
    std::normal_distribution<double> normal;
    Vec4 p;
    for (double& x : p)
        x = normal(rng);
    return p.normalized();
}

inline BodyMotion random_motion(std::mt19937& rng) {
    BodyMotion m;
    m.p = random_orientation(rng);
    m.A = rotation(m.p);
    m.r = random_vector(rng, 2);
    m.v = random_vector(rng, 3);
    m.w = random_vector(rng, 4);
    return m;
}

inline Pair random_pair(std::mt19937& rng) {
    const BodyMotion a = random_motion(rng), b = random_motion(rng);
    return {a, b};
}

/// Rotation matrix to Euler parameters.
inline Vec4 euler_parameters(const Mat3& m) {
    const Eigen::Quaterniond q(m);
    return {q.w(), q.x(), q.y(), q.z()};
}

/// Coordinate k of (r_a, theta_a, r_b, theta_b) changed by h.
inline Pair moved(Pair m, int k, double h) {
    BodyMotion& body = m[k / 6];
    if (k % 6 < 3) {
        body.r[k % 6] += h;
    } else {
        body.p = turned(body.p, h * Vec3::Unit(k % 6 - 3));
        body.A = rotation(body.p);
    }
    return m;
}

/// Velocity k of (v_a, w_a, v_b, w_b) changed by h.
inline Pair pushed(Pair m, int k, double h) {
    BodyMotion& body = m[k / 6];
    (k % 6 < 3 ? body.v : body.w)[k % 3] += h;
    return m;
}

/// The same bodies after a time at constant velocities: an exact motion without accelerations.
inline Pair advanced(Pair m, double dt) {
    for (BodyMotion& body : m) {
        body.r += dt * body.v;
        body.p = turned(body.p, dt * body.w);
        body.A = rotation(body.p);
    }
    return m;
}

inline Vec12 velocities(const Pair& m) {
    Vec12 u;
    u << m[0].v, m[0].w, m[1].v, m[1].w;
    return u;
}

/// Derivative at 0 of f(h), which returns a matrix: central differences, extrapolated to order 6.
template <class F> MatX derivative(F f, double h = 4e-3) {
    const auto central = [&](double step) -> MatX { return (MatX(f(step)) - MatX(f(-step))) / (2 * step); };
    const MatX d1 = central(h), d2 = central(h / 2), d3 = central(h / 4);
    const MatX e1 = (4 * d2 - d1) / 3, e2 = (4 * d3 - d2) / 3;
    return (16 * e2 - e1) / 15;
}

/// Second derivative at 0, extrapolated likewise.
template <class F> MatX second_derivative(F f, double h = 2e-2) {
    const MatX middle = f(0.0);
    const auto central = [&](double step) -> MatX {
        return (MatX(f(step)) - 2 * middle + MatX(f(-step))) / (step * step);
    };
    const MatX d1 = central(h), d2 = central(h / 2), d3 = central(h / 4);
    const MatX e1 = (4 * d2 - d1) / 3, e2 = (4 * d3 - d2) / 3;
    return (16 * e2 - e1) / 15;
}

/// Columns d f / d(coordinate k) along the twelve coordinates of a pair; change: moved or pushed.
template <class F> MatX jacobian(const Pair& m, F f, Pair (*change)(Pair, int, double)) {
    MatX out;
    for (int k = 0; k < 12; ++k) {
        const MatX column = derivative([&](double h) { return MatX(f(change(m, k, h))); });
        if (k == 0)
            out.resize(column.rows(), 12);
        out.col(k) = column;
    }
    return out;
}

template <int R> MatX dense(const Gradient<R>& g) {
    MatX out(R, 12);
    out << g.ra, g.ta, g.rb, g.tb;
    return out;
}

inline Mat12 dense(const BlockMatrix& m) {
    Mat12 out;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            out.block<3, 3>(3 * i, 3 * j) = m.block[i][j];
    return out;
}

inline BlockMatrix zero_blocks() {
    BlockMatrix m;
    m.set_zero();
    return m;
}

/// Largest entry outside the blocks a mask allows.
inline double outside(const BlockMatrix& m, CouplingMask mask) {
    double largest = 0;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            if (!(mask & coupling_bit(i, j)))
                largest = std::max(largest, m.block[i][j].cwiseAbs().maxCoeff());
    return largest;
}

/// Largest difference relative to the size of the truth (and to 1 below that).
inline double error(const MatX& value, const MatX& truth) {
    if (!value.allFinite() || !truth.allFinite())
        return std::numeric_limits<double>::infinity();
    return (value - truth).cwiseAbs().maxCoeff() / std::max(1.0, truth.cwiseAbs().maxCoeff());
}

} // namespace gudgeon::test
