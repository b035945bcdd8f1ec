#include "bake/stages.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/polygon.h"
#include "halflight/base/random.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

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
    uint64_t key; ///< page and place of the texel, in the order of TexelMap::texels
    TexelFragment fragment;
};

/// Interleaves the low 16 bits of x and y: neighbours in the picture stay neighbours in memory and among rays.
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

/// All texels a triangle touches, with the centroid and area of what lies in each.
void rasterizeTriangle(const BakeGeometry& geometry, uint32_t triangle, int page, int pageSize,
                       std::vector<RasterFragment>& out)
{
    const uvec3 t = geometry.triangles[triangle];
    const vec2 a = geometry.lightmapTexel[t.x];
    const vec2 b = geometry.lightmapTexel[t.y];
    const vec2 c = geometry.lightmapTexel[t.z];
    if (cross2(b - a, c - a) == 0.0f || geometry.geometricNormal(triangle) == vec3(0.0f)) return;
    const ivec2 lower = glm::max(ivec2(glm::floor(glm::min(a, glm::min(b, c)))), ivec2(0));
    const ivec2 upper = glm::min(ivec2(glm::floor(glm::max(a, glm::max(b, c)))), ivec2(pageSize - 1));
    Polygon whole;
    whole.points[0] = a;
    whole.points[1] = b;
    whole.points[2] = c;
    whole.count = 3;
    for (int y = lower.y; y <= upper.y; ++y) {
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
            // Area and centroid relative to the texel's corner, where floats are small.
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

/// Chart of each triangle: triangles of an object are in one chart when they share a point of surface and of lightmap.
std::vector<uint32_t> chartsOfTriangles(const BakeGeometry& geometry, uint32_t& chartCount)
{
    struct Corner {
        int object;
        uint32_t vertex;
    };
    std::vector<Corner> corners;
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.page < 0) continue;
        for (uint32_t v = 0; v < part.vertexCount; ++v) corners.push_back({part.object, part.firstVertex + v});
    }
    const auto key = [&](const Corner& c) {
        const vec3 p = geometry.positions[c.vertex];
        const vec2 l = geometry.lightmapTexel[c.vertex];
        return std::make_tuple(c.object, l.x, l.y, p.x, p.y, p.z);
    };
    std::sort(corners.begin(), corners.end(), [&](const Corner& a, const Corner& b) {
        const auto ka = key(a);
        const auto kb = key(b);
        return ka != kb ? ka < kb : a.vertex < b.vertex;
    });
    DisjointSets vertices(geometry.positions.size());
    for (std::size_t i = 1; i < corners.size(); ++i) {
        if (key(corners[i - 1]) == key(corners[i])) vertices.join(corners[i - 1].vertex, corners[i].vertex);
    }
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.page < 0) continue;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            const uvec3 triangle = geometry.triangles[t];
            vertices.join(triangle.x, triangle.y);
            vertices.join(triangle.x, triangle.z);
        }
    }
    std::vector<uint32_t> chartOfRoot(geometry.positions.size(), ~0u);
    std::vector<uint32_t> charts(geometry.triangles.size(), ~0u);
    chartCount = 0;
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.page < 0) continue;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            uint32_t& chart = chartOfRoot[vertices.find(geometry.triangles[t].x)];
            if (chart == ~0u) chart = chartCount++;
            charts[t] = chart;
        }
    }
    return charts;
}

/// A triangle's points, moved off its edges by a few thousandths of a texel: rays from an edge on which two walls meet
/// would start in the other wall's plane, and may miss it.
class PointsOffEdges {
public:
    PointsOffEdges(const BakeGeometry& geometry, uint32_t triangle) : frame_(geometry, triangle)
    {
        const uvec3 t = geometry.triangles[triangle];
        vec2 corners[3];
        for (int i = 0; i < 3; ++i) corners[i] = geometry.lightmapTexel[t[i]];
        // As weights: over the triangle's heights, which are its area over its edges.
        constexpr float kTexels = 4.0e-3f;
        const float area = std::abs(cross2(corners[1] - corners[0], corners[2] - corners[0]));
        const float weightOfEdge = kTexels / std::max(area, 1.0e-12f);
        for (int i = 0; i < 3; ++i) {
            least_[i] = std::min(weightOfEdge * glm::distance(corners[(i + 1) % 3], corners[(i + 2) % 3]), 1.0f / 3.0f);
        }
    }
    void put(vec2 barycentric, SurfacePoint& out) const
    {
        const float w = 1.0f - barycentric.x - barycentric.y;
        if (w < least_[0] || barycentric.x < least_[1] || barycentric.y < least_[2]) {
            const vec3 weights = glm::max(vec3(w, barycentric.x, barycentric.y), least_);
            barycentric = vec2(weights.y, weights.z) * (1.0f / (weights.x + weights.y + weights.z));
        }
        frame_.put(barycentric, out);
    }

private:
    TriangleFrame frame_;
    vec3 least_{0.0f};
};

