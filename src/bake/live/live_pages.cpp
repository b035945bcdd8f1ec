#include "bake/live/live_pages.h"

#include "bake/pages/dilate.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/base/rgb9e5.h"

#include <algorithm>
#include <unordered_map>

namespace halflight {
namespace {

/// A square of a page: texels of it follow one another in the map, as these are sorted by Morton code.
struct Square {
    uint32_t page = 0;
    int x = 0;
    int y = 0;
    bool operator==(const Square&) const = default;
};

Square squareOf(const Texel& texel, int side)
{
    return {texel.page, int(texel.x) / side, int(texel.y) / side};
}

/// Calls body(first, end) for the runs of texels in one square.
template<typename Body> void forSquares(const TexelMap& map, int side, const Body& body)
{
    for (std::size_t first = 0; first < map.texels.size();) {
        std::size_t end = first + 1;
        const Square square = squareOf(map.texels[first], side);
        while (end < map.texels.size() && squareOf(map.texels[end], side) == square) ++end;
        body(first, end);
        first = end;
    }
}

/// Of a chart in a square. Pages have at most 2^16 texels along a side.
struct PieceKey {
    uint64_t place = 0; ///< page, y, x
    uint32_t chart = 0;
    bool operator==(const PieceKey&) const = default;
};
struct PieceHash {
    std::size_t operator()(const PieceKey& key) const
    {
        return std::size_t((key.place * 0x9e3779b97f4a7c15ull) ^ (uint64_t(key.chart) * 0xc2b2ae3d27d4eb4full));
    }
};
PieceKey keyOf(const Square& square, int dx, int dy, uint32_t chart)
{
    return {(uint64_t(square.page) << 32) | (uint64_t(uint16_t(square.y + dy)) << 16) | uint16_t(square.x + dx), chart};
}

vec2 centerOf(const Texel& texel)
{
    return vec2(texel.x, texel.y);
}

} // namespace

std::vector<uint32_t> sampleTexels(const TexelMap& map, int side)
{
    std::vector<uint32_t> chosen;
    std::vector<uint32_t> charts;
    forSquares(map, side, [&](std::size_t first, std::size_t end) {
        charts.clear();
        for (std::size_t i = first; i < end; ++i) charts.push_back(map.texels[i].chart);
        std::sort(charts.begin(), charts.end());
        charts.erase(std::unique(charts.begin(), charts.end()), charts.end());
        for (const uint32_t chart : charts) {
            vec2 sum(0.0f);
            float count = 0.0f;
            for (std::size_t i = first; i < end; ++i) {
                if (map.texels[i].chart != chart) continue;
                sum += centerOf(map.texels[i]);
                count += 1.0f;
            }
            float nearest = kInfinity;
            uint32_t best = 0;
            for (std::size_t i = first; i < end; ++i) {
                if (map.texels[i].chart != chart) continue;
                const float distance = glm::distance(centerOf(map.texels[i]), sum / count);
                if (distance >= nearest) continue;
                nearest = distance;
                best = uint32_t(i);
            }
            chosen.push_back(best);
        }
    });
    return chosen;
}

LivePages::LivePages(const TexelMap& map)
    : map_(map), light_(map.texels.size(), vec3(0.0f)),
      texels_(std::size_t(map.pageCount), Image<uint32_t>(map.pageSize, map.pageSize, kNoTexel)),
      blocks_((map.pageSize + kBlock - 1) / kBlock),
      changed_(std::size_t(map.pageCount) * std::size_t(blocks_) * std::size_t(blocks_), 0)
{
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const Texel& t = map.texels[i];
        texels_[t.page](t.x, t.y) = uint32_t(i);
    }
    // Padding shows a neighbour, so that filtering at rims reads light of the chart.
    for (Image<uint32_t>& page : texels_) {
        for (int ring = 0; ring < kDilationRings; ++ring) {
            const Image<uint32_t> before = page;
            parallelFor(std::size_t(page.height()), 16, [&](std::size_t begin, std::size_t end) {
                for (int y = int(begin); y < int(end); ++y) {
                    for (int x = 0; x < page.width(); ++x) {
                        for (int k = 0; k < 9 && page(x, y) == kNoTexel; ++k) {
                            const ivec2 p(x + k % 3 - 1, y + k / 3 - 1);
                            if (p.x >= 0 && p.y >= 0 && p.x < page.width() && p.y < page.height())
                                page(x, y) = before(p.x, p.y);
                        }
                    }
                }
            });
        }
    }
}

