#include "bake/hash_grid.h"
#include "bake/stages.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <unordered_map>

namespace halflight {
namespace {

constexpr int kNearRings = 2; ///< rings in which values of the same chart precede those of other charts

/// Weight of a neighbour at offset (dx, dy): the inverse distance, so that straight edges extend straight.
float neighborWeight(int dx, int dy)
{
    return dx != 0 && dy != 0 ? 0.70710678f : 1.0f;
}

/// Ring by ring, texels of `open` take the weighted mean of the known texels next to them on their chart.
template<typename T> void growWithinCharts(const TexelMap& map, const TexelGrid& grid, int rings,
                                           std::vector<uint8_t>& known, std::vector<uint32_t>& open,
                                           std::vector<T>& values)
{
    for (int ring = 0; ring < rings && !open.empty(); ++ring) {
        std::vector<std::pair<uint32_t, T>> found;
        std::vector<uint32_t> stillOpen;
        for (const uint32_t i : open) {
            const Texel& texel = map.texels[i];
            T sum{};
            float weight = 0.0f;
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const uint32_t j = grid.at(texel, dx, dy);
                    if (j == kNoTexel || !known[j]) continue;
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

/// Texels of `open` take the weighted mean of valid texels close by in the world, of any chart.
template<typename T> void adoptNeighbors(const BakeGeometry& geometry, const TexelMap& map,
                                         const std::vector<uint8_t>& valid, std::vector<uint8_t>& known,
                                         std::vector<uint32_t>& open, std::vector<T>& values)
{
    if (open.empty()) return;
    constexpr float kReachTexels = 3.0f;
    constexpr float kFacing = 0.5f;
    std::vector<TexelPlace> missing(open.size());
    float reach = 0.0f;
    for (std::size_t i = 0; i < open.size(); ++i) {
        missing[i] = placeOf(geometry, map, map.texels[open[i]]);
        reach += kReachTexels * missing[i].texelMeters / float(open.size());
    }
    if (!(reach > 0.0f)) return;
    // Only grid cells next to a texel without value are filled.
    std::unordered_map<uint64_t, std::vector<uint32_t>> grid;
    for (const TexelPlace& place : missing) {
        const ivec3 cell = gridCell(place.position, reach);
        for (int n = 0; n < 27; ++n) grid.try_emplace(gridKey(cell + ivec3(n % 3, n / 3 % 3, n / 9) - 1));
    }
    for (std::size_t j = 0; j < map.texels.size(); ++j) {
        if (!valid[j]) continue;
        const auto cell = grid.find(gridKey(gridCell(placeOf(geometry, map, map.texels[j]).position, reach)));
        if (cell != grid.end()) cell->second.push_back(uint32_t(j));
    }
    std::vector<T> adopted(open.size());
    std::vector<uint8_t> found(open.size(), 0);
    parallelFor(open.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const ivec3 cell = gridCell(missing[i].position, reach);
            T sum{};
            float weight = 0.0f;
            for (int n = 0; n < 27; ++n) {
                for (const uint32_t j : grid.at(gridKey(cell + ivec3(n % 3, n / 3 % 3, n / 9) - 1))) {
                    const TexelPlace place = placeOf(geometry, map, map.texels[j]);
                    const float distance = glm::distance(place.position, missing[i].position) / reach;
                    const float facing = glm::dot(place.normal, missing[i].normal);
                    if (distance >= 1.0f || facing <= kFacing) continue;
                    const float w = (1.0f - distance) * (facing - kFacing);
                    sum += values[j] * w;
                    weight += w;
                }
            }
            if (weight <= 0.0f) continue;
            adopted[i] = sum / weight;
            found[i] = 1;
        }
    });
    std::vector<uint32_t> stillOpen;
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (!found[i]) {
            stillOpen.push_back(open[i]);
            continue;
        }
        values[open[i]] = adopted[i];
        known[open[i]] = 1;
    }
    open.swap(stillOpen);
}

} // namespace

template<typename T> void fillInvalid(const BakeGeometry& geometry, const TexelMap& map,
                                      const std::vector<uint8_t>& valid, std::vector<T>& values)
{
    std::vector<uint32_t> open;
    for (std::size_t i = 0; i < valid.size(); ++i) {
        if (!valid[i]) open.push_back(uint32_t(i));
    }
    if (open.empty()) return;
    const TexelGrid grid(map);
    std::vector<uint8_t> known = valid;
    growWithinCharts(map, grid, kNearRings, known, open, values);
    adoptNeighbors(geometry, map, valid, known, open, values);
    growWithinCharts(map, grid, map.pageSize, known, open, values);
}

template<typename T>
std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings, bool extrapolate)
{
    std::vector<Image<T>> pages(std::size_t(map.pageCount), Image<T>(map.pageSize, map.pageSize));
    // Chart + 1 of each place, 0 = empty. A place between two charts belongs to the nearer one, at equal distance to
    // the lower number.
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
                const auto owned = [&](ivec2 q) {
                    return q.x >= 0 && q.y >= 0 && q.x < map.pageSize && q.y < map.pageSize && chart(q.x, q.y) == owner;
                };
                T sum{};
                float weight = 0.0f;
                T straight{};
                float straightWeight = 0.0f;
                for (int dy = -1; dy <= 1; ++dy) {
                    for (int dx = -1; dx <= 1; ++dx) {
                        const ivec2 q = c + ivec2(dx, dy);
                        if (!owned(q)) continue;
                        const float w = neighborWeight(dx, dy);
                        sum += page(q.x, q.y) * w;
                        weight += w;
                        const ivec2 behind = q + ivec2(dx, dy);
                        if (!extrapolate || !owned(behind)) continue;
                        straight += (2.0f * page(q.x, q.y) - page(behind.x, behind.y)) * w;
                        straightWeight += w;
                    }
                }
                grown.push_back({uint16_t(c.x), uint16_t(c.y), owner,
                                 straightWeight > 0.0f ? straight / straightWeight : sum / weight});
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

template void fillInvalid(const BakeGeometry&, const TexelMap&, const std::vector<uint8_t>&, std::vector<vec3>&);
template void fillInvalid(const BakeGeometry&, const TexelMap&, const std::vector<uint8_t>&, std::vector<vec4>&);
template std::vector<Image<vec3>> dilate(const TexelMap&, const std::vector<vec3>&, int, bool);
template std::vector<Image<vec4>> dilate(const TexelMap&, const std::vector<vec4>&, int, bool);

} // namespace halflight
