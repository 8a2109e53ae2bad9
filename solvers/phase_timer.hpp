// Adds the time of a scope to a phase.
#pragma once

#include <chrono>

namespace gudgeon {

class PhaseTimer {
  public:
    explicit PhaseTimer(double& seconds) : seconds_(seconds), start_(clock::now()) {}
    ~PhaseTimer() { seconds_ += std::chrono::duration<double>(clock::now() - start_).count(); }
    PhaseTimer(const PhaseTimer&) = delete;
    PhaseTimer& operator=(const PhaseTimer&) = delete;

  private:
    using clock = std::chrono::steady_clock;
    double& seconds_;
    clock::time_point start_;
};

} // namespace gudgeon