void LivePages::spread(std::span<const uint32_t> texels, std::span<const vec3> light, int side)
{
    std::unordered_map<PieceKey, std::size_t, PieceHash> pieces;
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const Texel& texel = map_.texels[texels[i]];
        pieces.emplace(keyOf(squareOf(texel, side), 0, 0, texel.chart), i);
    }
    std::vector<std::pair<std::size_t, std::size_t>> squares;
    forSquares(map_, side, [&](std::size_t first, std::size_t end) { squares.emplace_back(first, end); });
    parallelFor(squares.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<std::size_t> near; // samples of the chart in the nine squares
        for (std::size_t s = begin; s < end; ++s) {
            const auto [first, last] = squares[s];
            const Square square = squareOf(map_.texels[first], side);
            uint32_t chart = ~0u;
            for (std::size_t i = first; i < last; ++i) {
                const Texel& texel = map_.texels[i];
                if (texel.chart != chart) {
                    chart = texel.chart;
                    near.clear();
                    for (int k = 0; k < 9; ++k) {
                        const auto found = pieces.find(keyOf(square, k % 3 - 1, k / 3 - 1, chart));
                        if (found != pieces.end()) near.push_back(found->second);
                    }
                }
                vec3 sum(0.0f);
                float weights = 0.0f;
                for (const std::size_t n : near) {
                    const float d = glm::distance(centerOf(texel), centerOf(map_.texels[texels[n]])) / float(side);
                    const float weight = math::exp(-2.0f * d * d); // half at 0.6 sides: about four samples count
                    sum += weight * light[n];
                    weights += weight;
                }
                if (weights > 0.0f) light_[i] = sum / weights;
            }
        }
    });
}

void LivePages::set(uint32_t texel, vec3 light)
{
    light_[texel] = light;
    const Texel& t = map_.texels[texel];
    const int row = (int(t.page) * blocks_ + t.y / kBlock) * blocks_;
    changed_[std::size_t(row + t.x / kBlock)] = 1;
}

float LivePages::brightest() const
{
    float most = 0.0f;
    for (const vec3 light : light_) most = std::max({most, light.r, light.g, light.b});
    return most;
}

LightTile LivePages::tileOf(int page, ivec2 begin, ivec2 end, float unitLux) const
{
    Image<vec3> light(end.x - begin.x, end.y - begin.y, vec3(0.0f));
    for (int y = begin.y; y < end.y; ++y) {
        for (int x = begin.x; x < end.x; ++x) {
            const uint32_t texel = texels_[std::size_t(page)](x, y);
            if (texel != kNoTexel) light(x - begin.x, y - begin.y) = light_[texel];
        }
    }
    return {page, begin, encodeRgb9e5(light, unitLux)};
}

std::vector<Image<uint32_t>> LivePages::takeAll(float unitLux)
{
    std::vector<Image<uint32_t>> pages;
    for (int page = 0; page < map_.pageCount; ++page)
        pages.push_back(tileOf(page, ivec2(0), ivec2(map_.pageSize), unitLux).texels);
    std::fill(changed_.begin(), changed_.end(), uint8_t(0));
    return pages;
}

std::vector<LightTile> LivePages::takeChanged(float unitLux)
{
    std::vector<LightTile> tiles;
    for (int block = 0; block < int(changed_.size()); ++block) {
        if (std::exchange(changed_[std::size_t(block)], uint8_t(0)) == 0) continue;
        const int page = block / (blocks_ * blocks_);
        const ivec2 place(block % blocks_, block / blocks_ % blocks_);
        // Padding around the block's texels may lie in the next blocks.
        const ivec2 begin = glm::max(place * kBlock - kDilationRings, ivec2(0));
        const ivec2 end = glm::min((place + 1) * kBlock + kDilationRings, ivec2(map_.pageSize));
        tiles.push_back(tileOf(page, begin, end, unitLux));
    }
    return tiles;
}

} // namespace halflight
