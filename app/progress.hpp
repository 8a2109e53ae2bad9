// Progress bar on a terminal.
#pragma once

#include "app/console.hpp"

#include <chrono>

namespace gudgeon {

/// Draws at most five times a second; removes itself at the end.
class Progress {
  public:
    Progress(const Console& console, bool wanted, double end);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void update(double t, long steps);

  private:
    using clock = std::chrono::steady_clock;
    std::ostream& err_;
    bool wanted_, drawn_ = false;
    double end_;
    clock::time_point begin_ = clock::now(), last_ = begin_;
};

/// "3 s", "2 min 05 s", "1 h 20 min"
std::string duration(double seconds);

} // namespace gudgeon
