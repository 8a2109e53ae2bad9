// A rod of 1 m falls from the horizontal: after a quarter of its period it hangs straight down.
#include <cmath>
#include <cstdio>
#include <gudgeon/solvers/simulation.hpp>
int main() {
    gudgeon::Model model;
    gudgeon::Body& rod = model.bodies.emplace_back();
    rod.name = "rod";
    rod.mass = 2;
    rod.inertia.diagonal() << 1e-4, 2.0 / 12, 2.0 / 12;
    rod.position = {0.5, 0, 0};
    gudgeon::Joint& hinge = model.joints.emplace_back();
    hinge.name = "hinge";
    hinge.kind = gudgeon::JointKind::revolute;
    hinge.bodies = {"ground", "rod"};
    hinge.axes = {gudgeon::Vec3::UnitY(), gudgeon::Vec3::UnitY()};
    gudgeon::SimulationOptions options;
    options.integration.rtol = options.integration.atol = 1e-9;
    gudgeon::Simulation sim(model, options);
    const gudgeon::StepOutcome outcome =
        sim.advance_to(std::comp_ellint_1(std::sqrt(0.5)) * std::sqrt(2 / (3 * 9.81)));
    const gudgeon::Vec3 r = sim.sample().motion[0].r;
    std::printf("t = %.9f s: x = %.1e m, z = %.9f m\n", sim.time(), r.x(), r.z());
    return outcome.ok && (r - gudgeon::Vec3(0, 0, -0.5)).norm() < 1e-7 ? 0 : 1;
}
