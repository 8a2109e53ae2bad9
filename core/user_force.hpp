// Forces defined by the user in C++: a callable per force, between two bodies (one may be "ground").
//
//   std::vector<ForceBatchBuilder> builders = standard_force_builders();
//   builders.push_back(user_force_builder({{"wind", {"ground", "bob"},
//       [](const UserForceInput& in, UserForceOutput& out) { out.wrench.force_b = -0.1 * in.b.v; }}}));
//   System system = compile(model, builders);
//
// The law must depend on its input alone and may be called from several threads at once. State of its
// own must not change during a step: an iteration asks again and a rejected step is repeated.
#pragma once

#include "core/force_batch.hpp"
#include "core/system.hpp"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gudgeon {

/// Poses and velocities of both bodies: velocity global, angular velocity in the body frame.
struct UserForceInput {
    double t;
    const BodyMotion& a;
    const BodyMotion& b;
    bool derivatives; // C and S are wanted
};

struct UserForceOutput {
    /// Forces (N, global) at the mass centres and moments (N m, body frames) about them.
    PairWrench wrench;

    /// Derivatives over (v_a, w_a, v_b, w_b), rotations along body-frame increments (types.hpp):
    /// C = -d wrench/du, S = -d wrench/dq, rows (force_a, moment_a, force_b, moment_b). Zero on entry, read
    /// only where input.derivatives and has_derivatives hold. Without them they are formed by central
    /// differences with steps of UserForce::step, 24 calls each.
    bool has_derivatives = false;
    BlockMatrix* C = nullptr;
    BlockMatrix* S = nullptr;

    /// Absent: nothing is stored or dissipated, the power wrench times velocities is input power.
    std::optional<EnergyRates> energies;
};

using UserForceLaw = std::function<void(const UserForceInput&, UserForceOutput&)>;

struct UserForce {
    std::string name;
    std::array<std::string, 2> bodies{"ground", "ground"}; // a, b
    UserForceLaw law;
    double step = 1e-6; // m, rad; m/s, rad/s: of the numerical derivatives
};

struct UserForceKernel {
    struct Element : ForceElement {
        std::shared_ptr<const UserForceLaw> law;
        double step = 1e-6;
    };
    static constexpr const char* name = "user force";
    static constexpr CouplingMask coupling = couple_all;

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
};

/// Builder of a batch of these forces, to be given to compile(). The builder throws ModelError for an
/// unknown body or a missing law.
ForceBatchBuilder user_force_builder(std::vector<UserForce> forces);

} // namespace gudgeon
