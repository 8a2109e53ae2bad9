// The output times of a run: k * every for k = 0, 1, ..., the last one is the end.
#pragma once

#include <cstddef>

namespace gudgeon {

class OutputGrid {
  public:
    /// s, both positive and finite. Throws std::invalid_argument for more than 1e8 times. A last interval
    /// that round-off would make shorter than a millionth of the others is joined to the one before.
    OutputGrid(double end, double every);

    std::size_t size() const { return intervals_ + 1; }
    double time(std::size_t k) const { return k < intervals_ ? static_cast<double>(k) * every_ : end_; }
    double end() const { return end_; }
    double every() const { return every_; }

  private:
    double end_, every_;
    std::size_t intervals_;
};

} // namespace gudgeon
