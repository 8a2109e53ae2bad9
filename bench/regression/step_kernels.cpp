#include "contact/standard_forces.hpp"
#include "core/archive.hpp"
#include "core/assembly.hpp"
#include "kernels.hpp"
#include "models/mechanisms.hpp"
#include "solvers/initial.hpp"
#include "solvers/integrator.hpp"

#include <limits>
#include <memory>
#include <stdexcept>

namespace gudgeon::regression {

namespace {

constexpr int warm_up = 40, steps = 10; // to the usual order and step; counted

/// An integrator that can be put back to the same point of its run, to the last bit.
struct Run {
    System system;
    std::unique_ptr<Integrator> integrator;
    std::string saved;
    Statistics before;

    Run(const std::string& method, const Model& model) : system(compile(model, standard_force_builders())) {
        integrator = make_integrator(method, system, {.rtol = 1e-5, .atol = 1e-5});
        State start = initial_state(system);
        if (const AssemblyReport report = assemble_start(system, start); !report.ok)
            throw std::runtime_error(report.message(system));
        integrator->start(start);
        advance(warm_up);
        Archive archive;
        integrator->visit(archive);
        saved = archive.content();
        before = integrator->statistics();
    }
    void reset() {
        Archive archive(saved);
        integrator->visit(archive);
    }
    void advance(int count) {
        for (int i = 0; i < count; ++i)
            if (const StepOutcome outcome = integrator->advance(std::numeric_limits<double>::infinity());
                !outcome.ok)
                throw std::runtime_error(outcome.message);
    }
    std::string note() const { // of the last run
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
    const std::pair<std::string, std::map<std::string, std::string>> mechanisms[] = {
        {"chain", {{"links", "20"}}}, {"suspension-chain", {{"units", "3"}}}};
    for (const std::string method : {"gear", "radau"})
        for (const auto& [name, parameters] : mechanisms)
            list.push_back({"step/" + method + "/" + name, [method, name = name, parameters = parameters] {
                                const auto run =
                                    std::make_shared<Run>(method, build_mechanism(name, parameters));
                                return counted::Work{[run] { run->advance(steps); }, [run] { run->reset(); },
                                                     [run] { return run->note(); }};
                            }});
    return list;
}

} // namespace gudgeon::regression
