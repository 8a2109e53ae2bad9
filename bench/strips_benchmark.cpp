// Cost of the strips of 1000 bearings with 16 strips each: touching, in reach but apart, out of reach; forces
// and derivatives, one and two threads. Items are strips: "items_per_second" is the reciprocal of the time
// per strip.

#include "contact/standard_forces.hpp"
#include "contact/strip_batch.hpp"
#include "core/assembly.hpp"
#include "models/builders.hpp"

#include <benchmark/benchmark.h>

#include <array>
#include <memory>

namespace {

using namespace gudgeon;

constexpr int joints = 1000, strips = 16;
constexpr double clearance = 1e-4; // m

enum Pose { touching, one_side, centred, tilted };

/// Journals pressed along their whole length, parallel or tilted; touching at one end only; centred.
struct Row {
    System system;
    Workspace ws;
    const StripBatch* batch = nullptr;

    Row(Pose pose, int threads) : system(compile(model(pose), standard_force_builders())) {
        ws = make_workspace(system, threads);
        for (int channel = 0; channel < system.channels(); channel += 2) // one side of each strip
            ws.contacts.start_speed[channel] = 0.1;
        const State state = initial_state(system);
        set_motion(system, state.q, state.u, ws);
        for (const auto& forces : system.forces)
            if (const auto* found = dynamic_cast<const StripBatch*>(forces.get()))
                batch = found;
    }

    static Model model(Pose pose) {
        Model model;
        for (int k = 0; k < joints; ++k) {
            const Vec3 place(0.1 * k, 0, 0);
            const double shift = std::array{1.05, 0.3, 0.0, 1.5}[pose] * clearance;
            const double end = std::array{0.0, 0.9, 0.0, 0.4}[pose] * clearance; // of the axis off its middle
            Body body =
                make_body("journal" + std::to_string(k), 1, {1e-4, 1e-4, 1e-4}, place + Vec3(0, 0, -shift));
            body.orientation = Vec4(1, 0, 0.5 * end / 0.02, 0).normalized();
            body.velocity = {0, 0, -0.01};
            model.bodies.push_back(body);
            Joint joint =
                make_joint("bearing" + std::to_string(k), JointKind::cylindrical, "ground", body.name, place);
            joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
            joint.body_frame = true;
            joint.points = {place, Vec3::Zero()};
            joint.fidelity = Fidelity::clearance;
            joint.clearance = Clearance{};
            joint.clearance->radial = clearance;
            joint.clearance->radius = 0.006;
            joint.clearance->length = 0.04;
            joint.clearance->strips = strips;
            joint.clearance->law.stiffness = 1e9;
            joint.clearance->law.restitution = 0.8;
            model.joints.push_back(joint);
        }
        return model;
    }
};

void forces_of_strips(benchmark::State& state) {
    Row row(static_cast<Pose>(state.range(0)), static_cast<int>(state.range(1)));
    const Evaluation e = evaluation(row.system, row.ws, 0);
    for (auto _ : state) {
        row.batch->add_forces(e, {row.ws.f.data(), row.system.moving});
        benchmark::DoNotOptimize(row.ws.f.data());
    }
    state.SetItemsProcessed(state.iterations() * joints * strips);
    state.counters["in_reach"] = static_cast<double>(row.batch->strips_in_reach(e));
}

void derivatives_of_strips(benchmark::State& state) {
    Row row(static_cast<Pose>(state.range(0)), static_cast<int>(state.range(1)));
    const Evaluation e = evaluation(row.system, row.ws, 0);
    for (auto _ : state) {
        row.batch->add_linearisation(e, row.ws.lin);
        benchmark::DoNotOptimize(row.ws.lin.S.data());
    }
    state.SetItemsProcessed(state.iterations() * joints * strips);
}

void arguments(benchmark::internal::Benchmark* b) {
    for (const int threads : {1, 2})
        for (const Pose pose : {touching, one_side, centred, tilted})
            b->Args({pose, threads});
    b->ArgNames({"pose", "threads"})->Unit(benchmark::kMicrosecond)->UseRealTime();
}

BENCHMARK(forces_of_strips)->Apply(arguments);
BENCHMARK(derivatives_of_strips)->Apply(arguments);

} // namespace
