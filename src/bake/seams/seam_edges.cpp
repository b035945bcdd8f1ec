// Seams: edges of a continuous surface at which the lightmap is cut. Two triangles share the edge and have different
// lightmap coordinates there, or their edges overlap on one line without equal ends.
#include "bake/geometry/flatten.h"
#include "bake/geometry/hash_grid.h"
#include "bake/geometry/smooth_normals.h"
#include "bake/seams/seams.h"
#include "unwrap/cuts/crossing_points.h"

#include "halflight/base/parallel.h"

#include <glm/gtc/matrix_access.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <tuple>
#include <unordered_map>

namespace halflight {
namespace {

constexpr float kLineTexels = 0.05f;      ///< edges within this distance of a line lie on it
constexpr std::size_t kMostPartners = 64; ///< an edge with more neighbours on its line is no seam

/// One side of a seam: where an edge of a triangle lies in the lightmap.
struct EdgeSide {
    int object = 0;
    int page = 0;
    vec2 from{0.0f}; ///< texels, at the edge's lower end (by key)
    vec2 to{0.0f};
    vec3 normalFrom{0.0f}; ///< unit
    vec3 normalTo{0.0f};
    vec3 geometricNormal{0.0f};
    /// Offsets in the triangle's plane (x along the edge, y away from it, into the triangle; metres) for offsets in
    /// texels.
    mat2 metersFromTexels{1.0f};
    vec3 placeFrom{0.0f}; ///< in the world, at the edge's lower end
    vec3 placeTo{0.0f};
    vec3 inward{0.0f}; ///< unit, in the triangle's plane, at a right angle to the edge

    /// The part of the edge between the parameters s and t, 0…1.
    [[nodiscard]] EdgeSide part(float s, float t) const
    {
        EdgeSide side = *this;
        side.from = glm::mix(from, to, s);
        side.to = glm::mix(from, to, t);
        side.placeFrom = glm::mix(placeFrom, placeTo, s);
        side.placeTo = glm::mix(placeFrom, placeTo, t);
        side.normalFrom = glm::normalize(glm::mix(normalFrom, normalTo, s));
        side.normalTo = glm::normalize(glm::mix(normalFrom, normalTo, t));
        if (t < s) side.metersFromTexels = mat2(-1, 0, 0, 1) * metersFromTexels;
        return side;
    }
    /// A point near the edge, above the triangle.
    [[nodiscard]] vec3 above(float share) const
    {
        const float texelMeters = std::sqrt(std::abs(glm::determinant(metersFromTexels)));
        return glm::mix(placeFrom, placeTo, share) +
               texelMeters * (kSeamDistance * inward + kSightRise * geometricNormal);
    }
};

std::array<uint32_t, 3> positionBits(vec3 p)
{
    p += vec3(0.0f); // -0 becomes +0
    std::array<uint32_t, 3> bits{};
    std::memcpy(bits.data(), &p, sizeof(p));
    return bits;
}

/// An edge of a triangle. `ends`: bits of both ends' positions, the lower end first; equal for triangles that share it.
struct Edge {
    std::array<uint32_t, 6> ends{};
    uint32_t from = 0; ///< vertices
    uint32_t to = 0;
    uint32_t triangle = 0;
    uint32_t part = 0;

