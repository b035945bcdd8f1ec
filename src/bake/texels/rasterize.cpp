// Conservative rasterization of the lightmapped triangles on their pages.
#include "bake/texels/rasterize.h"
#include "bake/geometry/flatten.h"
#include "bake/geometry/indices.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/polygon.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace halflight {
namespace {

/// Barycentric weights of vertices 1 and 2 at p; false for a triangle without area in the lightmap.
bool barycentricAt(vec2 a, vec2 b, vec2 c, vec2 p, vec2& out)
{
    const float area = cross2(b - a, c - a);
    if (area == 0.0f) return false;
    out = vec2(cross2(p - a, c - a), cross2(b - a, p - a)) / area;
    return true;
}

struct RasterFragment {
    uint64_t key; ///< page and Morton code of the texel: the order of TexelMap::texels
    TexelFragment fragment;
};

/// Interleaves the low 16 bits of x and y (Morton 1966): texels close on the page are close in memory.
uint32_t mortonCode(uint32_t x, uint32_t y)
{
    const auto spread = [](uint32_t v) {
        v = (v | (v << 8)) & 0x00ff00ffu;
        v = (v | (v << 4)) & 0x0f0f0f0fu;
        v = (v | (v << 2)) & 0x33333333u;
        return (v | (v << 1)) & 0x55555555u;
    };
    return spread(x) | (spread(y) << 1);
}

ivec2 mortonDecode(uint32_t code)
{
    const auto compact = [](uint32_t v) {
        v &= 0x55555555u;
        v = (v | (v >> 1)) & 0x33333333u;
        v = (v | (v >> 2)) & 0x0f0f0f0fu;
        v = (v | (v >> 4)) & 0x00ff00ffu;
        return int((v | (v >> 8)) & 0x0000ffffu);
    };
    return {compact(code), compact(code >> 1)};
}

/// Texels of a page around a triangle, both ends included.
struct TexelBox {
    ivec2 lower{0};
    ivec2 upper{-1};
};

TexelBox boxOf(const BakeGeometry& geometry, uint32_t triangle, int pageSize)
{
    const auto [a, b, c] = geometry.texelsOf(triangle);
    return {glm::max(ivec2(glm::floor(glm::min(a, glm::min(b, c)))), ivec2(0)),
            glm::min(ivec2(glm::floor(glm::max(a, glm::max(b, c)))), ivec2(pageSize - 1))};
}

/// Clips a triangle against the squares of the texels that it overlaps, of those in rows from `firstRow` to `lastRow`.
void rasterizeTriangle(const BakeGeometry& geometry, uint32_t triangle, int page, int pageSize, int firstRow,
                       int lastRow, std::vector<RasterFragment>& out)
{
    const auto [a, b, c] = geometry.texelsOf(triangle);
    if (cross2(b - a, c - a) == 0.0f || geometry.geometricNormal(triangle) == vec3(0.0f)) return;
    const auto [lower, upper] = boxOf(geometry, triangle, pageSize);
    Polygon whole;
    whole.points[0] = a;
    whole.points[1] = b;
    whole.points[2] = c;
    whole.count = 3;
    for (int y = std::max(lower.y, firstRow); y <= std::min(upper.y, lastRow); ++y) {
        const Polygon row = clip(clip(whole, {0.0f, 1.0f}, float(y)), {0.0f, -1.0f}, -float(y + 1));
        if (row.count < 3) continue;
        float rowMin = kInfinity;
        float rowMax = -kInfinity;
        for (int i = 0; i < row.count; ++i) {
            rowMin = std::min(rowMin, row.points[std::size_t(i)].x);
            rowMax = std::max(rowMax, row.points[std::size_t(i)].x);
        }
        const int x0 = std::max(int(std::floor(rowMin)), 0);
        const int x1 = std::min(int(std::floor(rowMax)), pageSize - 1);
        for (int x = x0; x <= x1; ++x) {
            const Polygon piece = clip(clip(row, {1.0f, 0.0f}, float(x)), {-1.0f, 0.0f}, -float(x + 1));
            if (piece.count < 3) continue;
            // Relative to the texel's corner: small numbers keep the area's precision.
            const vec2 corner(static_cast<float>(x), static_cast<float>(y));
            float doubleArea = 0.0f;
            vec2 weighted(0.0f);
            vec2 mean(0.0f);
            for (int i = 0; i < piece.count; ++i) {
                const vec2 p = piece.points[std::size_t(i)] - corner;
                const vec2 q = piece.points[std::size_t((i + 1) % piece.count)] - corner;
                const float w = cross2(p, q);
                doubleArea += w;
                weighted += (p + q) * w;
                mean += p;
            }
            const float area = 0.5f * std::abs(doubleArea);
            vec2 centroid = area > 1.0e-6f ? weighted / (3.0f * doubleArea) : mean / float(piece.count);
            centroid = glm::clamp(centroid, vec2(0.0f), vec2(1.0f)) + corner;
            vec2 barycentric;
            if (!barycentricAt(a, b, c, centroid, barycentric)) continue;
            barycentric = glm::clamp(barycentric, vec2(0.0f), vec2(1.0f));
            if (const float sum = barycentric.x + barycentric.y; sum > 1.0f) barycentric /= sum;
            out.push_back({(uint64_t(page) << 32) | mortonCode(uint32_t(x), uint32_t(y)),
                           {triangle, barycentric, std::max(area, 1.0e-9f)}});
        }
    }
}

/// Charts of triangles. Instances of a mesh have charts of their own, numbered alike from the object's first on.
struct Charts {
    const BakeGeometry& geometry;
    std::vector<uint32_t> ofStored{}; ///< by stored triangle; for shared ones less firstOfPart
    std::vector<uint32_t> firstOfPart{};

