#include "bake/pages/dilate.h"
#include "bake/geometry/hash_grid.h"
#include "bake/geometry/smooth_normals.h"
#include "bake/texels/texel_places.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <unordered_map>

namespace halflight {
namespace {

constexpr std::size_t kTexelsPerTask = 4096;
/// Weight of a neighbour at offset (dx, dy): the inverse distance, so that straight edges extend straight.
float neighborWeight(int dx, int dy)
{
    return dx != 0 && dy != 0 ? 0.70710678f : 1.0f;
}

template<typename T> using Quantities = std::span<std::vector<T>* const>;

/// Texels that another one takes the weighted mean of.
class Sources {
public:
    void clear()
    {
        list_.clear();
        weight_ = 0.0f;
    }
    void add(uint32_t texel, float weight)
    {
        list_.push_back({texel, weight});
        weight_ += weight;
    }
    [[nodiscard]] bool empty() const { return !(weight_ > 0.0f); }
    template<typename T> [[nodiscard]] T meanOf(const std::vector<T>& values) const
    {
        T sum{};
        for (const Source& source : list_) sum += values[source.texel] * source.weight;
        return sum / weight_;
    }

private:
    struct Source {
        uint32_t texel = 0;
        float weight = 0.0f;
    };
    std::vector<Source> list_;
    float weight_ = 0.0f;
};

/// Texels of `open` take the means of what find(index into `open`, sources) adds, all at one time. Those without stay
/// open. False if no texel has any.
template<typename T, typename Find> bool takeMeans(std::size_t grain, const Find& find, std::vector<uint8_t>& known,
                                                   std::vector<uint32_t>& open, Quantities<T> values)
{
    std::vector<T> means(open.size() * values.size());
    std::vector<uint8_t> found(open.size());
    parallelFor(open.size(), grain, [&](std::size_t begin, std::size_t end) {
        Sources sources;
        for (std::size_t o = begin; o < end; ++o) {
            sources.clear();
            find(o, sources);
            found[o] = !sources.empty();
            for (std::size_t v = 0; found[o] && v < values.size(); ++v)
                means[o * values.size() + v] = sources.meanOf(*values[v]);
        }
    });
    forEachIndex(open.size(), [&](std::size_t o) {
        if (!found[o]) return;
        for (std::size_t v = 0; v < values.size(); ++v) (*values[v])[open[o]] = means[o * values.size() + v];
        known[open[o]] = 1;
    });
    std::size_t still = 0;
    for (std::size_t o = 0; o < open.size(); ++o) {
        if (!found[o]) open[still++] = open[o];
    }
    const bool any = still < open.size();
    open.resize(still);
    return any;
}

/// Ring by ring, texels of `open` take the weighted mean of the known texels next to them on their chart.
template<typename T> void growWithinCharts(const TexelMap& map, const TexelGrid& grid, int rings,
                                           std::vector<uint8_t>& known, std::vector<uint32_t>& open,
                                           Quantities<T> values)
{
    const auto find = [&](std::size_t o, Sources& sources) {
        const Texel& texel = map.texels[open[o]];
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const uint32_t j = grid.at(texel, dx, dy);
                if (j != kNoTexel && known[j]) sources.add(j, neighborWeight(dx, dy));
            }
        }
    };
    for (int ring = 0; ring < rings && !open.empty(); ++ring)
        if (!takeMeans(kTexelsPerTask, find, known, open, values)) break;
}

/// A texel that others may take the value of.
struct ValidTexel {
    uint32_t texel = 0;
    vec3 position{0.0f};
    vec3 normal{0.0f};
};

/// Texels of `open` take the weighted mean of valid texels close by in the world, of any chart.
template<typename T> void adoptNeighbors(const BakeGeometry& geometry, const TexelMap& map,
                                         const std::vector<uint8_t>& valid, std::vector<uint8_t>& known,
                                         std::vector<uint32_t>& open, Quantities<T> values)
{
    if (open.empty()) return;
    std::vector<TexelPlace> missing(open.size());
    parallelFor(open.size(), kTexelsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) missing[i] = placeOf(geometry, map, map.texels[open[i]]);
    });
    float reach = 0.0f;
    for (const TexelPlace& place : missing) reach += float(kDilationRings + 1) * place.texelMeters / float(open.size());
    if (!(reach > 0.0f)) return;
    // Only grid cells next to a texel without value are filled.
    std::unordered_map<uint64_t, std::vector<ValidTexel>> grid;
    for (const TexelPlace& place : missing) {
        const ivec3 cell = gridCell(place.position, reach);
        for (int n = 0; n < 27; ++n) grid.try_emplace(gridKey(cell + ivec3(n % 3, n / 3 % 3, n / 9) - 1));
    }
    auto cellOf = largeVector<std::vector<ValidTexel>*>(map.texels.size(), nullptr);
    forEachIndex(map.texels.size(), [&](std::size_t j) {
        if (!valid[j]) return;
        const auto cell = grid.find(gridKey(gridCell(placeOf(geometry, map, map.texels[j]).position, reach)));
        if (cell != grid.end()) cellOf[j] = &cell->second;
    });
    for (const uint32_t j : indicesWhere(map.texels.size(), [&](std::size_t i) { return cellOf[i] != nullptr; })) {
        const TexelPlace place = placeOf(geometry, map, map.texels[j]);
        cellOf[j]->push_back({j, place.position, place.normal});
    }
    const auto find = [&](std::size_t i, Sources& sources) {
        const ivec3 cell = gridCell(missing[i].position, reach);
        for (int n = 0; n < 27; ++n) {
            for (const ValidTexel& other : grid.at(gridKey(cell + ivec3(n % 3, n / 3 % 3, n / 9) - 1))) {
                const float distance = glm::distance(other.position, missing[i].position) / reach;
                const float facing = glm::dot(other.normal, missing[i].normal);
                if (distance >= 1.0f || facing <= kSameSideCosine) continue;
                sources.add(other.texel, (1.0f - distance) * (facing - kSameSideCosine));
            }
        }
    };
    takeMeans(64, find, known, open, values);
}

