#include "solvers/formulation.hpp"

#include "solvers/augmented_solver.hpp"
#include "solvers/klu_solver.hpp"

namespace gudgeon {

namespace {
// The sweeps refine as well: with less, they grow in number; with more, passes do (solvers/README.md).
constexpr double sweep_tolerance = 1e-5;
} // namespace

Formulation formulation_for(const System&, Formulation asked, bool) {
    return asked == Formulation::automatic ? Formulation::saddle_point : asked;
}

std::unique_ptr<LinearSolver> make_saddle_solver(const System& system, Formulation formulation) {
    if (formulation == Formulation::augmented_lagrangian)
        return std::make_unique<AugmentedSolver>(system.velocities(),
                                                 AugmentedOptions{.tolerance = sweep_tolerance});
    return std::make_unique<KluSolver>(KluOptions{.refinements = 0}); // the sweeps themselves refine
}

} // namespace gudgeon
