// Micro-benchmarks of what a step is made of, per mechanism and number of bodies, one thread. Items are
// bodies: "items_per_second" is the reciprocal of the time per body.

#include "contact/standard_forces.hpp"
#include "core/assembly.hpp"
#include "models/mechanisms.hpp"
#include "solvers/complex_klu_solver.hpp"
#include "solvers/integrator.hpp"
#include "solvers/klu_solver.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>

namespace {

using namespace gudgeon;

enum Mechanism { chain, suspension };

Model sized_model(Mechanism mechanism, int bodies) {
    if (mechanism == chain)
        return build_mechanism("chain", {{"links", std::to_string(bodies)}});
    const long units = std::max(1L, std::lround(bodies / 7.0));
    return build_mechanism("suspension-chain", {{"units", std::to_string(units)}});
}

/// A mechanism in motion, with everything evaluated, linearised and factored.
struct Scene {
    System system;
    State state;
    Workspace ws;
    SaddleMatrix saddle;
    KluSolver klu;
    ComplexKluSolver complex_klu;
    std::vector<double> values, other_values;                        // of two step lengths
    std::vector<std::complex<double>> complex_values, other_complex; // the same turned off the real axis
    VecX rhs;
    std::vector<std::complex<double>> complex_rhs;

    Scene(Mechanism mechanism, int bodies)
        : system(compile(sized_model(mechanism, bodies), standard_force_builders())),
          ws(make_workspace(system)), saddle(system), klu({.refinements = 0}) {
        const auto integrator = make_integrator("gear", system, {.rtol = 1e-4, .atol = 1e-4});
        integrator->start(initial_state(system));
        for (int i = 0; i < 20; ++i)
            if (!integrator->advance(std::numeric_limits<double>::infinity()).ok)
                throw std::runtime_error("the scene does not move");
        state = integrator->state();
        ws.angles = state.angles;
        set_motion(system, state.q, state.u, ws);
        linearise(system, state.t, state.lambda.data(), ws);
        values.resize(saddle.pattern().nonzeros());
        other_values.resize(saddle.pattern().nonzeros());
        saddle.assemble(system, ws, 1e3, 1e-3, values);
        saddle.assemble(system, ws, 2e3, 5e-4, other_values);
        klu.analyse(saddle.pattern());
        if (!klu.factor(values).ok())
            throw std::runtime_error("the scene's matrix is singular");
        rhs = VecX::Ones(2 * saddle.pattern().cols);
        klu.solve({rhs.data(), static_cast<std::size_t>(rhs.size())}, 2);
        prepare_complex();
    }