/// A place of a row of the padding, and the value that it takes.
template<typename T> struct Growth {
    uint16_t x = 0;
    uint32_t chart = 0; ///< + 1; 0 = none is next to it
    T value{};
};

/// What the place `at` takes of its neighbours, of the chart with the lowest number.
template<typename T> Growth<T> grownAt(const Image<T>& page, const Image<uint32_t>& charts, ivec2 at, bool extrapolate)
{
    const auto isInside = [&](ivec2 q) { return q.x >= 0 && q.y >= 0 && q.x < page.width() && q.y < page.height(); };
    Growth<T> growth{uint16_t(at.x)};
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            const ivec2 q = at + ivec2(dx, dy);
            if (!isInside(q)) continue;
            const uint32_t other = charts(q.x, q.y);
            if (other != 0u && (growth.chart == 0u || other < growth.chart)) growth.chart = other;
        }
    }
    if (growth.chart == 0u) return growth;
    const auto owned = [&](ivec2 q) { return isInside(q) && charts(q.x, q.y) == growth.chart; };
    T sum{};
    float weight = 0.0f;
    T straight{};
    float straightWeight = 0.0f;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            const ivec2 q = at + ivec2(dx, dy);
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
    growth.value = straightWeight > 0.0f ? straight / straightWeight : sum / weight;
    return growth;
}

/// Ring by ring, empty places of a page take values of the charts next to them.
template<typename T> void growIntoPadding(Image<T>& page, Image<uint32_t>& charts, int rings, bool extrapolate)
{
    // Rows are lists of their own, so that threads share the work of collecting and writing too.
    std::vector<std::vector<Growth<T>>> openOfRow(std::size_t(page.height()));
    const auto forRows = [&](const auto& body) {
        parallelFor(openOfRow.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y) body(int(y), openOfRow[y]);
        });
    };
    forRows([&](int y, std::vector<Growth<T>>& open) {
        for (int x = 0; x < page.width(); ++x) {
            if (charts(x, y) == 0u) open.push_back({uint16_t(x)});
        }
    });
    for (int ring = 0; ring < rings; ++ring) {
        forRows([&](int y, std::vector<Growth<T>>& open) {
            for (Growth<T>& growth : open) growth = grownAt(page, charts, ivec2(growth.x, y), extrapolate);
        });
        forRows([&](int y, std::vector<Growth<T>>& open) {
            for (const Growth<T>& growth : open) {
                if (growth.chart == 0u) continue;
                page(growth.x, y) = growth.value;
                charts(growth.x, y) = growth.chart;
            }
            std::erase_if(open, [](const Growth<T>& growth) { return growth.chart != 0u; });
        });
    }
}

} // namespace

template<typename T> void fillInvalid(const BakeGeometry& geometry, const TexelMap& map,
                                      const std::vector<uint8_t>& valid, Quantities<T> values)
{
    std::vector<uint32_t> open = indicesWhere(valid.size(), [&](std::size_t i) { return valid[i] == 0; });
    if (open.empty()) return;
    const TexelGrid grid(map);
    std::vector<uint8_t> known = valid;
    // Values of the same chart precede those of other charts in the rings that dilation adds.
    growWithinCharts(map, grid, kDilationRings, known, open, values);
    adoptNeighbors(geometry, map, valid, known, open, values);
    growWithinCharts(map, grid, map.pageSize, known, open, values);
}

template<typename T>
std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings, bool extrapolate)
{
    std::vector<Image<T>> pages;
    // Chart + 1 of each place, 0 = empty. A place between two charts belongs to the nearer one, at equal distance to
    // the lower number.
    std::vector<Image<uint32_t>> charts;
    for (int p = 0; p < map.pageCount; ++p) {
        pages.emplace_back(map.pageSize, map.pageSize);
        charts.emplace_back(map.pageSize, map.pageSize, 0u);
    }
    forEachIndex(map.texels.size(), [&](std::size_t i) {
        const Texel& texel = map.texels[i];
        pages[texel.page](texel.x, texel.y) = values[i];
        charts[texel.page](texel.x, texel.y) = texel.chart + 1;
    });
    for (std::size_t p = 0; p < pages.size(); ++p) growIntoPadding(pages[p], charts[p], rings, extrapolate);
    return pages;
}

template void fillInvalid(const BakeGeometry&, const TexelMap&, const std::vector<uint8_t>&, Quantities<vec3>);
template void fillInvalid(const BakeGeometry&, const TexelMap&, const std::vector<uint8_t>&, Quantities<vec4>);
template std::vector<Image<vec3>> dilate(const TexelMap&, const std::vector<vec3>&, int, bool);
template std::vector<Image<vec4>> dilate(const TexelMap&, const std::vector<vec4>&, int, bool);

} // namespace halflight
