// Spring-damper-actuator along the line between two points.
//
//   tension T = constant + k (l - l0) + c l' + actuator(t),   l = |P_b - P_a|, n = (P_b - P_a)/l
//   force T n on a at P_a, -T n on b at P_b: positive tension pulls the points together.
//
// A table (tension against l - l0) replaces k. Elastic energy: the integral of the elastic tension from
// l = l0; dissipated power c l'^2; input power -actuator l'.
//
// Where the points coincide (l <= shortest) the line has no direction: the force is zero and the
// stiffness is dT/dl in all directions. That is exact for l0 = 0 without preload, the only case with a
// continuous force there; the tension itself stays finite.
#pragma once

#include "core/force_batch.hpp"
#include "core/system.hpp"
#include "core/time_function.hpp"

#include <memory>
#include <optional>

namespace gudgeon {

struct SpringDamperKernel {
    /// What few springs have, kept out of the element.
    struct Extra {
        Spline table; // tension against elongation; empty: linear
        SharedPart<TimeFunction> actuator;
    };
    struct Element : ForceElement {
        Vec3 sa = Vec3::Zero(), sb = Vec3::Zero(); // m, body frames
        double stiffness = 0, damping = 0;         // N/m, N s/m
        double free_length = 0;                    // m
        double constant = 0;                       // N, tension of a preload without stiffness
        std::shared_ptr<const Extra> extra;
    };
    static constexpr const char* name = "spring-damper";
    static constexpr CouplingMask coupling = couple_all;
    static constexpr double shortest = 1e-12; // m

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
};

/// Elongation at which a table gives a tension, the one closest to zero; nothing if it never does.
std::optional<double> elongation_for(const Table& table, double tension);

/// Batch of all spring-dampers of the model; throws ModelError for a preload its table cannot give.
std::unique_ptr<ForceBatch> build_spring_dampers(const CompileContext& context);

} // namespace gudgeon
