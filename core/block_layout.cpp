#include "core/block_layout.hpp"

#include <utility>

namespace gudgeon {

BlockLayoutBuilder::BlockLayoutBuilder(int moving) : moving_(moving) {
    layout_.moving = moving;
    for (int i = 0; i < moving; ++i)
        for (int row = 0; row < 2; ++row)
            for (int col = 0; col < 2; ++col) {
                layout_.block_row.push_back(2 * i + row);
                layout_.block_col.push_back(2 * i + col);
                layout_.active.push_back(row == 1 && col == 1); // inertia and gyroscopic terms
            }
}

int BlockLayoutBuilder::block(int row, int col) {
    if (row / 2 == col / 2)
        return 4 * (row / 2) + 2 * (row % 2) + col % 2;
    const std::uint64_t key = (static_cast<std::uint64_t>(row) << 32) | static_cast<std::uint32_t>(col);
    const auto [it, added] = off_diagonal_.try_emplace(key, layout_.blocks());
    if (added) {
        layout_.block_row.push_back(row);
        layout_.block_col.push_back(col);
        layout_.active.push_back(0);
    }
    return it->second;
}

int BlockLayoutBuilder::pair(int a, int b, CouplingMask mask) {
    const int rows[4] = {2 * a, 2 * a + 1, 2 * b, 2 * b + 1};
    const auto moves = [&](int part) { return (part < 2 ? a : b) < moving_; };
    PairBlocks blocks;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            blocks.id[i][j] = -1;
            if (!(mask & coupling_bit(i, j)) || !moves(i) || !moves(j))
                continue;
            const int id = block(rows[i], rows[j]);
            layout_.active[id] = 1;
            blocks.id[i][j] = id;
        }
    layout_.pairs.push_back(blocks);
    return static_cast<int>(layout_.pairs.size()) - 1;
}

BlockLayout BlockLayoutBuilder::finish() && {
    for (std::vector<int>* numbers : {&layout_.block_row, &layout_.block_col})
        numbers->shrink_to_fit();
    layout_.active.shrink_to_fit();
    layout_.pairs.shrink_to_fit();
    return std::move(layout_);
}

} // namespace gudgeon
