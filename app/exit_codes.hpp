// What the command ends with, and the error of a command line that cannot be followed.
#pragma once

#include <stdexcept>
#include <string>

namespace gudgeon {

struct Exit {
    static constexpr int ok = 0;
    static constexpr int unexpected = 1;
    static constexpr int refused = 2;  // usage, or the model is refused
    static constexpr int assembly = 3; // the mechanism cannot be assembled
    static constexpr int stopped = 4;  // the integration stopped; what was computed is written
    static constexpr int files = 5;    // reading or writing
    static constexpr int interrupted = 130;
};

/// place: the option or argument, e.g. "--rtol".
class UsageError : public std::runtime_error {
  public:
    UsageError(const std::string& place, const std::string& problem, const std::string& allowed)
        : std::runtime_error("gudgeon: " + place + ": " + problem + "; allowed: " + allowed) {}
};

} // namespace gudgeon
