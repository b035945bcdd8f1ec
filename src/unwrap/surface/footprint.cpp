#include "unwrap/surface/footprint.h"

#include <bit>

namespace halflight::charts {

void Footprint::setRun(int y, int first, int last)
{
    if (y < 0 || y >= height_) return;
    first = std::max(first, 0);
    last = std::min(last, width_ - 1);
    uint64_t* words = bits_.data() + std::size_t(y) * words_;
    while (first <= last) {
        const int bit = first % 64, run = std::min(64 - bit, last - first + 1);
        words[first / 64] |= (run == 64 ? ~uint64_t(0) : (uint64_t(1) << run) - 1) << bit;
        first += run;
    }
}

std::size_t Footprint::count() const
{
    std::size_t sum = 0;
    for (const uint64_t word : bits_) sum += std::size_t(std::popcount(word));
    return sum;
}

Footprint Footprint::oriented(int orientation) const
{
    if (orientation == 0) return *this;
    const bool swap = (orientation & 4) != 0;
    Footprint result(swap ? height_ : width_, swap ? width_ : height_);
    forRuns([&](int y, int first, int length) {
        const int toY = (orientation & 2) ? height_ - 1 - y : y;
        const int from = (orientation & 1) ? width_ - first - length : first;
        if (!swap) {
            result.setRun(toY, from, from + length - 1);
        } else {
            for (int x = from; x < from + length; ++x) result.set(toY, x);
        }
    });
    return result;
}

Footprint Footprint::dilated(int texels) const
{
    Footprint result(width_ + 2 * texels, height_ + 2 * texels);
    forRuns([&](int y, int first, int length) {
        for (int row = y; row <= y + 2 * texels; ++row) result.setRun(row, first, first + length - 1 + 2 * texels);
    });
    return result;
}

dvec2 oriented(dvec2 point, ivec2 size, int orientation)
{
    if (orientation & 1) point.x = size.x - point.x;
    if (orientation & 2) point.y = size.y - point.y;
    return (orientation & 4) ? dvec2(point.y, point.x) : point;
}

} // namespace halflight::charts
