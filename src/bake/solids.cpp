#include "bake/stages.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

namespace halflight {
namespace {

/// An edge of a triangle between welded vertices, directed as the triangle winds.
struct DirectedEdge {
    uint32_t low = 0;
    uint32_t high = 0;
    uint32_t triangle = 0;
    bool forward = false; ///< from low to high
};

uint32_t find(std::vector<uint32_t>& parent, uint32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/// For each vertex of the range, the first vertex of the range at exactly the same place.
std::vector<uint32_t> weld(const BakeGeometry& geometry, uint32_t first, uint32_t count)
{
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    const auto at = [&](uint32_t i) { return geometry.positions[first + i]; };
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        const vec3 p = at(a);
        const vec3 q = at(b);
        return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
    });
    std::vector<uint32_t> welded(count);
    for (uint32_t i = 0; i < count; ++i) {
        welded[order[i]] = i > 0 && at(order[i]) == at(order[i - 1]) ? welded[order[i - 1]] : order[i];
    }
    return welded;
}

/// Marks the closed pieces among one object's triangles.
void markObject(const BakeGeometry& geometry, std::span<const BakeGeometry::Part> parts, std::vector<uint8_t>& solid)
{
    const uint32_t firstVertex = parts.front().firstVertex;
    const uint32_t firstTriangle = parts.front().firstTriangle;
    const uint32_t vertexCount = parts.back().firstVertex + parts.back().vertexCount - firstVertex;
    const uint32_t triangleCount = parts.back().firstTriangle + parts.back().triangleCount - firstTriangle;
    const std::vector<uint32_t> welded = weld(geometry, firstVertex, vertexCount);

    std::vector<DirectedEdge> edges;
    edges.reserve(std::size_t(triangleCount) * 3);
    for (uint32_t t = 0; t < triangleCount; ++t) {
        const uvec3 v = geometry.triangles[firstTriangle + t];
        const std::array<uint32_t, 3> w = {welded[v.x - firstVertex], welded[v.y - firstVertex],
                                           welded[v.z - firstVertex]};
        if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue; // collapsed: encloses nothing
        for (int e = 0; e < 3; ++e) {
            const uint32_t a = w[std::size_t(e)];
            const uint32_t b = w[std::size_t((e + 1) % 3)];
            edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });

    // Pieces hang together across edges; a piece is open as soon as one of its edges does not join exactly one triangle
    // of each direction.
    std::vector<uint32_t> parent(triangleCount);
    std::iota(parent.begin(), parent.end(), 0u);
    std::vector<uint32_t> openTriangles;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t j = i;
        int balance = 0;
        for (; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high; ++j) {
            balance += edges[j].forward ? 1 : -1;
            const uint32_t a = find(parent, edges[i].triangle);
            const uint32_t b = find(parent, edges[j].triangle);
            if (a != b) parent[std::max(a, b)] = std::min(a, b);
        }
        if (j - i != 2 || balance != 0) openTriangles.push_back(edges[i].triangle);
        i = j;
    }
    std::vector<uint8_t> open(triangleCount, 0);
    for (const uint32_t t : openTriangles) open[find(parent, t)] = 1;

    // Outward or inward: the sign of the enclosed volume.
    std::vector<double> volume(triangleCount, 0.0);
    const vec3 reference = geometry.positions[firstVertex];
    for (uint32_t t = 0; t < triangleCount; ++t) {
        const uvec3 v = geometry.triangles[firstTriangle + t];
        volume[find(parent, t)] +=
            double(glm::dot(geometry.positions[v.x] - reference,
                            glm::cross(geometry.positions[v.y] - reference, geometry.positions[v.z] - reference)));
    }
    for (uint32_t t = 0; t < triangleCount; ++t) {
        const uint32_t piece = find(parent, t);
        solid[firstTriangle + t] = !open[piece] && volume[piece] > 0.0 ? 1 : 0;
    }
}

} // namespace

std::vector<uint8_t> markSolids(const BakeGeometry& geometry)
{
    std::vector<uint8_t> solid(geometry.triangles.size(), 0);
    std::vector<std::span<const BakeGeometry::Part>> objects;
    for (std::size_t i = 0; i < geometry.parts.size();) {
        std::size_t j = i;
        while (j < geometry.parts.size() && geometry.parts[j].object == geometry.parts[i].object) ++j;
        objects.emplace_back(geometry.parts.data() + i, j - i);
        i = j;
    }
    parallelFor(objects.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t o = begin; o < end; ++o) {
            const auto& parts = objects[o];
            if (parts.back().firstVertex + parts.back().vertexCount > parts.front().firstVertex)
                markObject(geometry, parts, solid);
        }
    });
    return solid;
}

} // namespace halflight
