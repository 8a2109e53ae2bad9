#include "contact/standard_forces.hpp"
#include "core/archive.hpp"
#include "scene.hpp"
#include "solvers/initial.hpp"
#include "solvers/integrator.hpp"

#include <limits>
#include <stdexcept>

namespace gudgeon::kernels {

namespace {

constexpr int warm_up = 40, steps = 10; // to the usual order and step; at a time
constexpr int counted_bodies = 20;

/// An integrator that can be put back to the same point of its run, to the last bit.
struct Run {
    System system;
    std::unique_ptr<Integrator> integrator;
    std::string saved;
    Statistics before;

    Run(const std::string& method, const Model& model, const Setup& setup)
        : system(compile(model, standard_force_builders())) {
        integrator = make_integrator(method, system, {.rtol = 1e-5, .atol = 1e-5, .threads = setup.threads});
        State start = initial_state(system);
        if (const AssemblyReport report = assemble_start(system, start); !report.ok)
            throw std::runtime_error(report.message(system));
        integrator->start(start);
        advance(warm_up);
        if (setup.rewind) {
            Archive archive;
            integrator->visit(archive);
            saved = archive.content();
        }
        before = integrator->statistics();
    }
    void rewind() {
        Archive archive(saved);
        integrator->visit(archive);
    }
    void advance(int count) {
        for (int i = 0; i < count; ++i)
            if (const StepOutcome outcome = integrator->advance(std::numeric_limits<double>::infinity());
                !outcome.ok)
                throw std::runtime_error(outcome.message);
    }
    std::string note() const { // of the last run; where it is not rewound, of all
        const Statistics& now = integrator->statistics();
        const auto item = [](long count, const char* what) { return std::to_string(count) + " " + what; };
        return item(now.steps - before.steps, "steps, ") +
               item(now.newton_sweeps - before.newton_sweeps, "sweeps, ") +
               item(now.factorisations + now.refactorisations - before.factorisations -
                        before.refactorisations,
                    "factorisations, ") +
               item(now.rejected_error + now.rejected_newton + now.rejected_contact - before.rejected_error -
                        before.rejected_newton - before.rejected_contact,
                    "rejected");
    }
};

} // namespace

Kernels step_kernels() {
    Kernels list;
    for (const std::string method : {"gear", "radau"})
        for (const std::string& mechanism : scene_mechanisms()) {
            const auto prepare = [method, mechanism](const Setup& setup) {
                const auto run = std::make_shared<Run>(method, sized_model(mechanism, setup.bodies), setup);
                const int count = setup.rewind ? steps : 1;
                const auto reset = [run] { run->rewind(); };
                return counted::Work{[run, count] { run->advance(count); },
                                     setup.rewind ? std::function<void()>(reset) : nullptr,
                                     [run] { return run->note(); }};
            };
            list.push_back({"step/" + method + "/" + mechanism, prepare, counted_bodies, 1, true});
        }
    return list;
}

Kernels all_kernels() {
    Kernels list;
    for (const auto group : {joint_kernels, force_kernels, contact_kernels, law_kernels, system_kernels,
                             solver_kernels, step_kernels})
        for (Kernel& kernel : group())
            list.push_back(std::move(kernel));
    return list;
}

} // namespace gudgeon::kernels
