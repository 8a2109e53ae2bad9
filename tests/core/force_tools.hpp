// Checks that every force kernel has to pass.
#pragma once

#include "core/force_batch.hpp"
#include "core/motion_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon::test {

/// Two bodies and what a kernel may read besides.
struct Scene {
    Pair m;
    double t = 0.3;
    int moving = 2;
    double angle = 0, angle_rate = 0;

    Evaluation evaluation() const {
        Evaluation e;
        e.t = t;
        e.t_accepted = t;
        e.body = m.data();
        e.moving = moving;
        e.angle = &angle;
        e.angle_rate = &angle_rate;
        return e;
    }
    Scene with(const Pair& other, double time) const {
        Scene s = *this;
        s.m = other;
        s.t = time;
        return s;
    }
};

inline Vec12 dense(const PairWrench& w) {
    Vec12 out;
    out << w.force_a, w.moment_a, w.force_b, w.moment_b;
    return out;
}

/// Resultant force and moment about the origin of the global frame.
inline Vec6 resultant(const PairWrench& w, const Pair& m) {
    Vec6 out;
    out << w.force_a + w.force_b,
        m[0].r.cross(w.force_a) + m[0].A * w.moment_a + m[1].r.cross(w.force_b) + m[1].A * w.moment_b;
    return out;
}

template <class Kernel> VecX wrench_at(const Scene& scene, const typename Kernel::Element& x, const Pair& m) {
    const Scene s = scene.with(m, scene.t);
    return dense(Kernel::wrench(s.evaluation(), x));
}

/// C = -df/du and S = -df/dq against differences, inside the declared blocks.
template <class Kernel>
void check_derivatives(const Scene& scene, const typename Kernel::Element& x, double tolerance = 1e-9) {
    const auto f = [&](const Pair& m) { return MatX(wrench_at<Kernel>(scene, x, m)); };
    BlockMatrix c = zero_blocks(), s = zero_blocks();
    Kernel::linearise(scene.evaluation(), x, c, s);
    const Mat12 truth_c = -jacobian(scene.m, f, pushed), truth_s = -jacobian(scene.m, f, moved);
    EXPECT_LT(error(dense(c), truth_c), tolerance);
    EXPECT_LT(error(dense(s), truth_s), tolerance);
    EXPECT_EQ(outside(c, Kernel::coupling), 0.0);
    EXPECT_EQ(outside(s, Kernel::coupling), 0.0);
}

/// d(kinetic)/dt = wrench . u, so wrench . u + d(elastic)/dt + dissipated - input = 0.
template <class Kernel> void check_energy(const Scene& scene, const typename Kernel::Element& x) {
    const auto elastic = [&](double h) {
        const Scene s = scene.with(advanced(scene.m, h), scene.t + h);
        return MatX::Constant(1, 1, Kernel::energies(s.evaluation(), x).elastic);
    };
    const Evaluation e = scene.evaluation();
    const EnergyRates rates = Kernel::energies(e, x);
    const double kinetic_rate = dense(Kernel::wrench(e, x)).dot(velocities(scene.m));
    const double stored_rate = derivative(elastic, 2e-3)(0);
    const double size = 1 + std::abs(kinetic_rate) + std::abs(stored_rate) + rates.dissipated_power +
                        std::abs(rates.input_power);
    EXPECT_LT(std::abs(kinetic_rate + stored_rate + rates.dissipated_power - rates.input_power) / size, 1e-9);
    EXPECT_GE(rates.dissipated_power, 0);
}

template <class Kernel> void check_balance(const Scene& scene, const typename Kernel::Element& x) {
    const PairWrench w = Kernel::wrench(scene.evaluation(), x);
    EXPECT_GT(dense(w).norm(), 0);
    EXPECT_LT(resultant(w, scene.m).norm(), 1e-13 * (1 + 10 * dense(w).norm()));
}

/// Everything a force between two moving bodies owes.
template <class Kernel> void check_pair_force(const Scene& scene, const typename Kernel::Element& x) {
    check_derivatives<Kernel>(scene, x);
    check_energy<Kernel>(scene, x);
    check_balance<Kernel>(scene, x);
}

} // namespace gudgeon::test
