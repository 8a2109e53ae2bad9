#include "scene.hpp"

#include "contact/standard_forces.hpp"
#include "models/mechanisms.hpp"
#include "solvers/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

namespace gudgeon::kernels {

const std::vector<std::string>& scene_mechanisms() {
    static const std::vector<std::string> names{"chain", "suspension-chain"};
    return names;
}

Model sized_model(const std::string& mechanism, int bodies) {
    if (mechanism == "chain")
        return build_mechanism(mechanism, {{"links", std::to_string(std::max(1, bodies))}});
    const long units = std::max(1L, std::lround(bodies / 7.0));
    return build_mechanism(mechanism, {{"units", std::to_string(units)}});
}

Scene::Scene(const std::string& mechanism, const Setup& setup)
    : system(compile(sized_model(mechanism, setup.bodies), standard_force_builders())),
      ws(make_workspace(system, setup.threads)), saddle(system) {
    const auto integrator = make_integrator("gear", system, {.rtol = 1e-4, .atol = 1e-4});
    integrator->start(initial_state(system));
    for (int i = 0; i < 20; ++i)
        if (!integrator->advance(std::numeric_limits<double>::infinity()).ok)
            throw std::runtime_error("the mechanism does not move");
    state = integrator->state();
    ws.angles = state.angles;
    set_motion(system, state.q, state.u, ws);
    linearise(system, state.t, state.lambda.data(), ws);
    const std::complex<double> pair(0.74, 0.84); // near Radau's
    for (int i : {0, 1}) {
        values[i].resize(saddle.pattern().nonzeros());
        complex_values[i].resize(saddle.pattern().nonzeros());
        const double a = i == 0 ? 1e3 : 2e3;
        saddle.assemble(system, ws, a, 1 / a, values[i]);
        saddle.assemble(system, ws, a * pair, 1.0 / (a * pair), complex_values[i]);
    }
    rhs = VecX::Ones(2 * saddle.pattern().cols);
}

ScenePointer scene(const std::string& mechanism, const Setup& setup) {
    static std::weak_ptr<Scene> kept;
    static std::tuple<std::string, int, int> kept_for;
    const std::tuple wanted{mechanism, setup.bodies, setup.threads};
    if (ScenePointer held = kept.lock(); held && wanted == kept_for)
        return held;
    const auto made = std::make_shared<Scene>(mechanism, setup);
    kept = made;
    kept_for = wanted;
    return made;
}

} // namespace gudgeon::kernels
