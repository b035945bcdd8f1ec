#include "unwrap/surface/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <unordered_map>

namespace halflight::charts {
namespace {

struct PositionHash {
    std::size_t operator()(const std::array<uint32_t, 4>& bits) const
    {
        uint64_t hash = bits[0] * 0x9E3779B97F4A7C15ull;
        hash = (hash ^ (hash >> 29) ^ bits[1]) * 0xBF58476D1CE4E5B9ull;
        hash = (hash ^ (hash >> 32) ^ bits[2]) * 0x94D049BB133111EBull;
        return hash ^ (hash >> 31) ^ bits[3];
    }
};

/// A half edge with its undirected key, to be sorted.
struct HalfEdge {
    uint64_t key;
    uint32_t portion;
    uint32_t id;
};

/// A triangle thinner than this share of its longest edge is noise of its float coordinates, not a surface.
constexpr double kMinimumAspect = 1e-6;

void measureTriangles(Surface& surface)
{
    const std::size_t count = surface.triangleCount();
    surface.normals.assign(count, dvec3(0.0));
    surface.areas.assign(count, 0.0);
    for (std::size_t t = 0; t < count; ++t) {
        const dvec3 a = surface.corner(t, 0), b = surface.corner(t, 1), c = surface.corner(t, 2);
        const dvec3 cross = glm::cross(b - a, c - a);
        const double doubleArea = glm::length(cross);
        const double longest2 = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
        if (!std::isfinite(doubleArea) || !(longest2 > 0.0) || !(doubleArea > kMinimumAspect * longest2)) continue;
        surface.areas[t] = 0.5 * doubleArea;
        surface.normals[t] = cross / doubleArea;
    }
}

/// Pairs half edges along one geometric edge. Two that run in opposite directions are a surface; where more than two
/// meet (fins, sheets modelled from both sides) the pair that bends least goes first, and what is left over is border.
void pairHalfEdges(Surface& surface, const HalfEdge* first, const HalfEdge* last)
{
    constexpr std::ptrdiff_t kMostAtOneEdge = 32;
    if (last - first < 2 || last - first > kMostAtOneEdge) return;
    const auto startOf = [&](uint32_t id) { return surface.triangles[id / 3][id % 3]; };
    const auto pair = [&](uint32_t a, uint32_t b) {
        surface.neighbors[a] = b;
        surface.neighbors[b] = a;
    };
    if (last - first == 2) {
        if (startOf(first[0].id) != startOf(first[1].id)) pair(first[0].id, first[1].id);
        return;
    }
    while (true) {
        double best = -2.0;
        uint32_t bestA = kNone, bestB = kNone;
        for (const HalfEdge* a = first; a != last; ++a) {
            if (surface.neighbors[a->id] != kNone) continue;
            for (const HalfEdge* b = a + 1; b != last; ++b) {
                if (surface.neighbors[b->id] != kNone || startOf(a->id) == startOf(b->id)) continue;
                const double cosine = glm::dot(surface.normals[a->id / 3], surface.normals[b->id / 3]);
                if (cosine > best) {
                    best = cosine;
                    bestA = a->id;
                    bestB = b->id;
                }
            }
        }
        if (bestA == kNone) return;
        pair(bestA, bestB);
    }
}

void findNeighbors(Surface& surface, std::span<const uint32_t> portions)
{
    surface.neighbors.assign(3 * surface.triangleCount(), kNone);
    std::vector<HalfEdge> edges;
    edges.reserve(3 * surface.triangleCount());
    for (std::size_t t = 0; t < surface.triangleCount(); ++t) {
        if (surface.degenerate(t)) continue;
        for (uint32_t k = 0; k < 3; ++k) {
            const uint64_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
            edges.push_back(
                {std::min(a, b) << 32 | std::max(a, b), portions.empty() ? 0 : portions[t], uint32_t(3 * t + k)});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
        return std::tie(a.key, a.portion, a.id) < std::tie(b.key, b.portion, b.id);
    });
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        for (end = begin;
             end < edges.size() && edges[end].key == edges[begin].key && edges[end].portion == edges[begin].portion;)
            ++end;
        pairHalfEdges(surface, edges.data() + begin, edges.data() + end);
    }
}

} // namespace

Surface buildSurface(const Mesh& mesh, const dmat3& worldFromObject, std::span<const uint32_t> portions,
                     std::span<const float> texelWidths)
{
    Surface surface;
    std::size_t vertexCount = 0;
    for (const MeshPart& part : mesh.parts) vertexCount += part.positions.size();
    std::unordered_map<std::array<uint32_t, 4>, uint32_t, PositionHash> welded; // by position and texel width
    welded.reserve(vertexCount);
    surface.triangles.reserve(mesh.triangleCount());
    const auto weld = [&](vec3 position, float texelWidth) {
        const vec3 p = position + vec3(0.0f); // -0 becomes +0
        const std::array<uint32_t, 4> bits{std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y),
                                           std::bit_cast<uint32_t>(p.z), std::bit_cast<uint32_t>(texelWidth)};
        const auto [found, inserted] = welded.try_emplace(bits, uint32_t(surface.positions.size()));
        if (inserted) surface.positions.push_back(worldFromObject * dvec3(p) / double(texelWidth));
        return found->second;
    };
    std::vector<uint32_t> weldedVertex;
    for (const MeshPart& part : mesh.parts) {
        weldedVertex.resize(part.positions.size());
        for (std::size_t v = 0; v < part.positions.size(); ++v) weldedVertex[v] = weld(part.positions[v], 1.0f);
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            const float width = texelWidths.empty() ? 1.0f : texelWidths[surface.triangles.size()];
            uvec3& triangle = surface.triangles.emplace_back();
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = part.indices[i + std::size_t(k)];
                triangle[k] = width == 1.0f ? weldedVertex[v] : weld(part.positions[v], width);
            }
        }
    }
    measureTriangles(surface);
    findNeighbors(surface, portions);
    return surface;
}

} // namespace halflight::charts
