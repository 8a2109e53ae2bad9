#include "scene.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/block_solver.hpp"
#include "solvers/complex_klu_solver.hpp"
#include "solvers/klu_solver.hpp"

#include <algorithm>
#include <stdexcept>

namespace gudgeon::kernels {

namespace {

using Complex = std::complex<double>;

void demand(const FactorStatus& status) {
    if (!status.ok())
        throw std::runtime_error("the mechanism's matrix is singular");
}

template <class Solver>
constexpr bool is_complex =
    std::is_same_v<Solver, ComplexKluSolver> || std::is_same_v<Solver, ComplexBlockSolver>;
template <class Solver>
constexpr bool by_blocks = std::is_same_v<Solver, BlockSolver> || std::is_same_v<Solver, ComplexBlockSolver>;

template <class Solver> const auto& values_for(const Solver&, const Scene& s) {
    if constexpr (is_complex<Solver>)
        return s.complex_values;
    else
        return s.values;
}

template <class Solver> std::shared_ptr<Solver> make_solver(const Scene& s, int threads) {
    if constexpr (std::is_same_v<Solver, AugmentedSolver>)
        return std::make_shared<Solver>(s.system.velocities());
    else if constexpr (by_blocks<Solver>) // as the integrators have it
        return std::make_shared<Solver>(BlockOptions{.threads = threads, .single_precision = true});
    else
        return std::make_shared<Solver>();
}

/// Analysed, and factored once with other values.
template <class Solver> std::shared_ptr<Solver> factored(const Scene& s, int which, int threads) {
    const auto solver = make_solver<Solver>(s, threads);
    solver->analyse(s.saddle.pattern());
    demand(solver->factor(values_for(*solver, s)[which]));
    return solver;
}

/// Both matrices in turn, with the pivots that are there.
template <class Solver>
void refactorisation(Kernels& list, const std::string& name, const SceneSource& scene) {
    const auto prepare = [scene](const Setup& setup) {
        const ScenePointer s = scene(setup);
        const auto run = [s, solver = factored<Solver>(*s, 1, setup.threads)] {
            for (const auto& values : values_for(*solver, *s))
                demand(solver->factor(values));
        };
        return counted::Work{run, {}, {}};
    };
    list.push_back({.name = name, .prepare = prepare, .bodies = scene_bodies, .threaded = by_blocks<Solver>});
}

template <class Solver>
void solution(Kernels& list, const std::string& name, const SceneSource& scene, int columns) {
    const auto prepare = [scene, columns](const Setup& setup) {
        const ScenePointer s = scene(setup);
        const auto solver = factored<Solver>(*s, 0, setup.threads);
        if constexpr (is_complex<Solver>) {
            const auto run = [solver, columns,
                              rhs = std::vector<Complex>(columns * s->saddle.pattern().cols)]() mutable {
                rhs.assign(rhs.size(), 1.0);
                solver->solve(rhs, columns);
            };
            return counted::Work{run, {}, {}};
        } else {
            const auto run = [s, solver, columns] {
                s->rhs.setOnes();
                solver->solve(s->right_hand_sides(columns), columns);
            };
            return counted::Work{run, {}, {}};
        }
    };
    list.push_back({.name = name, .prepare = prepare, .bodies = scene_bodies, .threaded = by_blocks<Solver>});
}

/// One pass of the method of multipliers.
void pass(Kernels& list, const std::string& name, const SceneSource& scene) {
    const auto prepare = [scene](const Setup& setup) {
        const ScenePointer s = scene(setup);
        const auto run = [s, solver = factored<AugmentedSolver>(*s, 0, setup.threads)] {
            s->rhs.setOnes();
            solver->pass(s->right_hand_sides(1));
        };
        return counted::Work{run, {}, {}};
    };
    list.push_back({name, prepare, scene_bodies});
}

} // namespace

Kernels solver_kernels() {
    Kernels list;
    for_scenes([&list](const std::string& suffix, const SceneSource& scene) {
        refactorisation<BlockSolver>(list, "blocks/refactorise" + suffix, scene);
        solution<BlockSolver>(list, "blocks/solve-one" + suffix, scene, 1);
        solution<BlockSolver>(list, "blocks/solve" + suffix, scene, 2); // as a sweep has
        refactorisation<ComplexBlockSolver>(list, "blocks/refactorise-complex" + suffix, scene);
        solution<ComplexBlockSolver>(list, "blocks/solve-complex" + suffix, scene, 1);
        solution<ComplexBlockSolver>(list, "blocks/solve-complex-two" + suffix, scene, 2);
        refactorisation<KluSolver>(list, "klu/refactorise" + suffix, scene);
        solution<KluSolver>(list, "klu/solve-one" + suffix, scene, 1);
        solution<KluSolver>(list, "klu/solve" + suffix, scene, 2);
        refactorisation<ComplexKluSolver>(list, "klu/refactorise-complex" + suffix, scene);
        solution<ComplexKluSolver>(list, "klu/solve-complex" + suffix, scene, 1);
        solution<ComplexKluSolver>(list, "klu/solve-complex-two" + suffix, scene, 2);
        refactorisation<AugmentedSolver>(list, "cholmod/factorise" + suffix, scene);
        pass(list, "cholmod/pass" + suffix, scene);
        solution<AugmentedSolver>(list, "cholmod/solve-one" + suffix, scene, 1);
        solution<AugmentedSolver>(list, "cholmod/solve" + suffix, scene, 2);
    });
    return list;
}

} // namespace gudgeon::kernels
