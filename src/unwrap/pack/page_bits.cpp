#include "unwrap/pack/page_bits.h"

#include <algorithm>
#include <bit>

namespace halflight::charts {
namespace {

constexpr uint64_t kOnes = 0x0001000100010001u;     ///< 1 in each 16 bits
constexpr uint64_t kHighBits = 0x8000800080008000u; ///< pages have less than 2^15 texels on a side

/// The longest run of ones that begins in a word, where `ahead` ones follow the word.
int longestRun(uint64_t word, int ahead)
{
    if (word == ~uint64_t(0)) return 64 + ahead;
    const int atEnd = std::countl_one(word);
    int longest = atEnd > 0 ? atEnd + ahead : 0;
    if (atEnd > 0) word &= (uint64_t(1) << (64 - atEnd)) - 1;
    int length = 0; // of the longest run inside: each step shortens all runs by one
    for (; word != 0; word &= word >> 1) ++length;
    longest = std::max(longest, length);
    return longest;
}

} // namespace

/// Bit i: the `length` texels from x + i on are free.
inline uint64_t PageBits::freeRuns(int y, int x, int length) const
{
    const int level = std::min(int(std::bit_width(unsigned(length))) - 1, kLevels - 1), step = 1 << level;
    const uint64_t* row = rowOf(level, y);
    const int wordLimit = int(words_ - 1) * 64;
    uint64_t places = bitsFrom(row, x);
    for (int covered = step; covered < length && places != 0;) {
        const int from = std::min(covered, length - step);
        if (x + from >= wordLimit) return 0;
        places &= bitsFrom(row, x + from);
        covered = from + step;
    }
    return places;
}

PageBits::PageBits(ivec2 size, int padding)
    : padding_(padding), width_(size.x + 2 * padding), height_(size.y + 2 * padding),
      words_((std::size_t(width_) + 63) / 64 + 2), blockWords_((words_ + kBlocksPerWord - 1) / kBlocksPerWord),
      blocks_(blockWords_ * std::size_t(height_)), longestFree_(std::size_t(height_), width_)
{
    for (auto& level : free_) level.assign(words_ * std::size_t(height_), 0);
    for (int x = 0; x < width_; ++x) free_[0][std::size_t(x) / 64] |= uint64_t(1) << (x % 64);
    updateRuns(0, 0, width_);
    updateBlocks(0, 0, int(words_) - 1);
    for (std::size_t y = 1; y < std::size_t(height_); ++y) {
        for (auto& level : free_) std::copy_n(level.begin(), words_, level.begin() + std::ptrdiff_t(y * words_));
        std::copy_n(blocks_.begin(), blockWords_, blocks_.begin() + std::ptrdiff_t(y * blockWords_));
    }
}

std::optional<ivec2> PageBits::find(const Shape& shape, ivec2 begin, int yEnd) const
{
    const int lastX = width_ - 2 * padding_ - shape.size.x;
    yEnd = std::min(yEnd, height_ - 2 * padding_ - shape.size.y + 1);
    if (lastX < 0) return std::nullopt;
    for (int y = begin.y; y < yEnd; ++y) {
        if (!rowsHaveRoom(shape, y)) continue;
        const int x = findInRow(shape, y, y == begin.y ? begin.x : 0, lastX);
        if (x <= lastX) return ivec2(x, y);
    }
    return std::nullopt;
}

/// The first place in a row, or one beyond lastX.
int PageBits::findInRow(const Shape& shape, int y, int xBegin, int lastX) const
{
    const Run& run = shape.padded.front(); // the longest
    const uint64_t* blocks = blocks_.data() + std::size_t(y + run.y) * blockWords_;
    const uint64_t least = kOnes * uint64_t(run.length);
    const int firstBlock = (xBegin + run.x) / 64, lastBlock = (lastX + run.x) / 64;
    for (int word = firstBlock / int(kBlocksPerWord); word <= lastBlock / int(kBlocksPerWord); ++word) {
        // A high bit stays where a block's run is long enough: nothing is borrowed from it.
        uint64_t enough = ((blocks[word] | kHighBits) - least) & kHighBits;
        for (; enough != 0; enough &= enough - 1) {
            const int block = word * int(kBlocksPerWord) + std::countr_zero(enough) / 16;
            if (block < firstBlock || block > lastBlock) continue;
            const int x = findInBlock(shape, block, y, xBegin, lastX);
            if (x <= lastX) return x;
        }
    }
    return lastX + 1;
}

/// The first place at which the shape's longest run begins in a block, or one beyond lastX.
int PageBits::findInBlock(const Shape& shape, int block, int y, int xBegin, int lastX) const
{
    const int start = 64 * block - shape.padded.front().x;
    const int x = std::max(start, xBegin), last = std::min(start + 63, lastX);
    if (x > last) return lastX + 1;
    uint64_t places = ~uint64_t(0) >> (63 - (last - x));
    for (const Run& run : shape.padded) {
        places &= freeRuns(y + run.y, x + run.x, run.length);
        if (places == 0) return lastX + 1;
    }
    return x + std::countr_zero(places);
}

void PageBits::mark(const Shape& shape, ivec2 at, bool taken)
{
    for (const Run& run : shape.texels) {
        const int y = at.y + run.y + padding_;
        const int begin = at.x + run.x + padding_, end = begin + run.length;
        uint64_t* row = free_[0].data() + std::size_t(y) * words_;
        for (int x = begin; x < end;) {
            const int bit = x % 64, length = std::min(64 - bit, end - x);
            const uint64_t mask = (length == 64 ? ~uint64_t(0) : (uint64_t(1) << length) - 1) << bit;
            if (taken)
                row[x / 64] &= ~mask;
            else
                row[x / 64] |= mask;
            x += length;
        }
        updateRuns(y, begin, end);
        if (!taken) longestFree_[std::size_t(y)] = 0; // it may have grown: found anew
        updateBlocks(y, begin / 64, (end - 1) / 64);
    }
}

/// Whether the rows under the first few runs have a free run of that length anywhere.
bool PageBits::rowsHaveRoom(const Shape& shape, int y) const
{
    constexpr std::size_t kRowsAsked = 4;
    for (std::size_t i = 0, end = std::min(shape.padded.size(), kRowsAsked); i < end; ++i) {
        if (longestFree_[std::size_t(y + shape.padded[i].y)] < shape.padded[i].length) return false;
    }
    return true;
}

/// After texels xBegin … xEnd of the row have changed.
void PageBits::updateRuns(int y, int xBegin, int xEnd)
{
    const std::size_t start = std::size_t(y) * words_;
    const auto first = std::size_t(std::max(xBegin - (1 << (kLevels - 1)), 0)) / 64;
    const std::size_t last = std::min(std::size_t(xEnd) / 64, words_ - 1);
    for (int level = 1; level < kLevels; ++level) {
        const uint64_t* from = free_[std::size_t(level) - 1].data() + start;
        uint64_t* to = free_[std::size_t(level)].data() + start;
        const int shift = 1 << (level - 1);
        const std::size_t whole = std::size_t(shift) / 64;
        for (std::size_t w = first; w <= last; ++w) {
            uint64_t ahead = 0;
            if (shift < 64) {
                ahead = from[w] >> shift | (w + 1 < words_ ? from[w + 1] << (64 - shift) : 0);
            } else {
                ahead = w + whole < words_ ? from[w + whole] : 0;
            }
            to[w] = from[w] & ahead;
        }
    }
}

/// Free texels from the beginning of a block on, in one run.
int PageBits::freeFrom(int y, int block) const
{
    const uint64_t* row = rowOf(0, y);
    int length = 0;
    for (auto w = std::size_t(block); w < words_; ++w) {
        length += std::countr_one(row[w]);
        if (row[w] != ~uint64_t(0)) break;
    }
    return length;
}

/// After texels of blocks first … last of the row have changed. Runs of blocks before them may reach into them.
void PageBits::updateBlocks(int y, int first, int last)
{
    const uint64_t* row = rowOf(0, y);
    uint64_t* blocks = blocks_.data() + std::size_t(y) * blockWords_;
    int ahead = freeFrom(y, last + 1);
    bool hadLongest = false;
    for (int block = last; block >= 0; --block) {
        const uint64_t word = row[block];
        if (block < first && word >> 63 == 0) break;
        uint64_t& packed = blocks[std::size_t(block) / kBlocksPerWord];
        const int shift = 16 * (block % int(kBlocksPerWord));
        hadLongest |= int(packed >> shift & 0xffff) >= longestFree_[std::size_t(y)];
        packed &= ~(uint64_t(0xffff) << shift);
        packed |= uint64_t(longestRun(word, ahead)) << shift;
        ahead = word == ~uint64_t(0) ? ahead + 64 : std::countr_one(word);
    }
    if (!hadLongest) return;
    int longest = 0;
    for (std::size_t w = 0; w < blockWords_; ++w) {
        for (uint64_t rest = blocks[w]; rest != 0; rest >>= 16) longest = std::max(longest, int(rest & 0xffff));
    }
    longestFree_[std::size_t(y)] = longest;
}

} // namespace halflight::charts
