#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "kernels.hpp"
#include "models/mechanisms.hpp"
#include "solvers/augmented_solver.hpp"
#include "solvers/complex_klu_solver.hpp"
#include "solvers/consistent.hpp"
#include "solvers/integrator.hpp"
#include "solvers/klu_solver.hpp"

#include <limits>
#include <memory>
#include <stdexcept>

namespace gudgeon::regression {

namespace {

using Complex = std::complex<double>;

/// A mechanism of some fifty bodies on its way, and its matrices at two step lengths, as gear and radau have.
struct Scene {
    System system;
    State state;
    Workspace ws;
    SaddleMatrix saddle;
    std::array<std::vector<double>, 2> values;
    std::array<std::vector<Complex>, 2> complex_values;
    VecX rhs;

    explicit Scene(const Model& model)
        : system(compile(model, standard_force_builders())), ws(make_workspace(system)), saddle(system) {
        const auto integrator = make_integrator("gear", system, {.rtol = 1e-4, .atol = 1e-4});
        integrator->start(initial_state(system));
        for (int i = 0; i < 20; ++i)
            if (!integrator->advance(std::numeric_limits<double>::infinity()).ok)
                throw std::runtime_error("the mechanism does not move");
        state = integrator->state();
        ws.angles = state.angles;
        set_motion(system, state.q, state.u, ws);
        linearise(system, state.t, state.lambda.data(), ws);
        const Complex pair(0.74, 0.84); // near Radau's
        for (int i : {0, 1}) {
            values[i].resize(saddle.pattern().nonzeros());
            complex_values[i].resize(saddle.pattern().nonzeros());
            const double a = i == 0 ? 1e3 : 2e3;
            saddle.assemble(system, ws, a, 1 / a, values[i]);
            saddle.assemble(system, ws, a * pair, 1.0 / (a * pair), complex_values[i]);
        }
        rhs = VecX::Ones(2 * saddle.pattern().cols);
    }
    std::span<double> right_hand_sides() { return {rhs.data(), static_cast<std::size_t>(rhs.size())}; }
};
using ScenePointer = std::shared_ptr<Scene>;

void demand(const FactorStatus& status) {
    if (!status.ok())
        throw std::runtime_error("the mechanism's matrix is singular");
}

void evaluation_kernels(Kernels& list, const std::string& suffix,
                        const std::function<ScenePointer()>& scene) {
    const auto add = [&](const std::string& name, void (*run)(Scene&)) {
        list.push_back({name + suffix, [scene, run] {
                            return counted::Work{[s = scene(), run] { run(*s); }, {}, {}};
                        }});
    };
    add("motion", [](Scene& s) { set_motion(s.system, s.state.q, s.state.u, s.ws); });
    add("residual", [](Scene& s) {
        evaluate_forces(s.system, s.state.t, s.ws);
        evaluate_constraints(s.system, s.state.t, s.state.lambda.data(), false, s.ws);
    });
    add("derivatives", [](Scene& s) { linearise(s.system, s.state.t, s.state.lambda.data(), s.ws); });
    add("matrix/real", [](Scene& s) { s.saddle.assemble(s.system, s.ws, 1e3, 1e-3, s.values[0]); });
    add("matrix/complex", [](Scene& s) {
        s.saddle.assemble(s.system, s.ws, Complex(1e3, 1e3), Complex(5e-4, -5e-4), s.complex_values[0]);
    });
}

void klu_kernels(Kernels& list, const std::string& suffix, const std::function<ScenePointer()>& scene) {
    list.push_back({"klu/refactorise" + suffix, [scene] {
                        const ScenePointer s = scene();
                        const auto klu = std::make_shared<KluSolver>();
                        klu->analyse(s->saddle.pattern());
                        demand(klu->factor(s->values[1]));
                        return counted::Work{[s, klu] {
                                                 for (const auto& values : s->values)
                                                     demand(klu->factor(values));
                                             },
                                             {},
                                             {}};
                    }});
    list.push_back({"klu/solve" + suffix, [scene] { // two right-hand sides, as a sweep has
                        const ScenePointer s = scene();
                        const auto klu = std::make_shared<KluSolver>();
                        klu->analyse(s->saddle.pattern());
                        demand(klu->factor(s->values[0]));
                        return counted::Work{[s, klu] {
                                                 s->rhs.setOnes();
                                                 klu->solve(s->right_hand_sides(), 2);
                                             },
                                             {},
                                             {}};
                    }});
    list.push_back({"klu/refactorise-complex" + suffix, [scene] {
                        const ScenePointer s = scene();
                        const auto klu = std::make_shared<ComplexKluSolver>();
                        klu->analyse(s->saddle.pattern());
                        demand(klu->factor(s->complex_values[1]));
                        return counted::Work{[s, klu] {
                                                 for (const auto& values : s->complex_values)
                                                     demand(klu->factor(values));
                                             },
                                             {},
                                             {}};
                    }});
    list.push_back({"klu/solve-complex" + suffix, [scene] {
                        const ScenePointer s = scene();
                        const auto klu = std::make_shared<ComplexKluSolver>();
                        klu->analyse(s->saddle.pattern());
                        demand(klu->factor(s->complex_values[0]));
                        const auto rhs = std::make_shared<std::vector<Complex>>(s->saddle.pattern().cols);
                        return counted::Work{[klu, rhs] {
                                                 rhs->assign(rhs->size(), 1.0);
                                                 klu->solve(*rhs, 1);
                                             },
                                             {},
                                             {}};
                    }});
}

void cholesky_kernels(Kernels& list, const std::string& suffix, const std::function<ScenePointer()>& scene) {
    list.push_back({"cholmod/factorise" + suffix, [scene] {
                        const ScenePointer s = scene();
                        const auto solver = std::make_shared<AugmentedSolver>(s->system.velocities());
                        solver->analyse(s->saddle.pattern());
                        return counted::Work{[s, solver] {
                                                 for (const auto& values : s->values)
                                                     demand(solver->factor(values));
                                             },
                                             {},
                                             {}};
                    }});
    list.push_back({"cholmod/pass" + suffix, [scene] {
                        const ScenePointer s = scene();
                        const auto solver = std::make_shared<AugmentedSolver>(s->system.velocities());
                        solver->analyse(s->saddle.pattern());
                        demand(solver->factor(s->values[0]));
                        return counted::Work{[s, solver] {
                                                 s->rhs.setOnes();
                                                 solver->pass(s->right_hand_sides().first(s->rhs.size() / 2));
                                             },
                                             {},
                                             {}};
                    }});
    list.push_back({"accelerations" + suffix, [scene] { // normal equations: derivatives of G, factor, solve
                        const ScenePointer s = scene();
                        const auto solver = std::make_shared<ConsistentSolver>(s->system);
                        return counted::Work{[s, solver, acceleration = VecX(), lambda = VecX()]() mutable {
                                                 if (!solver->accelerations(s->state.t, s->state.q,
                                                                            s->state.u, s->ws, acceleration,
                                                                            lambda))
                                                     throw std::runtime_error("no accelerations");
                                             },
                                             {},
                                             {}};
                    }});
}

} // namespace

Kernels system_kernels() {
    Kernels list;
    const std::pair<std::string, std::map<std::string, std::string>> mechanisms[] = {
        {"chain", {{"links", "50"}}}, {"suspension-chain", {{"units", "7"}}}};
    for (const auto& [name, parameters] : mechanisms) {
        const std::function<ScenePointer()> scene = [name, parameters] {
            return std::make_shared<Scene>(build_mechanism(name, parameters));
        };
        for (const auto add : {evaluation_kernels, klu_kernels, cholesky_kernels})
            add(list, "/" + name, scene);
    }
    return list;
}

} // namespace gudgeon::regression
