#include "app/output_grid.hpp"

#include "app/numbers.hpp"
#include "app/progress.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace gudgeon {
namespace {

TEST(OutputGrid, EndIsAMultiple) {
    const OutputGrid grid(1, 0.25);
    ASSERT_EQ(grid.size(), 5u);
    for (std::size_t k = 0; k < 5; ++k)
        EXPECT_EQ(grid.time(k), 0.25 * static_cast<double>(k));
}

TEST(OutputGrid, LastIntervalIsShorter) {
    const OutputGrid grid(1, 0.3);
    ASSERT_EQ(grid.size(), 5u);
    EXPECT_EQ(grid.time(3), 3 * 0.3);
    EXPECT_EQ(grid.time(4), 1.0);
}

TEST(OutputGrid, RoundOffMakesNoExtraTime) {
    // 0.3 / 0.1 is below 3 in doubles, 0.7 / 0.1 and 1.1 / 0.1 are off as well.
    for (const auto& [end, every, intervals] : {std::tuple(0.3, 0.1, 3u),
                                                {0.7, 0.1, 7u},
                                                {1.1, 0.1, 11u},
                                                {5.0, 1e-4, 50000u},
                                                {1.0, 1.0 / 3, 3u},
                                                {1.0, 0.333333333, 3u}}) {
        const OutputGrid grid(end, every);
        EXPECT_EQ(grid.size(), intervals + 1) << end << ' ' << every;
        EXPECT_EQ(grid.time(intervals), end);
        EXPECT_EQ(grid.time(1), every);
    }
}

TEST(OutputGrid, IntervalLongerThanTheRun) {
    const OutputGrid grid(1, 10);
    ASSERT_EQ(grid.size(), 2u);
    EXPECT_EQ(grid.time(0), 0.0);
    EXPECT_EQ(grid.time(1), 1.0);
    EXPECT_EQ(OutputGrid(1e-9, 1).size(), 2u);
}

TEST(OutputGrid, TooManyTimes) { EXPECT_THROW(OutputGrid(1, 1e-12), std::invalid_argument); }

TEST(Numbers, WholeTextFinite) {
    EXPECT_EQ(to_number("1e-3"), 1e-3);
    EXPECT_EQ(to_number("+2"), 2.0);
    EXPECT_EQ(to_number("-0.5"), -0.5);
    for (const char* text : {"", "1x", "1,5", "nan", "inf", "1e999", "+-1", "0x10", " 1", "1 "})
        EXPECT_FALSE(to_number(text)) << text;
}

TEST(Numbers, SeventeenDigits) {
    std::string text;
    append_number(text, 0.1);
    EXPECT_EQ(text, "0.10000000000000001");
    text.clear();
    append_number(text, -1.0 / 3e20);
    EXPECT_EQ(text, "-3.3333333333333333e-21");
    text.clear();
    append_number(text, 2);
    EXPECT_EQ(text, "2");
}

TEST(Progress, Durations) {
    EXPECT_EQ(duration(3.2), "3 s");
    EXPECT_EQ(duration(125), "2 min 05 s");
    EXPECT_EQ(duration(4800), "1 h 20 min");
}

} // namespace
} // namespace gudgeon
