// gudgeon_bench: time of every kernel from 10 to 100 000 bodies (Google Benchmark); see README.md.

#include "kernels.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>

namespace {

using namespace gudgeon::kernels;

/// The library calls a benchmark several times to find out how often to repeat it: what was prepared
/// stays until another kernel or size is asked for. The old one goes last, so that both share their scene.
const counted::Work& prepared(const Kernel& kernel, const Setup& setup) {
    static std::unique_ptr<counted::Work> kept;
    static const Kernel* kept_for = nullptr;
    static Setup kept_setup;
    if (kept_for != &kernel || kept_setup.bodies != setup.bodies || kept_setup.threads != setup.threads) {
        auto made = std::make_unique<counted::Work>(kernel.prepare(setup));
        made->run();
        kept = std::move(made);
        kept_for = &kernel;
        kept_setup = setup;
    }
    return *kept;
}

void measure(benchmark::State& state, const Kernel& kernel) {
    const Setup setup{kernel.bodies ? static_cast<int>(state.range(0)) : 0,
                      kernel.threaded ? static_cast<int>(state.range(1)) : 1, false};
    try {
        const counted::Work& work = prepared(kernel, setup);
        for (auto _ : state)
            work.run();
        if (work.note)
            state.SetLabel(work.note());
    } catch (const std::exception& error) {
        state.SkipWithError(error.what());
    }
    const int items = kernel.bodies ? std::max(1, setup.bodies / kernel.per_item) : kernel.per_item;
    state.SetItemsProcessed(state.iterations() * items);
}

/// In the order of sizes, so that scenes are shared.
void add_all(const Kernels& kernels) {
    for (const int bodies : {10, 100, 1000, 10000, 100000})
        for (const int threads : {1, 2})
            for (const Kernel& kernel : kernels) {
                if ((threads > 1 && !kernel.threaded) || (kernel.bodies == 0 && bodies > 10))
                    continue;
                auto* benchmark =
                    benchmark::RegisterBenchmark(kernel.name.c_str(), measure, std::cref(kernel))
                        ->Unit(benchmark::kMicrosecond);
                if (kernel.threaded)
                    benchmark->ArgNames({"bodies", "threads"})->Args({bodies, threads})->UseRealTime();
                else if (kernel.bodies)
                    benchmark->ArgName("bodies")->Arg(bodies);
            }
}

} // namespace

int main(int argc, char** argv) {
    const Kernels kernels = all_kernels();
    add_all(kernels);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv))
        return 1;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
