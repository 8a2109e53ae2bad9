// Numbering of the 3 x 3 blocks of the velocity-velocity matrix (M, C, S), fixed at compile time.
//
// Each moving body has two block rows: 2 i for its translation, 2 i + 1 for its rotation. The four
// diagonal-body blocks always exist in storage (numbers 4 i + 2 row + column); blocks between bodies
// exist where an element declared them.
#pragma once

#include "core/batch.hpp"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace gudgeon {

struct BlockLayout {
    int moving = 0;
    std::vector<int> block_row, block_col; // per block, in units of three scalars
    std::vector<std::uint8_t> active;      // per block: structurally nonzero
    std::vector<PairBlocks> pairs;
    int blocks() const { return static_cast<int>(block_row.size()); }
};

class BlockLayoutBuilder {
  public:
    explicit BlockLayoutBuilder(int moving);

    int moving() const { return moving_; }
    /// Declares the blocks an element between a and b writes; returns its pair number.
    int pair(int a, int b, CouplingMask mask);
    BlockLayout finish() &&;

  private:
    int block(int row, int col);

    int moving_;
    BlockLayout layout_;
    std::unordered_map<std::uint64_t, int> off_diagonal_;
};

} // namespace gudgeon
