// Friction of contacts in whole systems: laws, and the checks that every kind passes.
#pragma once

#include "contact/friction_point.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon::test {

inline Friction lugre() {
    Friction friction;
    friction.kind = "lugre";
    friction.kinetic = 0.3;
    friction.statics = 0.5;
    friction.speed = 0.8;
    friction.sigma0 = 40;
    friction.sigma1 = 0.2;
    friction.sigma2 = 0.05;
    return friction;
}

inline Friction coulomb() {
    Friction friction;
    friction.kinetic = 0.3;
    friction.speed = 1e-3;
    return friction;
}

inline Body free_body(const std::string& name) {
    Body body;
    body.name = name;
    body.mass = 1;
    body.inertia = Mat3::Identity();
    return body;
}

inline void set(const System& system, const State& s, Workspace& ws) {
    ws.z = s.z;
    ws.contacts = s.contacts;
    ws.contacts.start_speed.setConstant(0.1);
    set_motion(system, s.q, s.u, ws);
}

inline VecX forces(const System& system, const State& s, Workspace& ws) {
    set(system, s, ws);
    evaluate_forces(system, 0, ws);
    return ws.f;
}

inline void check_derivatives(const System& system, const State& s) {
    Workspace ws = make_workspace(system);
    set(system, s, ws);
    linearise(system, 0, s.lambda.data(), ws);
    const Linearisation lin = ws.lin;
    const Eigen::Index n = system.velocities();
    MatX by_speed(n, n), by_pose(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
        by_speed.col(j) = test::derivative(
            [&](double h) {
                State other = s;
                other.u[j] += h;
                return MatX(forces(system, other, ws));
            },
            1e-3);
        by_pose.col(j) = test::derivative(
            [&](double h) {
                State other = s;
                VecX step = VecX::Zero(n);
                step[j] = h;
                move(system, step, other.q);
                return MatX(forces(system, other, ws));
            },
            1e-5);
    }
    EXPECT_LT(test::error(test::dense(blocks_as_matrix(system, lin.C)), -by_speed), 1e-8);
    EXPECT_LT(test::error(test::dense(blocks_as_matrix(system, lin.S)), -by_pose), 1e-7);

    ASSERT_EQ(lin.states.size(), static_cast<std::size_t>(system.friction_states()));
    VecX source(system.friction_states()), decay = source;
    for (std::size_t i = 0; i < lin.states.size(); ++i) {
        const Linearisation::StateCoupling& x = lin.states[i];
        ASSERT_EQ(x.state, static_cast<int>(i));
        const MatX by_state = test::derivative([&](double h) {
            State other = s;
            other.z[x.state] += h;
            return MatX(forces(system, other, ws));
        });
        VecX force(n), rate(n);
        const int a = 6 * x.a, b = 6 * x.b;
        force.segment<3>(a) = x.force.ra.transpose();
        force.segment<3>(a + 3) = x.force.ta.transpose();
        force.segment<3>(b) = x.force.rb.transpose();
        force.segment<3>(b + 3) = x.force.tb.transpose();
        rate.segment<3>(a) = x.rate.ra.transpose();
        rate.segment<3>(a + 3) = x.rate.ta.transpose();
        rate.segment<3>(b) = x.rate.rb.transpose();
        rate.segment<3>(b + 3) = x.rate.tb.transpose();
        EXPECT_LT(test::error(force, by_state), 1e-7);
        VecX z_rate(n);
        for (Eigen::Index j = 0; j < n; ++j)
            z_rate[j] = test::derivative(
                [&](double h) {
                    State other = s;
                    other.u[j] += h;
                    set(system, other, ws);
                    state_terms(system, 0, ws, source, decay);
                    return MatX(MatX::Constant(1, 1, source[x.state] - decay[x.state] * s.z[x.state]));
                },
                1e-3)(0);
        EXPECT_LT(test::error(rate, z_rate), 1e-8);
    }
}

/// Friction changes neither momentum; what it takes is what the samples and energies say. plain: the same
/// system without friction. points: every contact rubs at a point, so that its friction is its resultant.
inline void check_balance(const System& plain, const System& rough, const State& s, bool points) {
    Workspace ws = make_workspace(plain), wr = make_workspace(rough);
    State without = initial_state(plain);
    without.q = s.q;
    without.u = s.u;
    const VecX f = forces(rough, s, wr) - forces(plain, without, ws);
    const Vec3 on_a = f.segment<3>(0), on_b = f.segment<3>(6);
    EXPECT_GT(on_b.norm(), 1);
    EXPECT_LT((on_a + on_b).norm(), 1e-12 * on_b.norm());
    const Vec3 moments = wr.motion[0].A * f.segment<3>(3) + wr.motion[1].A * f.segment<3>(9) +
                         wr.motion[0].r.cross(on_a) + wr.motion[1].r.cross(on_b);
    EXPECT_LT(moments.norm(), 1e-12 * on_b.norm());
    const double power = -f.dot(s.u);
    const double extra =
        energies(rough, 0, nullptr, wr).dissipated_power - energies(plain, 0, nullptr, ws).dissipated_power;
    EXPECT_NEAR(extra, power, 1e-10 * std::abs(power));
    sample_contacts(rough, 0, wr);
    sample_contacts(plain, 0, ws);
    Vec3 friction_force = Vec3::Zero();
    double sampled = 0;
    for (std::size_t k = 0; k < rough.contacts.size(); ++k) {
        friction_force += wr.samples[k].friction_force;
        sampled += wr.samples[k].dissipated_power - ws.samples[k].dissipated_power;
        const double resultant = wr.samples[k].friction_force.norm();
        EXPECT_GE(wr.samples[k].friction, resultant - 1e-12);
        if (points) {
            EXPECT_NEAR(wr.samples[k].friction, resultant, 1e-12);
        }
        EXPECT_NEAR(wr.samples[k].friction_force.dot(wr.samples[k].normal_force), 0, 1e-9);
    }
    EXPECT_LT((friction_force - on_b).norm(), 1e-12 * on_b.norm());
    EXPECT_NEAR(sampled, power, 1e-10 * std::abs(power));
}

} // namespace gudgeon::test
