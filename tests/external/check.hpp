// What the programs here share: counted comparisons that name the line that failed.
#pragma once

#include <cmath>
#include <cstdio>

inline int failures = 0;

#define CHECK(condition)                                                                                     \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            ++failures;                                                                                      \
            std::fprintf(report, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition);               \
        }                                                                                                    \
    } while (false)

#define CHECK_NEAR(value, expected, tolerance)                                                               \
    do {                                                                                                     \
        const double value_ = (value), expected_ = (expected);                                               \
        if (!(std::abs(value_ - expected_) <= (tolerance))) {                                                \
            ++failures;                                                                                      \
            std::fprintf(report, "%s:%d: %s is %.15g instead of %.15g\n", __FILE__, __LINE__, #value,        \
                         value_, expected_);                                                                 \
        }                                                                                                    \
    } while (false)

/// Where failures are told: the standard error from before it was redirected.
inline std::FILE* report = stderr;
