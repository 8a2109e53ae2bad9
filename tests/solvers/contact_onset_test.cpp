// How deep a new contact may be when it is first seen: the model's word for it, `root`, and methods that
// cannot reject a step.
#include "contact/standard_forces.hpp"
#include "models/mechanisms.hpp"
#include "solvers/initial.hpp"
#include "solvers/integrator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {
namespace {

constexpr double stiffness = 5e6 / 8; // N/m^1.5, of one strip of the bouncing journal

struct Seen {
    double deepest_start = 0;
    long starts = 0, rejected = 0, deep = 0, told_deep = 0;
};

Seen bounce(const std::string& integrator, const Model::Onset& wanted, Onset onset = Onset::threshold,
            double step = 0) {
    Model model = build_mechanism("bouncing-journal");
    model.onset = wanted;
    const System system = compile(model, standard_force_builders());
    IntegratorOptions options{.rtol = 1e-4, .atol = 1e-4};
    options.onset = onset;
    options.step = step;
    const auto method = make_integrator(integrator, system, options);
    Seen seen;
    method->set_on_contact([&](const ContactEvent& event) {
        seen.told_deep += event.kind == ContactEvent::Kind::deep;
        if (event.kind != ContactEvent::Kind::start)
            return;
        ++seen.starts;
        seen.deepest_start = std::max(seen.deepest_start, event.depth);
    });
    method->start(initial_state(system));
    while (method->state().t < 0.1)
        if (!method->advance(0.1).ok) {
            ADD_FAILURE() << "stopped at " << method->state().t;
            break;
        }
    seen.rejected = method->statistics().rejected_contact;
    seen.deep = method->statistics().deep_starts;
    return seen;
}

class OnsetOf : public testing::TestWithParam<const char*> {};

TEST_P(OnsetOf, DepthForceAndEnergyAreKept) {
    const auto expect = [&](const Model::Onset& wanted, double depth) {
        const Seen seen = bounce(GetParam(), wanted);
        EXPECT_GE(seen.starts, 8); // the strips of the first contact
        EXPECT_LE(seen.deepest_start, depth * (1 + 1e-9));
        EXPECT_EQ(seen.deep, 0);
    };
    Model::Onset depth, force, energy;
    depth.depth = 2e-8;
    force.force = 1e-4;
    energy.energy = 1e-13;
    expect(depth, 2e-8);
    expect(force, std::pow(1e-4 / stiffness, 1 / 1.5));
    expect(energy, std::pow(2.5 * 1e-13 / stiffness, 1 / 2.5));
}

TEST_P(OnsetOf, RootEndsTheStepWhereTheContactStarts) {
    Model::Onset wanted;
    wanted.depth = 1e-6;
    const Seen seen = bounce(GetParam(), wanted, Onset::root);
    EXPECT_GE(seen.starts, 8);
    EXPECT_LE(seen.deepest_start, 1e-9 * (1 + 1e-9));
}

INSTANTIATE_TEST_SUITE_P(Every, OnsetOf, testing::Values("radau", "gear", "ida"),
                         [](const auto& info) { return std::string(info.param); });

TEST(Onset, ARigidStepTakesDeepStartsAndCountsThem) {
    const Seen coarse = bounce("rk4", {}, Onset::threshold, 1e-3);
    EXPECT_GE(coarse.starts, 8);
    EXPECT_GE(coarse.deep, 1);
    EXPECT_EQ(coarse.told_deep, coarse.deep);
    EXPECT_EQ(coarse.rejected, 0);
    EXPECT_GT(coarse.deepest_start, 1e-5); // 0.14 m/s in a part of 1 ms
}

} // namespace
} // namespace gudgeon
