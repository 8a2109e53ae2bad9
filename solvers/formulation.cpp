#include "solvers/formulation.hpp"

#include "core/assembly.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/block_solver.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace gudgeon {

namespace {
// The sweeps refine as well: with less, they grow in number; with more, passes do (solvers/README.md).
constexpr double sweep_tolerance = 1e-5;
constexpr double worthwhile_fill = 40; // entries of L per unknown of the leading block
constexpr double many_loops = 0.75;    // per body; ladders and suspensions have about a half, nets one

/// Independent loops of the bodies by joints with constraint rows.
int loops(const System& system) {
    const int ground = system.moving; // all that does not move
    std::vector<int> up(system.moving + 1);
    std::iota(up.begin(), up.end(), 0);
    const auto root = [&](int i) {
        i = std::min(i, ground);
        while (up[i] != i)
            i = up[i] = up[up[i]];
        return i;
    };
    int closing = 0;
    for (const JointRecord& joint : system.joints) {
        if (joint.rows == 0)
            continue;
        const int a = root(joint.a.body), b = root(joint.b.body);
        closing += a == b;
        up[a] = b;
    }
    return closing;
}
} // namespace

Formulation formulation_for(const System& system, Formulation asked) {
    if (asked != Formulation::automatic)
        return asked;
    if (loops(system) < many_loops * system.moving)
        return Formulation::saddle_point; // fill cannot be that large; saves the analysis
    AugmentedSolver cholmod(system.velocities());
    cholmod.analyse(SaddleMatrix(system).pattern());
    const double fill = static_cast<double>(cholmod.factor_nonzeros()) / std::max(1, system.velocities());
    return fill > worthwhile_fill ? Formulation::augmented_lagrangian : Formulation::saddle_point;
}

BlockOptions saddle_options(Formulation formulation, int threads) {
    return {.threads = threads,
            .single_precision = true, // the sweeps themselves refine
            .always_klu = formulation == Formulation::saddle_point_klu};
}

std::unique_ptr<LinearSolver> make_saddle_solver(const System& system, Formulation formulation, int threads) {
    if (formulation == Formulation::augmented_lagrangian)
        return std::make_unique<AugmentedSolver>(system.velocities(),
                                                 AugmentedOptions{.tolerance = sweep_tolerance});
    return std::make_unique<BlockSolver>(saddle_options(formulation, threads));
}

} // namespace gudgeon
