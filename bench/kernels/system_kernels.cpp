#include "scene.hpp"
#include "solvers/articulated_body.hpp"
#include "solvers/consistent.hpp"
#include "solvers/ida_equations.hpp"
#include "solvers/motion_equations.hpp"

#include <stdexcept>

namespace gudgeon::kernels {

namespace {

using Complex = std::complex<double>;

void evaluation_kernels(Kernels& list, const std::string& suffix, const SceneSource& scene) {
    const auto add = [&](const std::string& name, void (*run)(Scene&)) {
        const auto prepare = [scene, run](const Setup& setup) {
            return counted::Work{[s = scene(setup), run] { run(*s); }, {}, {}};
        };
        list.push_back({name + suffix, prepare, scene_bodies, 1, true});
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

/// The equations as ida wants them, at the scene's point.
struct IdaPoint {
    ScenePointer scene;
    IdaEquations equations;
    std::vector<double> y, ydot, out, values;

    explicit IdaPoint(const ScenePointer& s, int threads)
        : scene(s), equations(s->system, Rows::independent, threads), y(equations.size()), ydot(y.size()),
          out(y.size()), values(equations.pattern().nonzeros()) {
        equations.workspace().angles = s->state.angles;
        equations.pack(s->state, y.data());
        equations.set(y.data());
        equations.pack_rates(s->state.t, y.data(), VecX::Zero(s->system.velocities()), ydot.data());
    }
    void residual() {
        if (!equations.residual(scene->state.t, y.data(), ydot.data(), out.data()))
            throw std::runtime_error("a residual that is no number");
    }
    void jacobian() { equations.jacobian(scene->state.t, 1e3, y.data(), values); }
};

void ida_kernels(Kernels& list, const std::string& suffix, const SceneSource& scene) {
    const auto add = [&](const std::string& name, void (IdaPoint::*run)()) {
        const auto prepare = [scene, run](const Setup& setup) {
            const auto point = std::make_shared<IdaPoint>(scene(setup), setup.threads);
            return counted::Work{[point, run] { (*point.*run)(); }, {}, {}};
        };
        list.push_back({name + suffix, prepare, scene_bodies, 1, true});
    };
    add("ida/residual", &IdaPoint::residual);
    add("ida/jacobian", &IdaPoint::jacobian);
}

/// Normal equations: derivatives of G, factor, solve.
void acceleration_kernels(Kernels& list, const std::string& suffix, const SceneSource& scene) {
    const auto prepare = [scene](const Setup& setup) {
        const ScenePointer s = scene(setup);
        const auto solver = std::make_shared<ConsistentSolver>(s->system);
        const auto run = [s, solver, acceleration = VecX(), lambda = VecX()]() mutable {
            if (!solver->accelerations(s->state.t, s->state.q, s->state.u, s->ws, acceleration, lambda))
                throw std::runtime_error("no accelerations");
        };
        return counted::Work{run, {}, {}};
    };
    list.push_back({"accelerations" + suffix, prepare, scene_bodies});
}

/// Joint coordinates at the scene's point.
struct TreePoint {
    ScenePointer scene;
    std::unique_ptr<MotionEquations> equations;
    TreeKinematics tree;
    ArticulatedBody articulated;
    std::vector<LinkMotion> links;
    Workspace ws;
    VecX s, w;
    MotionRates rates;

    explicit TreePoint(const ScenePointer& from)
        : scene(from), equations(make_motion_equations(from->system, {.formulation = Formulation::tree})),
          tree(from->system), articulated(from->system, tree.tree()), links(tree.make_links()), ws(from->ws),
          rates(equations->make_rates()) {
        equations->load(from->state, s, w);
        tree.take(from->state.q, from->state.u, s, w);
        poses();
        evaluate_forces(from->system, from->state.t, ws);
    }
    void poses() { tree.set_motion(s, w, ws.motion, links); }
    void recursion() { articulated.solve(links, ws.motion, ws.f, rates.speeds); }
    void evaluation() {
        if (!equations->rates(scene->state.t, s, w, scene->state.z, nullptr, ws, rates).ok())
            throw std::runtime_error("no accelerations");
    }
};

/// Poses, articulated bodies, and one whole evaluation as explicit integrators ask for it.
void tree_kernels(Kernels& list, const std::string& suffix, const SceneSource& scene) {
    const auto add = [&](const std::string& name, void (TreePoint::*run)()) {
        const auto prepare = [scene, run](const Setup& setup) {
            const auto point = std::make_shared<TreePoint>(scene(setup));
            return counted::Work{[point, run] { (*point.*run)(); }, {}, {}};
        };
        list.push_back({name + suffix, prepare, scene_bodies});
    };
    add("tree/motion", &TreePoint::poses);
    add("tree/articulated", &TreePoint::recursion);
    add("tree/evaluation", &TreePoint::evaluation);
}

} // namespace

Kernels system_kernels() {
    Kernels list;
    for_scenes([&list](const std::string& suffix, const SceneSource& scene) {
        for (const auto add : {evaluation_kernels, ida_kernels, acceleration_kernels, tree_kernels})
            add(list, suffix, scene);
    });
    return list;
}

} // namespace gudgeon::kernels