    [[nodiscard]] EdgeSide side(const BakeGeometry& geometry) const
    {
        const BakeGeometry::Part& p = geometry.parts[part];
        return {p.object,
                p.page,
                geometry.texelOf(p, from),
                geometry.texelOf(p, to),
                geometry.normalOf(p, from),
                geometry.normalOf(p, to),
                geometry.geometricNormal(triangle),
                metersFromTexels(geometry),
                geometry.positionOf(p, from),
                geometry.positionOf(p, to),
                inward(geometry)};
    }
    [[nodiscard]] vec3 inward(const BakeGeometry& geometry) const
    {
        const BakeGeometry::Part& p = geometry.parts[part];
        const uvec3 v = geometry.verticesOf(triangle);
        const vec3 origin = geometry.positionOf(p, from);
        const vec3 along = glm::normalize(geometry.positionOf(p, to) - origin);
        const vec3 toThird = geometry.positionOf(p, v.x + v.y + v.z - from - to) - origin;
        const vec3 across = toThird - glm::dot(toThird, along) * along;
        const float length = glm::length(across);
        return length > 0.0f ? across / length : vec3(0.0f);
    }
    [[nodiscard]] mat2 metersFromTexels(const BakeGeometry& geometry) const
    {
        const BakeGeometry::Part& p = geometry.parts[part];
        const uvec3 v = geometry.verticesOf(triangle);
        const uint32_t third = v.x + v.y + v.z - from - to;
        const vec3 along = geometry.positionOf(p, to) - geometry.positionOf(p, from);
        const vec3 toThird = geometry.positionOf(p, third) - geometry.positionOf(p, from);
        const float length = glm::length(along);
        const float x = glm::dot(toThird, along) / length;
        const float y = glm::length(glm::cross(toThird, along)) / length;
        const vec2 texel = geometry.texelOf(p, from);
        const mat2 texels(geometry.texelOf(p, to) - texel, geometry.texelOf(p, third) - texel);
        return mat2(vec2(length, 0.0f), vec2(x, y)) * glm::inverse(texels);
    }
};

/// By stored triangle, of shared meshes: bit e is set where edge e, from corner e to the next, joins two triangles of a
/// chart by common vertices, so that it is no seam.
std::vector<uint8_t> innerEdges(const BakeGeometry& geometry)
{
    struct Side {
        uint32_t low;
        uint32_t high; ///< vertices
        uint32_t triangle;
        int edge;
    };
    std::vector<uint8_t> inner(geometry.instances.empty() ? 0 : geometry.triangles.size(), 0);
    for (const uint32_t number : geometry.instances.empty() ? std::vector<uint32_t>() : partsOnce(geometry)) {
        const BakeGeometry::Part& part = geometry.parts[number];
        if (part.instance == BakeGeometry::kOwn) continue;
        std::vector<Side> sides;
        for (uint32_t t = part.firstStored; t < part.firstStored + part.triangleCount; ++t) {
            const uvec3 v = geometry.triangles[t];
            for (int e = 0; e < 3; ++e)
                sides.push_back({std::min(v[e], v[(e + 1) % 3]), std::max(v[e], v[(e + 1) % 3]), t, e});
        }
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
            return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
        });
        for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
            while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
            if (end - i != 2) continue;
            for (std::size_t s = i; s < end; ++s) inner[sides[s].triangle] |= uint8_t(1u << sides[s].edge);
        }
    }
    return inner;
}

/// Adds the edges of a triangle, but for those inside a chart of a shared mesh, and those without a length.
void addEdges(const BakeGeometry& geometry, const std::vector<uint8_t>& inner, uint32_t triangle,
              std::vector<Edge>& edges)
{
    const BakeGeometry::Part& part = geometry.partOf(triangle);
    if (part.page < 0) return;
    const uint32_t stored = part.firstStored + triangle - part.firstTriangle;
    const bool shared = part.instance != BakeGeometry::kOwn;
    const uvec3 v = geometry.triangles[stored];
    for (int e = 0; e < 3; ++e) {
        if (shared && ((inner[stored] >> e) & 1) != 0) continue;
        uint32_t a = v[e];
        uint32_t b = v[(e + 1) % 3];
        auto bitsA = positionBits(geometry.positionOf(part, a));
        auto bitsB = positionBits(geometry.positionOf(part, b));
        if (bitsA == bitsB) continue;
        if (bitsB < bitsA) {
            std::swap(a, b);
            std::swap(bitsA, bitsB);
        }
        Edge& edge = edges.emplace_back();
        std::copy(bitsA.begin(), bitsA.end(), edge.ends.begin());
        std::copy(bitsB.begin(), bitsB.end(), edge.ends.begin() + 3);
        edge.from = a;
        edge.to = b;
        edge.triangle = triangle;
        edge.part = uint32_t(&part - geometry.parts.data());
    }
}