    [[nodiscard]] uint32_t of(uint32_t triangle) const
    {
        const BakeGeometry::Part& part = geometry.partOf(triangle);
        return ofStored[part.firstStored + (triangle - part.firstTriangle)] +
               firstOfPart[std::size_t(&part - geometry.parts.data())];
    }
};

/// Joins the stored vertices of each chart: a chart is a connected component of an object's triangles, where two
/// triangles are connected by a vertex with equal position and equal lightmap coordinate. `parts`: partsOnce().
DisjointSets joinCharts(const BakeGeometry& geometry, std::span<const uint32_t> parts)
{
    struct Corner {
        int object;
        uint32_t vertex;
    };
    std::vector<Corner> corners;
    for (const uint32_t i : parts) {
        const BakeGeometry::Part& part = geometry.parts[i];
        for (uint32_t v = 0; v < part.vertexCount; ++v) corners.push_back({part.object, part.firstVertex + v});
    }
    const auto key = [&](const Corner& c) {
        const vec3 p = geometry.positions[c.vertex];
        const vec2 l = geometry.lightmapTexel[c.vertex];
        return std::make_tuple(c.object, l.x, l.y, p.x, p.y, p.z);
    };
    parallelSort(corners, [&](const Corner& a, const Corner& b) {
        const auto ka = key(a);
        const auto kb = key(b);
        return ka != kb ? ka < kb : a.vertex < b.vertex;
    });
    DisjointSets vertices(geometry.positions.size());
    for (std::size_t i = 1; i < corners.size(); ++i) {
        if (key(corners[i - 1]) == key(corners[i])) vertices.join(corners[i - 1].vertex, corners[i].vertex);
    }
    for (const uint32_t i : parts) {
        const BakeGeometry::Part& part = geometry.parts[i];
        for (uint32_t t = part.firstStored; t < part.firstStored + part.triangleCount; ++t) {
            const uvec3 triangle = geometry.triangles[t];
            vertices.join(triangle.x, triangle.y);
            vertices.join(triangle.x, triangle.z);
        }
    }
    return vertices;
}

Charts chartsOf(const BakeGeometry& geometry, uint32_t& chartCount)
{
    std::vector<uint32_t> once = partsOnce(geometry);
    std::erase_if(once, [&](uint32_t i) {
        return geometry.parts[i].page < 0 && geometry.parts[i].instance == BakeGeometry::kOwn;
    });
    DisjointSets vertices = joinCharts(geometry, once);
    std::vector<uint32_t> chartOfRoot(geometry.positions.size(), ~0u);
    Charts charts{geometry};
    charts.ofStored.assign(geometry.triangles.size(), ~0u);
    charts.firstOfPart.assign(geometry.parts.size(), 0);
    std::unordered_map<int, uint32_t> countOfMesh; // charts, of shared meshes
    chartCount = 0;
    auto next = once.begin();
    for (uint32_t i = 0; i < geometry.parts.size();) {
        const int object = geometry.parts[i].object;
        const int mesh = geometry.parts[i].mesh;
        const bool shared = geometry.parts[i].instance != BakeGeometry::kOwn;
        const uint32_t before = chartCount;
        for (; i < geometry.parts.size() && geometry.parts[i].object == object; ++i) {
            if (shared) charts.firstOfPart[i] = before;
            if (next == once.end() || *next != i) continue;
            ++next;
            const BakeGeometry::Part& part = geometry.parts[i];
            for (uint32_t t = part.firstStored; t < part.firstStored + part.triangleCount; ++t) {
                uint32_t& chart = chartOfRoot[vertices.find(geometry.triangles[t].x)];
                if (chart == ~0u) chart = chartCount++;
                charts.ofStored[t] = shared ? chart - before : chart;
            }
        }
        if (!shared) continue;
        const auto [entry, isFirst] = countOfMesh.try_emplace(mesh, chartCount - before);
        if (!isFirst) chartCount += entry->second;
    }
    return charts;
}

/// Fragments of a run of triangles, in the order of their texels, then of their triangles.
struct FragmentRun {
    int page = 0;
    uint32_t firstTriangle = 0;
    uint32_t triangleCount = 0;
    int firstRow = 0; ///< of the page
    int lastRow = 0;
    std::vector<RasterFragment> fragments{};
};

bool isBefore(const RasterFragment& a, const RasterFragment& b)
{
    return a.key != b.key ? a.key < b.key : a.fragment.triangle < b.fragment.triangle;
}

/// Adds the runs of a part. Each is as much work as others: a large triangle is divided by rows.
void addRuns(const BakeGeometry& geometry, const BakeGeometry::Part& part, int pageSize, std::vector<FragmentRun>& runs)
{
    constexpr uint32_t kTriangles = 1024;
    constexpr int64_t kTexels = 1 << 15; // around triangles: 10 ms
    int64_t texels = kTexels + 1;        // of the last run, where it takes more triangles
    for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
        const auto [lower, upper] = boxOf(geometry, t, pageSize);
        const ivec2 size = glm::max(upper - lower + 1, ivec2(0));
        const int64_t own = int64_t(size.x) * size.y;
        if (own > kTexels) {
            const int rows = std::max(int(kTexels / size.x), 1);
            for (int y = lower.y; y <= upper.y; y += rows)
                runs.push_back({part.page, t, 1, y, std::min(y + rows - 1, upper.y)});
            texels = kTexels + 1;
            continue;
        }
        if (texels + own > kTexels || runs.back().triangleCount == kTriangles) {
            runs.push_back({part.page, t, 0, 0, pageSize - 1});
            texels = 0;
        }
        runs.back().triangleCount += 1;
        texels += own;
    }
}

