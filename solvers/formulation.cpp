#include "solvers/formulation.hpp"

#include "core/assembly.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/klu_solver.hpp"

#include <algorithm>

namespace gudgeon {

namespace {
// The sweeps refine as well: with less, they grow in number; with more, passes do (solvers/README.md).
constexpr double sweep_tolerance = 1e-5;
constexpr double worthwhile_fill = 16; // entries of L per unknown of the leading block
} // namespace

Formulation formulation_for(const System& system, Formulation asked) {
    if (asked != Formulation::automatic)
        return asked;
    AugmentedSolver cholmod(system.velocities());
    cholmod.analyse(SaddleMatrix(system).pattern());
    const double fill = static_cast<double>(cholmod.factor_nonzeros()) / std::max(1, system.velocities());
    return fill > worthwhile_fill ? Formulation::augmented_lagrangian : Formulation::saddle_point;
}

std::unique_ptr<LinearSolver> make_saddle_solver(const System& system, Formulation formulation) {
    if (formulation == Formulation::augmented_lagrangian)
        return std::make_unique<AugmentedSolver>(system.velocities(),
                                                 AugmentedOptions{.tolerance = sweep_tolerance});
    return std::make_unique<KluSolver>(KluOptions{.refinements = 0}); // the sweeps themselves refine
}

} // namespace gudgeon
