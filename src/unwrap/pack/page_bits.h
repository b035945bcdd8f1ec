#pragma once
// The free texels of a page, row by row in bit masks.

#include "unwrap/pack/shape.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace halflight::charts {

/// Free texels of a page as bits, and for each power of two the places where a run of that many free texels begins: a
/// run of any length is free when the two (or more) power-of-two runs that cover it are. So 64 places in a row are
/// tested against one run of a footprint with a handful of word operations. For each block of 64 texels the length of
/// the longest free run that begins there is known: a shape is tested only where its longest run has room.
class PageBits {
public:
    PageBits(ivec2 size, int padding);

    /// The first place from the top, then from the left, not before `begin` and at a y below `yEnd`.
    [[nodiscard]] std::optional<ivec2> find(const Shape& shape, ivec2 begin, int yEnd) const;

    void mark(const Shape& shape, ivec2 at, bool taken = true);

private:
    static constexpr int kLevels = 8;
    static constexpr std::size_t kBlocksPerWord = 4; ///< a block's longest run has 16 bits

    static uint64_t bitsFrom(const uint64_t* row, int x)
    {
        const uint64_t* word = row + x / 64;
        const int shift = x % 64;
        return shift == 0 ? word[0] : word[0] >> shift | word[1] << (64 - shift);
    }
    [[nodiscard]] const uint64_t* rowOf(int level, int y) const
    {
        return free_[level].data() + std::size_t(y) * words_;
    }

    [[nodiscard]] int findInRow(const Shape& shape, int y, int xBegin, int lastX) const;
    [[nodiscard]] int findInBlock(const Shape& shape, int block, int y, int xBegin, int lastX) const;
    [[nodiscard]] bool rowsHaveRoom(const Shape& shape, int y) const;
    [[nodiscard]] inline uint64_t freeRuns(int y, int x, int length) const;
    void updateRuns(int y, int xBegin, int xEnd);
    void updateBlocks(int y, int first, int last);
    [[nodiscard]] int freeFrom(int y, int block) const;

    int padding_, width_, height_; ///< the border of `padding` texels all round is free and never drawn to
    std::size_t words_;            ///< of a row; the last is empty
    std::size_t blockWords_;       ///< of a row of blocks_
    std::vector<uint64_t> free_[kLevels];
    std::vector<uint64_t> blocks_; ///< by row and block: length of the longest free run that begins in it
    std::vector<int> longestFree_; ///< by row: no free run is longer
};

} // namespace halflight::charts