constexpr uint32_t kAllCandidates = (1u << kMaxTexelPoints) - 1u;
constexpr std::array<uint32_t, kMaxTexelPoints> kBits = [] {
    std::array<uint32_t, kMaxTexelPoints> bits{};
    for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = 1u << i;
    return bits;
}();

using PointArray = std::span<SurfacePoint, kMaxTexelPoints>;

struct Rectangle {
    vec2 min{0.0f};
    vec2 size{1.0f};
};

/// The part of a texel's rectangle that the bounds of its triangles reach.
Rectangle coveredRectangle(const BakeGeometry& geometry, std::span<const TexelFragment> fragments, const Rectangle& in)
{
    vec2 min = in.min + in.size;
    vec2 max = in.min;
    for (const TexelFragment& fragment : fragments) {
        const uvec3 t = geometry.triangles[fragment.triangle];
        for (int i = 0; i < 3; ++i) {
            min = glm::min(min, geometry.lightmapTexel[t[i]]);
            max = glm::max(max, geometry.lightmapTexel[t[i]]);
        }
    }
    min = glm::max(min, in.min);
    return {min, glm::max(glm::min(max, in.min + in.size) - min, vec2(0.0f))};
}

/// A round of candidates for a texel's points, those of a lattice over a rectangle from number `first` on: puts into
/// `out` what the texel's triangles cover of them. Returns a bit for each that is covered.
uint32_t coveredPoints(const BakeGeometry& geometry, std::span<const TexelFragment> fragments, const Rectangle& in,
                       int first, PointArray out)
{
    std::array<float, kMaxTexelPoints> x;
    std::array<float, kMaxTexelPoints> y;
    for (int i = 0; i < kMaxTexelPoints; ++i) {
        const vec2 place = in.min + in.size * r2Point(first + i);
        x[std::size_t(i)] = place.x;
        y[std::size_t(i)] = place.y;
    }
    uint32_t found = 0;
    for (const TexelFragment& fragment : fragments) {
        const uvec3 t = geometry.triangles[fragment.triangle];
        const vec2 corner = geometry.lightmapTexel[t.x];
        const vec2 edge1 = geometry.lightmapTexel[t.y] - corner;
        const vec2 edge2 = geometry.lightmapTexel[t.z] - corner;
        const float area = cross2(edge1, edge2);
        if (std::abs(area) < 1.0e-20f) continue;
        const float inverse = 1.0f / area;
        // Apart, so that the compiler handles several points at once.
        std::array<float, kMaxTexelPoints> u;
        std::array<float, kMaxTexelPoints> v;
        for (std::size_t i = 0; i < kMaxTexelPoints; ++i) {
            const float dx = x[i] - corner.x;
            const float dy = y[i] - corner.y;
            u[i] = (dx * edge2.y - dy * edge2.x) * inverse;
            v[i] = (edge1.x * dy - edge1.y * dx) * inverse;
        }
        std::array<float, kMaxTexelPoints> least;
        for (std::size_t i = 0; i < kMaxTexelPoints; ++i)
            least[i] = std::min(std::min(u[i], v[i]), 1.0f - (u[i] + v[i])) + 0.0f;
        // Where the least weight has no sign. (Its sign bit: compilers make scalar code of comparisons here.)
        const auto bits = std::bit_cast<std::array<int32_t, kMaxTexelPoints>>(least);
        uint32_t covered = 0;
        for (std::size_t i = 0; i < kMaxTexelPoints; ++i) covered |= kBits[i] & ~uint32_t(bits[i] >> 31);
        covered &= ~found;
        if (covered == 0) continue;
        found |= covered;
        const PointsOffEdges points(geometry, fragment.triangle);
        for (uint32_t rest = covered; rest != 0; rest &= rest - 1u) {
            const auto i = std::size_t(std::countr_zero(rest));
            points.put({u[i], v[i]}, out[i]);
        }
        if (found == kAllCandidates) break;
    }
    return found;
}

} // namespace

