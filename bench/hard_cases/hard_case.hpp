// Hard cases: a scene, the numbers that must not be exceeded, and the runs that measure them. One list for
// the test (tests/bench/hard_cases_test.cpp) and for the report (gudgeon_hard_cases).
//
// Truths are closed forms, conservation laws, quadrature or another method at a finer tolerance; bounds
// follow from the tolerance. A new case is one entry in one of the functions of cases.hpp.
#pragma once

#include "solvers/simulation.hpp"

#include <functional>
#include <string>
#include <vector>

namespace gudgeon::hard {

/// One way of solving; every case runs by all of them.
struct Way {
    std::string integrator;
    Formulation formulation;
    std::string name() const { return integrator + " " + formulation_name(formulation); }
};
const std::vector<Way>& ways();

/// A number that must not exceed its bound.
struct Finding {
    std::string what; // with unit
    double value = 0, bound = 0;
    bool holds() const { return value <= bound; } // NaN does not
};

struct Outcome {
    std::vector<Finding> findings;
    std::string stopped; // what ended the case before its end; empty: nothing
    Statistics work;     // of all runs
    double seconds = 0;  // CPU time of all runs, set-up included
};

/// What a motion over so many characteristic times (periods, where it has some) may be wrong by: a hundred
/// steps in each, every one with the error that its test lets pass, 3.6 (rtol |y| + atol) in one of a body's
/// 13 numbers, all in one sense. growth: how much the motion itself blows errors up meanwhile.
double allowance(double tolerance, double times, double size, double growth = 1);

/// How long a run is and how often it is looked at; every = 0: at the end alone. s.
struct Span {
    double end, every = 0;
};

/// The runs of one case by one way.
class Trial {
  public:
    explicit Trial(const Way& way) : way_(way) {}

    const Way& way() const { return way_; }
    SimulationOptions options(double rtol, double atol) const;
    SimulationOptions options(double tolerance) const { return options(tolerance, tolerance); }

    /// Samples at 0 (after assembly), every, 2 every ..., end. Returns the last one. Throws where the run
    /// stops.
    using Watch = std::function<void(const Simulation&, const Sample&)>;
    Sample run(Model model, const SimulationOptions& options, const Span& span, const Watch& watch = {});
    Sample run(Model model, double tolerance, const Span& span, const Watch& watch = {}) {
        return run(std::move(model), options(tolerance), span, watch);
    }
    /// Of the last run.
    const Statistics& work() const { return work_; }

    void hold(const std::string& what, double value, double bound);
    void count(double seconds) { outcome_.seconds += seconds; }
    Outcome outcome_;

  private:
    Way way_;
    Statistics work_;
};

/// A miss that is known, with the reason as measured. Where it stops being one, the test says so.
struct KnownMiss {
    std::string what; // of the finding; "stops": the run ends early; empty: whatever the last bits bring
    std::string way;  // "gear", "gear augmented-lagrangian"; empty: all
    std::string why;
};

struct HardCase {
    std::string name; // one word, also the test's
    std::string scene;
    std::function<void(Trial&)> run;
    bool slow = false; // not under the sanitizers
    /// Why KLU may take over from CHOLMOD here; empty: it must not.
    std::string indefinite = {};
    std::vector<KnownMiss> known = {};
};

/// All of them.
const std::vector<HardCase>& hard_cases();

Outcome run_case(const HardCase& hard_case, const Way& way);

/// Null: it is not known.
const KnownMiss* known_miss(const HardCase& hard_case, const Way& way, const std::string& what);

/// What is wrong with an outcome, one line each: bounds exceeded, early ends, KLU in place of CHOLMOD, known
/// misses that hold by now. Empty: all is as it must be.
std::vector<std::string> complaints(const HardCase& hard_case, const Way& way, const Outcome& outcome);

} // namespace gudgeon::hard
