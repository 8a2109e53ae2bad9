// Every hard case by every integrator and formulation; bench/hard_cases prints the same as a table.
#include "bench/hard_cases/hard_case.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <set>

namespace gudgeon::hard {

void PrintTo(const HardCase& hard_case, std::ostream* out) { *out << hard_case.scene; }
void PrintTo(const Way& way, std::ostream* out) { *out << way.name(); }

namespace {

class HardCases : public testing::TestWithParam<std::tuple<HardCase, Way>> {};

TEST_P(HardCases, Hold) {
    const auto& [hard_case, way] = GetParam();
    for (const std::string& complaint : complaints(hard_case, way, run_case(hard_case, way)))
        ADD_FAILURE() << complaint;
}

std::vector<HardCase> cases(bool slow) {
    std::vector<HardCase> out;
    std::ranges::copy_if(hard_cases(), std::back_inserter(out),
                         [slow](const HardCase& one) { return one.slow == slow; });
    return out;
}

std::string name_of(const testing::TestParamInfo<HardCases::ParamType>& info) {
    const auto& [hard_case, way] = info.param;
    std::string out = hard_case.name + "_" + way.name();
    std::ranges::replace_if(
        out, [](char c) { return c == ' ' || c == '-'; }, '_');
    return out;
}

INSTANTIATE_TEST_SUITE_P(By, HardCases,
                         testing::Combine(testing::ValuesIn(cases(false)), testing::ValuesIn(ways())),
                         name_of);
INSTANTIATE_TEST_SUITE_P(SlowBy, HardCases,
                         testing::Combine(testing::ValuesIn(cases(true)), testing::ValuesIn(ways())),
                         name_of);

TEST(HardCaseList, NamesAreDifferentWords) {
    std::set<std::string> names;
    for (const HardCase& one : hard_cases()) {
        EXPECT_TRUE(std::ranges::all_of(one.name, [](unsigned char c) { return std::isalnum(c); }))
            << one.name;
        EXPECT_TRUE(names.insert(one.name).second) << one.name;
        EXPECT_FALSE(one.scene.empty()) << one.name;
    }
}

HardCase made_up(double value, std::vector<KnownMiss> known = {}) {
    return {"MadeUp", "nothing", [value](Trial& trial) { trial.hold("size, m", value, 1); },
            false,    "",        known};
}

TEST(HardCaseList, ComplainsOfWhatIsWrongAndOfMissesThatAreNone) {
    const Way& way = ways().back();
    const auto lines = [&](const HardCase& one, const Outcome& outcome) {
        return complaints(one, way, outcome).size();
    };
    const KnownMiss miss{"size, m", way.integrator, "as measured"};
    for (const double good : {0.5, 1.0}) {
        EXPECT_EQ(lines(made_up(good), run_case(made_up(good), way)), 0u);
        EXPECT_EQ(lines(made_up(good, {miss}), run_case(made_up(good, {miss}), way)), 1u);
    }
    for (const double bad : {1.1, std::nan("")}) {
        EXPECT_EQ(lines(made_up(bad), run_case(made_up(bad), way)), 1u);
        EXPECT_EQ(lines(made_up(bad, {miss}), run_case(made_up(bad, {miss}), way)), 0u);
    }
    const KnownMiss whole{"size, m", way.name(), "as measured"}, other{"size, m", ways().front().name(), ""};
    EXPECT_EQ(lines(made_up(1.1, {whole}), run_case(made_up(1.1), way)), 0u);
    EXPECT_EQ(lines(made_up(1.1, {other}), run_case(made_up(1.1), way)), 1u);
    Outcome outcome = run_case(made_up(0), way);
    outcome.work.klu_fallbacks = 1;
    EXPECT_EQ(lines(made_up(0), outcome), 1u);
    outcome = run_case(made_up(0), way);
    outcome.stopped = "at 1 s";
    EXPECT_EQ(lines(made_up(0), outcome), 1u);
    outcome = run_case(made_up(0), way);
    outcome.work.factorisations = 1; // not by CHOLMOD
    EXPECT_EQ(lines(made_up(0), outcome), 1u);
}

} // namespace
} // namespace gudgeon::hard