/// Calls body(first, end, list) for ranges of `count` items on all threads. Returns the lists joined in their order.
template<typename T, typename Body> std::vector<T> joinedLists(std::size_t count, const Body& body)
{
    constexpr std::size_t kAtOnce = 512; // some tens of microseconds or more
    std::vector<std::vector<T>> lists((count + kAtOnce - 1) / kAtOnce);
    parallelFor(lists.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t l = begin; l < end; ++l) body(l * kAtOnce, std::min(count, (l + 1) * kAtOnce), lists[l]);
    });
    std::vector<T> all;
    for (const std::vector<T>& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

/// Edges, sorted so that edges with equal ends are adjacent: all of them, but for those inside a chart of a shared
/// mesh. (These are most edges of a scene with many instances.)
std::vector<Edge> collectEdges(const BakeGeometry& geometry)
{
    const std::vector<uint8_t> inner = innerEdges(geometry);
    auto edges =
        joinedLists<Edge>(geometry.triangleCount(), [&](std::size_t first, std::size_t end, std::vector<Edge>& list) {
            for (std::size_t t = first; t < end; ++t) addEdges(geometry, inner, uint32_t(t), list);
        });
    parallelSort(edges, [](const Edge& a, const Edge& b) {
        return std::tie(a.ends, a.triangle, a.from, a.to) < std::tie(b.ends, b.triangle, b.from, b.to);
    });
    return edges;
}

bool isSeam(const EdgeSide& a, const EdgeSide& b)
{
    const bool samePlace =
        a.page == b.page && glm::distance(a.from, b.from) < 1.0e-3f && glm::distance(a.to, b.to) < 1.0e-3f;
    // Where the triangles face away from each other, the edge is a hem, whatever the shading normals.
    return !samePlace && glm::dot(a.normalFrom, b.normalFrom) > kSmoothCosine &&
           glm::dot(a.normalTo, b.normalTo) > kSmoothCosine && glm::dot(a.geometricNormal, b.geometricNormal) >= 0.0f;
}

void addSamples(const EdgeSide& a, const EdgeSide& b, int pageSize, std::vector<SeamSample>& samples)
{
    const float length = std::max(glm::distance(a.from, a.to), glm::distance(b.from, b.to));
    const int count = std::clamp(int(std::ceil(2.0f * length)), 1, 4 * pageSize);
    const bool bent = glm::dot(a.geometricNormal, b.geometricNormal) < kSmoothCosine;
    const vec2 outwardA = -glm::normalize(glm::row(a.metersFromTexels, 1));
    const mat2 acrossFromA = glm::inverse(b.metersFromTexels) * mat2(1, 0, 0, -1) * a.metersFromTexels;
    for (int s = 0; s < count; ++s) {
        const float t = (float(s) + 0.5f) / float(count);
        samples.push_back({a.object,
                           a.page,
                           b.page,
                           glm::mix(a.from, a.to, t),
                           glm::mix(b.from, b.to, t),
                           length / float(count),
                           bent,
                           outwardA,
                           acrossFromA,
                           {a.above(t), b.above(t)}});
    }
}

/// An edge that no other triangle shares.
struct OpenEdge {
    EdgeSide side;
    vec3 a{0.0f};
    vec3 b{0.0f};
    float texelMeters = 0.0f;
};

/// Open edges in a hash grid, in all cells that they pass through.
class OpenEdges {
public:
    explicit OpenEdges(std::vector<OpenEdge> edges) : edges_(std::move(edges))
    {
        std::vector<float> lengths;
        for (const OpenEdge& edge : edges_) lengths.push_back(glm::distance(edge.a, edge.b));
        if (lengths.empty()) return;
        const float longest = *std::max_element(lengths.begin(), lengths.end());
        std::nth_element(lengths.begin(), lengths.begin() + std::ptrdiff_t(lengths.size() / 2), lengths.end());
        cell_ = std::max(lengths[lengths.size() / 2], longest / 1024.0f);
        for (std::size_t i = 0; i < edges_.size(); ++i)
            forCells(edges_[i], 0.0f, [&](uint64_t cell) { edgesIn_[cell].push_back(uint32_t(i)); });
    }

    [[nodiscard]] const std::vector<OpenEdge>& edges() const { return edges_; }

    /// Edges of higher index close to this one, ascending.
    [[nodiscard]] std::vector<uint32_t> near(uint32_t index) const
    {
        std::vector<uint32_t> found;
        const OpenEdge& edge = edges_[index];
        forCells(edge, kLineTexels * edge.texelMeters, [&](uint64_t cell) {
            const auto there = edgesIn_.find(cell);
            if (there == edgesIn_.end()) return;
            for (const uint32_t other : there->second)
                if (other > index) found.push_back(other);
        });
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }

private:
    /// Calls body(key) for each grid cell within `margin` of the edge; for some cells more than once.
    template<typename Body> void forCells(const OpenEdge& edge, float margin, const Body& body) const
    {
        const int steps = std::max(1, int(std::ceil(8.0f * glm::distance(edge.a, edge.b) / cell_)));
        uint64_t last = ~uint64_t(0);
        for (int s = 0; s <= steps; ++s) {
            const vec3 p = glm::mix(edge.a, edge.b, float(s) / float(steps));
            for (int corner = 0; corner < (margin > 0.0f ? 8 : 1); ++corner) {
                const vec3 q = p + margin * vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
                const uint64_t cell = gridKey(gridCell(q, cell_));
                if (cell != last) body(cell);
                last = cell;
            }
        }
    }

    std::vector<OpenEdge> edges_;
    std::unordered_map<uint64_t, std::vector<uint32_t>> edgesIn_;
    float cell_ = 1.0f;
};

/// Adds the overlap of two edges as a seam; none where they lie on different lines, or only touch.
void addCommonStretch(const OpenEdge& a, const OpenEdge& b, int pageSize, std::vector<SeamSample>& samples)
{
    const float length = glm::distance(a.a, a.b);
    const vec3 direction = (a.b - a.a) / length;
    const float texel = std::min(a.texelMeters, b.texelMeters);
    const auto along = [&](vec3 p) { return glm::dot(p - a.a, direction); };
    const auto offLine = [&](vec3 p) { return glm::distance(p, a.a + along(p) * direction); };
    if (std::max(offLine(b.a), offLine(b.b)) > kLineTexels * texel) return;
    const float begin = std::max(0.0f, std::min(along(b.a), along(b.b)));
    const float end = std::min(length, std::max(along(b.a), along(b.b)));
    if (end - begin < 0.25f * texel) return;
    const auto shareOfB = [&](float t) { return (t - along(b.a)) / (along(b.b) - along(b.a)); };
    const EdgeSide partA = a.side.part(begin / length, end / length);
    const EdgeSide partB = b.side.part(shareOfB(begin), shareOfB(end));
    if (isSeam(partA, partB)) addSamples(partA, partB, pageSize, samples);
}

/// Adds seams between triangles that share an edge.
void addSharedEdge(const BakeGeometry& geometry, std::span<const Edge> edges, int pageSize,
                   std::vector<SeamSample>& samples)
{
    constexpr std::size_t kMost = 4; // more triangles on one edge have no two sides
    if (edges.size() < 2 || edges.size() > kMost) return;
    std::array<EdgeSide, kMost> sides;
    for (std::size_t i = 0; i < edges.size(); ++i) sides[i] = edges[i].side(geometry);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        for (std::size_t j = i + 1; j < edges.size(); ++j) {
            if (isSeam(sides[i], sides[j])) addSamples(sides[i], sides[j], pageSize, samples);
        }
    }
}