    void prepare_complex() { // Radau's pair of eigenvalues at these step lengths
        const std::complex<double> s = 0.74 * std::complex<double>(1, 1.14);
        complex_values.resize(values.size());
        other_complex.resize(values.size());
        saddle.assemble(system, ws, 1e3 * s, 1e-3 / s, complex_values);
        saddle.assemble(system, ws, 2e3 * s, 5e-4 / s, other_complex);
        complex_klu.analyse(saddle.pattern());
        if (!complex_klu.factor(complex_values).ok())
            throw std::runtime_error("the scene's complex matrix is singular");
        complex_rhs.assign(static_cast<std::size_t>(rhs.size()), 1.0);
        complex_klu.solve(complex_rhs, 2);
    }
};

/// Built once for all benchmarks of its size; only the newest is kept.
Scene& scene(const benchmark::State& state) {
    static std::unique_ptr<Scene> kept;
    static std::pair<long, long> kept_for{-1, -1};
    const std::pair<long, long> wanted{state.range(0), state.range(1)};
    if (wanted != kept_for) {
        kept.reset();
        kept = std::make_unique<Scene>(static_cast<Mechanism>(wanted.first), static_cast<int>(wanted.second));
        kept_for = wanted;
    }
    return *kept;
}

void count_bodies(benchmark::State& state, const Scene& s) {
    state.SetItemsProcessed(state.iterations() * s.system.moving);
    state.SetLabel(state.range(0) == chain ? "chain" : "suspension-chain");
    state.counters["bodies"] = s.system.moving;
}

void motion(benchmark::State& state) {
    Scene& s = scene(state);
    for (auto _ : state)
        set_motion(s.system, s.state.q, s.state.u, s.ws);
    count_bodies(state, s);
}

void constraints(benchmark::State& state) {
    Scene& s = scene(state);
    for (auto _ : state)
        evaluate_constraints(s.system, s.state.t, s.state.lambda.data(), false, s.ws);
    count_bodies(state, s);
}

void forces(benchmark::State& state) {
    Scene& s = scene(state);
    for (auto _ : state)
        evaluate_forces(s.system, s.state.t, s.ws);
    count_bodies(state, s);
}

void bushings(benchmark::State& state) {
    Scene& s = scene(state);
    const Evaluation e = evaluation(s.system, s.ws, s.state.t);
    int count = 0;
    for (const auto& batch : s.system.forces)
        count += std::strcmp(batch->kind(), "bushing") == 0 ? batch->size() : 0;
    if (count == 0) {
        state.SkipWithError("no bushings");
        return;
    }
    for (auto _ : state)
        for (const auto& batch : s.system.forces)
            if (std::strcmp(batch->kind(), "bushing") == 0)
                batch->add_forces(e, {s.ws.f.data(), s.system.moving});
    count_bodies(state, s);
    state.counters["bushings"] = count;
}

void linearisation(benchmark::State& state) {
    Scene& s = scene(state);
    for (auto _ : state)
        linearise(s.system, s.state.t, s.state.lambda.data(), s.ws);
    count_bodies(state, s);
}

void assembly(benchmark::State& state) {
    Scene& s = scene(state);
    for (auto _ : state)
        s.saddle.assemble(s.system, s.ws, 1e3, 1e-3, s.values);
    count_bodies(state, s);
}

void klu_refactorisation(benchmark::State& state) {
    Scene& s = scene(state);
    const long full = s.klu.counts().factorisations;
    bool other = false;
    for (auto _ : state) {
        if (!s.klu.factor(other ? s.other_values : s.values).ok())
            state.SkipWithError("singular");
        other = !other;
    }
    count_bodies(state, s);
    state.counters["full"] = static_cast<double>(s.klu.counts().factorisations - full);
    state.counters["nnz_factors_body"] = static_cast<double>(s.klu.factor_nonzeros()) / s.system.moving;
}

void klu_solution(benchmark::State& state) { // two right-hand sides, as a sweep has
    Scene& s = scene(state);
    for (auto _ : state) {
        s.rhs.setOnes();
        s.klu.solve({s.rhs.data(), static_cast<std::size_t>(s.rhs.size())}, 2);
    }
    count_bodies(state, s);
}

void complex_refactorisation(benchmark::State& state) {
    Scene& s = scene(state);
    const long full = s.complex_klu.counts().factorisations;
    bool other = false;
    for (auto _ : state) {
        if (!s.complex_klu.factor(other ? s.other_complex : s.complex_values).ok())
            state.SkipWithError("singular");
        other = !other;
    }
    count_bodies(state, s);
    state.counters["full"] = static_cast<double>(s.complex_klu.counts().factorisations - full);
    state.counters["nnz_factors_body"] =
        static_cast<double>(s.complex_klu.factor_nonzeros()) / s.system.moving;
}

void complex_solution(benchmark::State& state) { // two right-hand sides
    Scene& s = scene(state);
    for (auto _ : state) {
        std::fill(s.complex_rhs.begin(), s.complex_rhs.end(), 1.0);
        s.complex_klu.solve(s.complex_rhs, 2);
    }
    count_bodies(state, s);
}

void gear_step(benchmark::State& state) {
    Scene& s = scene(state);
    const auto integrator = make_integrator("gear", s.system, {.rtol = 1e-5, .atol = 1e-5});
    integrator->start(s.state);
    const double forever = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 30; ++i) // to its usual order and step
        integrator->advance(forever);
    for (auto _ : state)
        if (const StepOutcome outcome = integrator->advance(forever); !outcome.ok) {
            state.SkipWithError(outcome.message.c_str());
            break;
        }
    count_bodies(state, s);
    const Statistics& statistics = integrator->statistics();
    state.counters["sweeps_step"] =
        static_cast<double>(statistics.newton_sweeps) / static_cast<double>(statistics.steps);
}

/// In the order of sizes, so that each scene is built once.
void add_all() {
    const std::pair<const char*, void (*)(benchmark::State&)> list[] = {
        {"motion", motion},
        {"constraints", constraints},
        {"forces", forces},
        {"bushings", bushings},
        {"linearise", linearisation},
        {"assemble", assembly},
        {"klu_refactor", klu_refactorisation},
        {"klu_solve2", klu_solution},
        {"complex_klu_refactor", complex_refactorisation},
        {"complex_klu_solve2", complex_solution},
        {"gear_step", gear_step},
    };
    for (const Mechanism mechanism : {chain, suspension})
        for (const int bodies : {10, 100, 1000, 10000})
            for (const auto& [name, run] : list)
                if (mechanism == suspension || run != bushings)
                    benchmark::RegisterBenchmark(name, run)
                        ->ArgNames({"mechanism", "bodies"})
                        ->Args({mechanism, bodies})
                        ->Unit(benchmark::kMicrosecond);
}

} // namespace

int main(int argc, char** argv) {
    add_all();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv))
        return 1;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
