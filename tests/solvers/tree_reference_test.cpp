// rk4 in joint coordinates against the same reference solutions as Gear's method, at two steps: near them,
// and by order 4 nearer at the smaller step.
#include "tests/solvers/reference_runs.hpp"

namespace gudgeon {
namespace {

using namespace test;

class TreeAgainst : public testing::TestWithParam<Reference> {
  protected:
    static Errors run_tree(const Reference& ref, double step) {
        SimulationOptions options;
        options.integrator = "rk4";
        options.integration.formulation = Formulation::tree;
        options.integration.step = step;
        return run(ref, options);
    }
};

TEST_P(TreeAgainst, Reference) {
    Reference ref = GetParam();
    double step = 4e-4;
    if (ref.mechanism == "suspension-chain") { // rubber: larger steps are unstable
        step = 4e-5;
        ref.end = 0.3;
    }
    const Errors wide = run_tree(ref, 2 * step), narrow = run_tree(ref, step);
    for (std::size_t k = 0; k < ref.pairs.size(); ++k) {
        EXPECT_LT(narrow.largest[k], 1e-6 * ref.pairs[k].gear + ref.file_error) << ref.pairs[k].channel;
        EXPECT_LT(narrow.largest[k], wide.largest[k] / 10 + ref.file_error + 1e-10 * ref.pairs[k].gear)
            << ref.pairs[k].channel;
    }
    EXPECT_LT(narrow.balance, 1e-6 * ref.gear_energy);
    EXPECT_LT(narrow.phi, 1e-12);
    EXPECT_LT(narrow.rate, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Slow, TreeAgainst, testing::ValuesIn(references()),
                         [](const auto& info) { return info.param.name; });

} // namespace
} // namespace gudgeon
