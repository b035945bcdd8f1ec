#include "bake/stages.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr uint32_t kEmpty = ~0u;

/// For each place of each page, the texel there (index into TexelMap::texels) or kEmpty.
std::vector<Image<uint32_t>> texelIndexPages(const TexelMap& map)
{
    std::vector<Image<uint32_t>> pages(std::size_t(map.pageCount), Image<uint32_t>(map.pageSize, map.pageSize, kEmpty));
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const Texel& texel = map.texels[i];
        pages[texel.page](texel.x, texel.y) = uint32_t(i);
    }
    return pages;
}

/// Weight of a neighbour at offset (dx, dy): by distance, so that straight edges extend straight.
float neighborWeight(int dx, int dy)
{
    return dx != 0 && dy != 0 ? 0.70710678f : 1.0f;
}

} // namespace

template<typename T> void fillInvalid(const TexelMap& map, const std::vector<uint8_t>& valid, std::vector<T>& values)
{
    if (std::find(valid.begin(), valid.end(), uint8_t(0)) == valid.end()) return;
    const std::vector<Image<uint32_t>> pages = texelIndexPages(map);
    std::vector<uint8_t> known = valid;
    std::vector<uint32_t> open;
    for (std::size_t i = 0; i < known.size(); ++i) {
        if (!known[i]) open.push_back(uint32_t(i));
    }
    // Ring by ring from the valid texels inwards, until nothing changes (a chart may have no valid texel at all).
    while (!open.empty()) {
        std::vector<std::pair<uint32_t, T>> found;
        std::vector<uint32_t> stillOpen;
        for (const uint32_t i : open) {
            const Texel& texel = map.texels[i];
            T sum{};
            float weight = 0.0f;
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const ivec2 p(int(texel.x) + dx, int(texel.y) + dy);
                    if (p.x < 0 || p.y < 0 || p.x >= map.pageSize || p.y >= map.pageSize) continue;
                    const uint32_t j = pages[texel.page](p.x, p.y);
                    if (j == kEmpty || !known[j] || map.texels[j].chart != texel.chart) continue;
                    sum += values[j] * neighborWeight(dx, dy);
                    weight += neighborWeight(dx, dy);
                }
            }
            if (weight > 0.0f) {
                found.emplace_back(i, sum / weight);
            } else {
                stillOpen.push_back(i);
            }
        }
        if (found.empty()) break;
        for (const auto& [i, value] : found) {
            values[i] = value;
            known[i] = 1;
        }
        open.swap(stillOpen);
    }
}

template<typename T> std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings)
{
    std::vector<Image<T>> pages(std::size_t(map.pageCount), Image<T>(map.pageSize, map.pageSize));
    // chart + 1 of each place's value, 0 = empty. A place between two charts goes to the one reached first, or, in the
    // same ring, to the lower number.
    std::vector<Image<uint32_t>> charts(std::size_t(map.pageCount), Image<uint32_t>(map.pageSize, map.pageSize, 0u));
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const Texel& texel = map.texels[i];
        pages[texel.page](texel.x, texel.y) = values[i];
        charts[texel.page](texel.x, texel.y) = texel.chart + 1;
    }
    struct Growth {
        uint16_t x, y;
        uint32_t chart;
        T value;
    };
    for (std::size_t p = 0; p < pages.size(); ++p) {
        Image<T>& page = pages[p];
        Image<uint32_t>& chart = charts[p];
        // The first ring looks at every place, the following ones only around what the last one added.
        std::vector<ivec2> candidates;
        for (int y = 0; y < map.pageSize; ++y) {
            for (int x = 0; x < map.pageSize; ++x) {
                if (chart(x, y) == 0u) candidates.emplace_back(x, y);
            }
        }
        for (int ring = 0; ring < rings; ++ring) {
            std::vector<Growth> grown;
            std::vector<ivec2> remaining;
            for (const ivec2 c : candidates) {
                uint32_t owner = 0;
                for (int dy = -1; dy <= 1; ++dy) {
                    for (int dx = -1; dx <= 1; ++dx) {
                        const ivec2 q = c + ivec2(dx, dy);
                        if (q.x < 0 || q.y < 0 || q.x >= map.pageSize || q.y >= map.pageSize) continue;
                        const uint32_t other = chart(q.x, q.y);
                        if (other != 0u && (owner == 0u || other < owner)) owner = other;
                    }
                }
                if (owner == 0u) {
                    remaining.push_back(c);
                    continue;
                }
                T sum{};
                float weight = 0.0f;
                for (int dy = -1; dy <= 1; ++dy) {
                    for (int dx = -1; dx <= 1; ++dx) {
                        const ivec2 q = c + ivec2(dx, dy);
                        if (q.x < 0 || q.y < 0 || q.x >= map.pageSize || q.y >= map.pageSize) continue;
                        if (chart(q.x, q.y) != owner) continue;
                        sum += page(q.x, q.y) * neighborWeight(dx, dy);
                        weight += neighborWeight(dx, dy);
                    }
                }
                grown.push_back({uint16_t(c.x), uint16_t(c.y), owner, sum / weight});
            }
            for (const Growth& g : grown) {
                page(g.x, g.y) = g.value;
                chart(g.x, g.y) = g.chart;
            }
            candidates.swap(remaining);
        }
    }
    return pages;
}

template void fillInvalid(const TexelMap&, const std::vector<uint8_t>&, std::vector<vec3>&);
template void fillInvalid(const TexelMap&, const std::vector<uint8_t>&, std::vector<vec4>&);
template std::vector<Image<vec3>> dilate(const TexelMap&, const std::vector<vec3>&, int);
template std::vector<Image<vec4>> dilate(const TexelMap&, const std::vector<vec4>&, int);

} // namespace halflight