TexelMap rasterizeTexels(const BakeGeometry& geometry, int pageSize, int pageCount)
{
    TexelMap map;
    map.pageSize = pageSize;
    map.pageCount = pageCount;
    const std::vector<uint32_t> charts = chartsOfTriangles(geometry, map.chartCount);

    std::vector<std::vector<RasterFragment>> perPart(geometry.parts.size());
    parallelFor(geometry.parts.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const BakeGeometry::Part& part = geometry.parts[i];
            if (part.page < 0) continue;
            for (uint32_t t = 0; t < part.triangleCount; ++t) {
                rasterizeTriangle(geometry, part.firstTriangle + t, part.page, pageSize, perPart[i]);
            }
        }
    });
    std::vector<RasterFragment> fragments;
    std::size_t total = 0;
    for (const auto& list : perPart) total += list.size();
    fragments.reserve(total);
    for (auto& list : perPart) {
        fragments.insert(fragments.end(), list.begin(), list.end());
        release(list);
    }
    std::sort(fragments.begin(), fragments.end(), [](const RasterFragment& a, const RasterFragment& b) {
        return a.key != b.key ? a.key < b.key : a.fragment.triangle < b.fragment.triangle;
    });

    // A texel belongs to one chart: where a kept layout lets two meet, the one that covers more of the texel has it.
    map.fragments.reserve(fragments.size());
    std::vector<std::pair<uint32_t, float>> areaOfChart;
    for (std::size_t i = 0; i < fragments.size();) {
        std::size_t j = i;
        areaOfChart.clear();
        for (; j < fragments.size() && fragments[j].key == fragments[i].key; ++j) {
            const uint32_t chart = charts[fragments[j].fragment.triangle];
            const auto found =
                std::find_if(areaOfChart.begin(), areaOfChart.end(), [&](const auto& e) { return e.first == chart; });
            if (found == areaOfChart.end()) {
                areaOfChart.emplace_back(chart, fragments[j].fragment.area);
            } else {
                found->second += fragments[j].fragment.area;
            }
        }
        const uint32_t chart =
            std::max_element(areaOfChart.begin(), areaOfChart.end(), [](const auto& a, const auto& b) {
                return a.second != b.second ? a.second < b.second : a.first > b.first;
            })->first;
        const ivec2 place = mortonDecode(uint32_t(fragments[i].key));
        Texel texel;
        texel.x = uint16_t(place.x);
        texel.y = uint16_t(place.y);
        texel.page = uint32_t(fragments[i].key >> 32);
        texel.chart = chart;
        texel.firstFragment = uint32_t(map.fragments.size());
        for (; i < j; ++i) {
            if (charts[fragments[i].fragment.triangle] == chart) map.fragments.push_back(fragments[i].fragment);
        }
        texel.fragmentCount = uint32_t(map.fragments.size()) - texel.firstFragment;
        // The largest first: most points lie in a few.
        std::sort(map.fragments.end() - texel.fragmentCount, map.fragments.end(),
                  [](const TexelFragment& a, const TexelFragment& b) {
                      return a.area != b.area ? a.area > b.area : a.triangle < b.triangle;
                  });
        map.texels.push_back(texel);
    }
    return map;
}

float coveredArea(const TexelMap& map, const Texel& texel)
{
    float covered = 0.0f;
    for (uint32_t f = 0; f < texel.fragmentCount; ++f) covered += map.fragments[texel.firstFragment + f].area;
    return covered;
}

int texelPoints(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel, PointArray out, int batch)
{
    const std::span fragments(map.fragments.data() + texel.firstFragment, texel.fragmentCount);
    const float covered = coveredArea(map, texel);
    // A texel that is covered in part is to have no fewer points: candidates are close to what is covered, and come in
    // as many rounds as about fill a batch.
    constexpr int kMostRounds = 8;
    Rectangle candidates{vec2(texel.x, texel.y)};
    int rounds = 1;
    if (covered < kMostlyCovered) {
        candidates = coveredRectangle(geometry, fragments, candidates);
        const float times = candidates.size.x * candidates.size.y / std::max(covered, 1.0e-6f);
        rounds = int(std::clamp(times + 0.5f, 1.0f, float(kMostRounds)));
    }
    const auto findRound = [&](int round, PointArray points) {
        return coveredPoints(geometry, fragments, candidates, (batch * rounds + round) * kMaxTexelPoints, points);
    };
    int count = 0;
    const auto keep = [&](uint32_t found, PointArray points) {
        for (int i = 0; i < kMaxTexelPoints && count < kMaxTexelPoints; ++i) {
            if (((found >> i) & 1u) != 0) out[std::size_t(count++)] = points[std::size_t(i)];
        }
    };
    // Most texels have all of their points where they are to be.
    const uint32_t found = findRound(0, out);
    if (found == kAllCandidates) return kMaxTexelPoints;
    keep(found, out);
    if (rounds > 1) {
        std::array<SurfacePoint, kMaxTexelPoints> more;
        for (int round = 1; round < rounds && count < kMaxTexelPoints; ++round) keep(findRound(round, more), more);
    }
    if (count > 0) return count;
    // Slivers that no candidate meets: the centroid of the largest piece.
    PointsOffEdges(geometry, fragments.front().triangle).put(fragments.front().barycentric, out[0]);
    return 1;
}

TexelPlace placeOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel)
{
    const TexelFragment& largest = map.fragments[texel.firstFragment];
    const SurfacePoint point = surfacePoint(geometry, largest.triangle, largest.barycentric);
    return {point.position, point.normal, geometry.texelMeters(largest.triangle)};
}

std::vector<uint32_t> allIndices(std::size_t count)
{
    std::vector<uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

} // namespace halflight
