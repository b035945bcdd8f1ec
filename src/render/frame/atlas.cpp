// Places of square tiles in the square shadow atlas.
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace halflight {
namespace {

/// Every second bit of a Morton code, packed.
int compactBits(uint32_t code)
{
    code &= 0x55555555u;
    code = (code | (code >> 1)) & 0x33333333u;
    code = (code | (code >> 2)) & 0x0f0f0f0fu;
    code = (code | (code >> 4)) & 0x00ff00ffu;
    code = (code | (code >> 8)) & 0x0000ffffu;
    return int(code);
}

} // namespace

// All sizes are powers of two. Tiles laid along a Morton curve, largest first, each begin at a multiple of their own
// area on the curve, which is an aligned square of the quadtree: they fit exactly when their areas do.
AtlasPlacement placeTiles(std::span<const AtlasRequest> requests, int atlasSize)
{
    const int side = int(std::bit_floor(unsigned(std::max(atlasSize, kMinTileSize))));
    const int64_t capacity = int64_t(side) * side;
    AtlasPlacement placement;
    placement.offsets.resize(requests.size());
    int64_t area = 0;
    const auto areaOf = [&](std::size_t i) {
        return int64_t(requests[i].count) * placement.sizes[i] * placement.sizes[i];
    };
    for (std::size_t i = 0; i < requests.size(); ++i) {
        placement.sizes.push_back(
            std::clamp(int(std::bit_floor(unsigned(std::max(requests[i].size, 1)))), kMinTileSize, side));
        area += areaOf(i);
    }

    // Too much: halve the largest tiles, the least important light's first; when all are smallest, drop the least
    // important.
    while (area > capacity) {
        std::size_t chosen = 0;
        for (std::size_t i = 0; i < requests.size(); ++i) {
            if (placement.sizes[i] >= placement.sizes[chosen]) chosen = i;
        }
        const bool smallest = placement.sizes[chosen] == kMinTileSize;
        if (smallest) {
            while (placement.sizes[chosen] == 0) --chosen; // the last one that still has tiles
        }
        area -= areaOf(chosen);
        placement.sizes[chosen] = smallest ? 0 : placement.sizes[chosen] / 2;
        area += areaOf(chosen);
    }

    std::vector<std::size_t> order(requests.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return placement.sizes[a] > placement.sizes[b]; });
    uint32_t cursor = 0; // on the curve, in cells of the smallest tile
    for (const std::size_t i : order) {
        const int size = placement.sizes[i];
        if (size == 0) break;
        const uint32_t cells = uint32_t(size / kMinTileSize) * uint32_t(size / kMinTileSize);
        for (int tile = 0; tile < requests[i].count; ++tile, cursor += cells) {
            placement.offsets[i].push_back(ivec2(compactBits(cursor), compactBits(cursor >> 1)) * kMinTileSize);
        }
    }
    return placement;
}

} // namespace halflight
