// Ctrl-C (SIGINT) and SIGTERM as a flag.
#pragma once

#include <csignal>

namespace gudgeon {

/// While it lives, the first signal only sets the flag; a second one ends the program at once. One at a time.
class InterruptGuard {
  public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;

    bool requested() const;

  private:
    struct sigaction old_int_, old_term_;
};

} // namespace gudgeon