std::vector<FragmentRun> rasterizeRuns(const BakeGeometry& geometry, int pageSize)
{
    std::vector<FragmentRun> runs;
    for (const BakeGeometry::Part& part : geometry.parts)
        if (part.page >= 0) addRuns(geometry, part, pageSize, runs);
    parallelFor(runs.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            FragmentRun& run = runs[i];
            for (uint32_t t = 0; t < run.triangleCount; ++t)
                rasterizeTriangle(geometry, run.firstTriangle + t, run.page, pageSize, run.firstRow, run.lastRow,
                                  run.fragments);
            std::sort(run.fragments.begin(), run.fragments.end(), isBefore);
            run.fragments.shrink_to_fit(); // all runs are kept for a while
        }
    });
    return runs;
}

/// Fragments of the texels with keys from `first` to before `end`, in the order of their texels, then of their
/// triangles.
std::vector<RasterFragment> fragmentsBetween(std::span<const FragmentRun> runs, uint64_t first, uint64_t end)
{
    const auto isBelow = [](const RasterFragment& f, uint64_t key) { return f.key < key; };
    std::vector<RasterFragment> fragments;
    for (const FragmentRun& run : runs) {
        if (run.fragments.empty() || run.fragments.front().key >= end || run.fragments.back().key < first) continue;
        const auto from = std::lower_bound(run.fragments.begin(), run.fragments.end(), first, isBelow);
        fragments.insert(fragments.end(), from, std::lower_bound(from, run.fragments.end(), end, isBelow));
    }
    std::sort(fragments.begin(), fragments.end(), isBefore);
    return fragments;
}