void addOpenEdge(const BakeGeometry& geometry, const Edge& from, std::vector<OpenEdge>& open)
{
    const BakeGeometry::Part& part = geometry.parts[from.part];
    OpenEdge edge{from.side(geometry), geometry.positionOf(part, from.from), geometry.positionOf(part, from.to), 0};
    const float texels = glm::distance(edge.side.from, edge.side.to);
    edge.texelMeters = texels > 0.0f ? glm::distance(edge.a, edge.b) / texels : 0.0f;
    if (edge.texelMeters > 0.0f) open.push_back(edge);
}

/// Adds the seams between an open edge and those after it that overlap it.
void addStretches(const OpenEdges& byPlace, uint32_t edge, int pageSize, std::vector<SeamSample>& samples)
{
    const std::size_t first = samples.size();
    std::size_t count = 0;
    for (const uint32_t other : byPlace.near(edge)) {
        const std::size_t before = samples.size();
        addCommonStretch(byPlace.edges()[edge], byPlace.edges()[other], pageSize, samples);
        count += samples.size() > before ? 1 : 0;
    }
    if (count > kMostPartners) samples.resize(first);
}

} // namespace

std::vector<SeamSample> findSeams(const BakeGeometry& geometry, int pageSize)
{
    const std::vector<Edge> edges = collectEdges(geometry);
    const std::vector<uint32_t> firsts =
        indicesWhere(edges.size(), [&](std::size_t i) { return i == 0 || edges[i].ends != edges[i - 1].ends; });
    const auto edgesOf = [&](std::size_t group) {
        const std::size_t end = group + 1 < firsts.size() ? firsts[group + 1] : edges.size();
        return std::span(edges).subspan(firsts[group], end - firsts[group]);
    };
    auto samples = joinedLists<SeamSample>(firsts.size(), [&](std::size_t first, std::size_t end, auto& list) {
        for (std::size_t g = first; g < end; ++g) addSharedEdge(geometry, edgesOf(g), pageSize, list);
    });
    const OpenEdges byPlace(joinedLists<OpenEdge>(firsts.size(), [&](std::size_t first, std::size_t end, auto& list) {
        for (std::size_t g = first; g < end; ++g)
            if (edgesOf(g).size() == 1) addOpenEdge(geometry, edgesOf(g).front(), list);
    }));
    const auto onLines = joinedLists<SeamSample>(
        byPlace.edges().size(), [&](std::size_t first, std::size_t end, std::vector<SeamSample>& list) {
            for (std::size_t i = first; i < end; ++i) addStretches(byPlace, uint32_t(i), pageSize, list);
        });
    samples.insert(samples.end(), onLines.begin(), onLines.end());
    return samples;
}

} // namespace halflight
