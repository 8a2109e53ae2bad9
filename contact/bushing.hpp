// Six-component bushing between the joint frames of two bodies (AP 49, with balanced moments).
//
//   c_1..3 = d      displacement of P_b from P_a, components along the axes of a's joint frame (m)
//   c_4..6 = theta  rotation vector of b's joint frame relative to a's, in a's joint frame (rad)
//   g_i = preload_i + k_i c_i + damping_i c_i'        with a table: table_i(c_i) instead of k_i c_i
//   wrench = -B^T g, B the gradient of c: forces and moments on the two bodies balance
//
// Elastic energy: sum of the integrals of preload_i + k_i c_i (or table_i) from 0, so that
// 1/2 d^T K d + 1/2 theta^T K theta without preload; dissipated power sum of damping_i c_i'^2.
// Valid for |theta| < pi, where the rotation vector is unique.
//
// With global_axes both frames are parallel to the global axes in the pose as given (fixed in a and b).
#pragma once

#include "core/force_batch.hpp"
#include "core/system.hpp"

#include <array>
#include <memory>

namespace gudgeon {

/// Preload and stiffness; components 0..2 translation (N, N/m), 3..5 rotation (N m, N m/rad).
struct LinearElasticity {
    Vec6 preload = Vec6::Zero(), stiffness = Vec6::Zero();
    void evaluate(const Vec6& c, Vec6& force, Vec6* slope) const {
        force = preload + stiffness.cwiseProduct(c);
        if (slope)
            *slope = stiffness;
    }
    double energy(const Vec6& c) const { return c.dot(preload + 0.5 * stiffness.cwiseProduct(c)); }
};

/// The same with a table on some axes (which replaces the stiffness there).
struct TabulatedElasticity {
    LinearElasticity linear; // stiffness zero where there is a table
    std::shared_ptr<const std::array<Spline, 6>> tables;
    void evaluate(const Vec6& c, Vec6& force, Vec6* slope) const;
    double energy(const Vec6& c) const;
};

template <class Elasticity> struct BushingKernel {
    struct Element : ForceElement {
        Vec3 sa = Vec3::Zero(), sb = Vec3::Zero();                 // m, body frames
        Mat3 axes_a = Mat3::Identity(), axes_b = Mat3::Identity(); // joint frames in the bodies
        Vec4 qa{1, 0, 0, 0}, qb{1, 0, 0, 0};                       // their Euler parameters
        Vec6 damping = Vec6::Zero();                               // N s/m, N m s/rad
        Elasticity elasticity;
    };
    static constexpr const char* name = "bushing";
    static constexpr CouplingMask coupling = couple_all;

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
};

using LinearBushing = BushingKernel<LinearElasticity>;
using TabulatedBushing = BushingKernel<TabulatedElasticity>;

/// Batches of the bushings without tables, and of those with tables.
ForceBatchBuilder bushing_builder();
ForceBatchBuilder tabulated_bushing_builder();

} // namespace gudgeon