/// The chart that covers the largest part of a texel. Charts share texels only in layouts that a file brought along.
uint32_t dominantChart(std::span<const RasterFragment> fragments, const Charts& charts,
                       std::vector<std::pair<uint32_t, float>>& areaOfChart)
{
    areaOfChart.clear();
    for (const RasterFragment& f : fragments) {
        const uint32_t chart = charts.of(f.fragment.triangle);
        const auto found =
            std::find_if(areaOfChart.begin(), areaOfChart.end(), [&](const auto& e) { return e.first == chart; });
        if (found == areaOfChart.end()) {
            areaOfChart.emplace_back(chart, f.fragment.area);
        } else {
            found->second += f.fragment.area;
        }
    }
    return std::max_element(areaOfChart.begin(), areaOfChart.end(),
                            [](const auto& a, const auto& b) {
                                return a.second != b.second ? a.second < b.second : a.first > b.first;
                            })
        ->first;
}

/// Adds a texel with its fragments of one chart, the largest first: most sample points lie in the first few.
void addTexel(std::span<const RasterFragment> fragments, const Charts& charts, uint32_t chart, TexelMap& map)
{
    const uint64_t key = fragments.front().key;
    const ivec2 place = mortonDecode(uint32_t(key));
    Texel texel;
    texel.x = uint16_t(place.x);
    texel.y = uint16_t(place.y);
    texel.page = uint32_t(key >> 32);
    texel.chart = chart;
    texel.firstFragment = uint32_t(map.fragments.size());
    for (const RasterFragment& f : fragments) {
        if (charts.of(f.fragment.triangle) == chart) map.fragments.push_back(f.fragment);
    }
    texel.fragmentCount = uint32_t(map.fragments.size()) - texel.firstFragment;
    std::sort(map.fragments.end() - texel.fragmentCount, map.fragments.end(),
              [](const TexelFragment& a, const TexelFragment& b) {
                  return a.area != b.area ? a.area > b.area : a.triangle < b.triangle;
              });
    map.texels.push_back(texel);
}

/// The texels and fragments of all pieces, in their order.
void joinMaps(std::vector<TexelMap>& pieces, TexelMap& map)
{
    struct Places {
        std::size_t texel = 0;
        std::size_t fragment = 0;
    };
    std::vector<Places> places(pieces.size() + 1);
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        places[p + 1] = {places[p].texel + pieces[p].texels.size(), places[p].fragment + pieces[p].fragments.size()};
    }
    map.texels = largeVector<Texel>(places.back().texel);
    map.fragments = largeVector<TexelFragment>(places.back().fragment);
    parallelFor(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            for (Texel& texel : pieces[p].texels) texel.firstFragment += uint32_t(places[p].fragment);
            std::ranges::copy(pieces[p].texels, map.texels.begin() + std::ptrdiff_t(places[p].texel));
            std::ranges::copy(pieces[p].fragments, map.fragments.begin() + std::ptrdiff_t(places[p].fragment));
            pieces[p] = {};
        }
    });
}

} // namespace

TexelMap rasterizeTexels(const BakeGeometry& geometry, int pageSize, int pageCount)
{
    TexelMap map;
    map.pageSize = pageSize;
    map.pageCount = pageCount;
    const Charts charts = chartsOf(geometry, map.chartCount);
    std::vector<FragmentRun> runs = rasterizeRuns(geometry, pageSize);
    // Squares of a page's texels, each a map of its own, then all of them in order.
    constexpr uint64_t kSquare = 64 * 64; // texels; a square's Morton codes are consecutive
    const uint64_t perPage = uint64_t(mortonCode(uint32_t(pageSize - 1), uint32_t(pageSize - 1))) / kSquare + 1;
    std::vector<TexelMap> pieces(perPage * uint64_t(pageCount));
    parallelFor(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<std::pair<uint32_t, float>> areaOfChart;
        for (std::size_t p = begin; p < end; ++p) {
            const uint64_t first = (uint64_t(p / perPage) << 32) + p % perPage * kSquare;
            const std::vector<RasterFragment> fragments = fragmentsBetween(runs, first, first + kSquare);
            for (std::size_t i = 0, next = 0; i < fragments.size(); i = next) {
                while (next < fragments.size() && fragments[next].key == fragments[i].key) ++next;
                const std::span<const RasterFragment> ofTexel(&fragments[i], next - i);
                addTexel(ofTexel, charts, dominantChart(ofTexel, charts, areaOfChart), pieces[p]);
            }
        }
    });
    release(runs);
    joinMaps(pieces, map);
    return map;
}

std::vector<uint32_t> allIndices(std::size_t count)
{
    std::vector<uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

} // namespace halflight
