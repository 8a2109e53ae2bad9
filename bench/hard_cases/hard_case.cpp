#include "bench/hard_cases/hard_case.hpp"

#include "app/clocks.hpp"
#include "bench/hard_cases/cases.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace gudgeon::hard {

namespace {
const std::string early_end = "stops";
} // namespace

const std::vector<Way>& ways() {
    static const std::vector<Way> all{{"gear", Formulation::saddle_point},
                                      {"gear", Formulation::augmented_lagrangian},
                                      {"radau", Formulation::saddle_point},
                                      {"radau", Formulation::augmented_lagrangian}};
    return all;
}

double allowance(double tolerance, double times, double size, double growth) {
    const double steps = 100, one_of_thirteen = std::sqrt(13.0);
    return steps * one_of_thirteen * tolerance * times * (1 + size) * growth;
}

SimulationOptions Trial::options(double rtol, double atol) const {
    SimulationOptions out;
    out.integrator = way_.integrator;
    out.integration.formulation = way_.formulation;
    out.integration.rtol = rtol;
    out.integration.atol = atol;
    out.integration.max_steps = 10'000'000;
    return out;
}

Sample Trial::run(Model model, const SimulationOptions& options, const Span& span, const Watch& watch) {
    double before = cpu_seconds();
    Simulation sim(std::move(model), options);
    const double start = sim.time();
    const long samples = span.every > 0 ? std::lround(span.end / span.every) : 1;
    Sample last;
    StepOutcome step;
    for (long k = 0; k <= samples && step.ok; ++k) {
        const double t = k == samples ? span.end : start + static_cast<double>(k) * span.every;
        if (k > 0)
            step = sim.advance_past(t, span.end);
        if (step.ok)
            last = sim.sample_at(t);
        outcome_.seconds += cpu_seconds() - before;
        if (step.ok && watch)
            watch(sim, last);
        before = cpu_seconds();
    }
    work_ = sim.statistics();
    outcome_.work += work_;
    if (!step.ok)
        throw std::runtime_error(step.message);
    return last;
}

void Trial::hold(const std::string& what, double value, double bound) {
    outcome_.findings.push_back({what, value, bound});
}

const std::vector<HardCase>& hard_cases() {
    static const std::vector<HardCase> all = [] {
        std::vector<HardCase> out;
        for (const auto& theme : themes())
            for (HardCase& one : theme())
                out.push_back(std::move(one));
        return out;
    }();
    return all;
}

Outcome run_case(const HardCase& hard_case, const Way& way) {
    Trial trial(way);
    try {
        hard_case.run(trial);
    } catch (const std::exception& error) {
        trial.outcome_.stopped = error.what();
    }
    return std::move(trial.outcome_);
}

const KnownMiss* known_miss(const HardCase& hard_case, const Way& way, const std::string& what) {
    for (const KnownMiss& miss : hard_case.known)
        if ((miss.what == what || miss.what.empty()) && way.name().starts_with(miss.way))
            return &miss;
    return nullptr;
}

std::vector<std::string> complaints(const HardCase& hard_case, const Way& way, const Outcome& outcome) {
    std::vector<std::string> out;
    const auto judge = [&](const std::string& what, bool holds, const std::string& wrong) {
        const KnownMiss* known = known_miss(hard_case, way, what);
        if (!holds && !known)
            out.push_back(wrong);
        if (holds && known && !known->what.empty())
            out.push_back("no longer missed: " + what);
    };
    judge(early_end, outcome.stopped.empty(), outcome.stopped);
    for (const Finding& f : outcome.findings)
        judge(f.what, f.holds(), fmt::format("{}: {:.3g}, at most {:.3g}", f.what, f.value, f.bound));
    if (outcome.findings.empty() && outcome.stopped.empty())
        out.push_back("nothing was measured");
    if (way.formulation != Formulation::augmented_lagrangian)
        return out;
    const Statistics& w = outcome.work;
    if (w.klu_fallbacks > 0 && hard_case.indefinite.empty())
        out.push_back(fmt::format("KLU took over {} times", w.klu_fallbacks));
    if (w.factorisations + w.refactorisations > 0 && w.cholmod_factorisations == 0)
        out.push_back("CHOLMOD factored nothing");
    return out;
}

} // namespace gudgeon::hard
