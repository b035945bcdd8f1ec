#include "bake/geometry/components.h"

#include "bake/geometry/facet_orientation.h"
#include "bake/geometry/smooth_normals.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace halflight {
namespace {

/// An edge of a triangle between welded vertices, directed as the triangle winds.
struct DirectedEdge {
    uint32_t low = 0;
    uint32_t high = 0;
    uint32_t triangle = 0;
    bool forward = false; ///< from low to high
};

/// The corners of the listed triangles as indices of welded vertices: equal positions get equal indices.
std::vector<uvec3> weld(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    std::vector<uint32_t> corners(triangles.size() * 3); // 3 * index into `triangles` + corner
    std::iota(corners.begin(), corners.end(), 0u);
    std::vector<vec3> positions; // by corner
    positions.reserve(corners.size());
    for (const uint32_t t : triangles) {
        for (const vec3 corner : geometry.cornersOf(t)) positions.push_back(corner);
    }
    const auto at = [&](uint32_t c) { return positions[c]; };
    parallelSort(corners, [&](uint32_t a, uint32_t b) {
        const vec3 p = at(a);
        const vec3 q = at(b);
        return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
    });
    std::vector<uvec3> welded(triangles.size());
    uint32_t vertex = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (i > 0 && at(corners[i]) != at(corners[i - 1])) ++vertex;
        welded[corners[i] / 3][int(corners[i] % 3)] = vertex;
    }
    return welded;
}

bool isDegenerate(uvec3 welded)
{
    return welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0];
}

/// The edges of welded triangles but degenerate ones, sorted so that edges with equal ends are adjacent.
std::vector<DirectedEdge> edgesOf(std::span<const uvec3> welded)
{
    std::vector<DirectedEdge> edges;
    edges.reserve(welded.size() * 3);
    for (std::size_t t = 0; t < welded.size(); ++t) {
        const uvec3 w = welded[t];
        if (isDegenerate(w)) continue;
        for (int e = 0; e < 3; ++e) {
            const uint32_t a = w[e];
            const uint32_t b = w[(e + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), uint32_t(t), a < b});
        }
    }
    parallelSort(edges, [](const DirectedEdge& a, const DirectedEdge& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    return edges;
}

/// Calls body(edges) for each group of edges with equal ends.
template<typename Body> void forEdges(std::span<const DirectedEdge> edges, const Body& body)
{
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t j = i;
        while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
        body(edges.subspan(i, j - i));
        i = j;
    }
}

/// The listed triangles by their sets.
std::vector<std::vector<uint32_t>> piecesOf(DisjointSets& sets, std::span<const uint32_t> triangles)
{
    std::vector<std::vector<uint32_t>> pieces;
    std::vector<uint32_t> pieceOf(triangles.size());
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        const uint32_t root = sets.find(t);
        if (root == t) {
            pieceOf[t] = uint32_t(pieces.size());
            pieces.emplace_back();
        }
        pieces[pieceOf[root]].push_back(triangles[t]);
    }
    return pieces;
}

} // namespace

std::vector<std::vector<uint32_t>> connectedPieces(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    DisjointSets sets(triangles.size());
    const std::vector<DirectedEdge> edges = edgesOf(weld(geometry, triangles));
    forEdges(edges, [&](std::span<const DirectedEdge> same) {
        for (const DirectedEdge& edge : same) sets.join(same.front().triangle, edge.triangle);
    });
    return piecesOf(sets, triangles);
}

Components componentsOf(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    const std::vector<uvec3> welded = weld(geometry, triangles);
    const std::vector<DirectedEdge> edges = edgesOf(welded);

    // Components are connected across edges. A component is closed if each edge has as many triangles in one direction
    // as in the other. Degenerate triangles have no edges, and enclose nothing.
    DisjointSets sets(triangles.size());
    std::vector<uint32_t> openTriangles;
    for (uint32_t t = 0; t < welded.size(); ++t)
        if (isDegenerate(welded[t])) openTriangles.push_back(t);
    forEdges(edges, [&](std::span<const DirectedEdge> same) {
        int balance = 0;
        for (const DirectedEdge& edge : same) {
            balance += edge.forward ? 1 : -1;
            sets.join(same.front().triangle, edge.triangle);
        }
        if (balance != 0) openTriangles.push_back(same.front().triangle);
    });
    std::vector<uint8_t> open(triangles.size(), 0);
    for (const uint32_t t : openTriangles) open[sets.find(t)] = 1;

    // The sign of the enclosed volume is positive for outward-facing components.
    std::vector<double> volume(triangles.size(), 0.0);
    const vec3 reference = geometry.cornersOf(triangles[0])[0];
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const std::array<vec3, 3> v = geometry.cornersOf(triangles[t]);
        volume[sets.find(uint32_t(t))] +=
            double(glm::dot(v[0] - reference, glm::cross(v[1] - reference, v[2] - reference)));
    }
    Components components;
    std::vector<Component*> componentOf(triangles.size(), nullptr);
    std::vector<uint32_t> roots;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sets.find(uint32_t(t)) == t && !open[t] && volume[t] != 0.0) roots.push_back(uint32_t(t));
    }
    const auto outward = [&](uint32_t root) { return volume[root] > 0.0; };
    const auto count = std::size_t(std::count_if(roots.begin(), roots.end(), outward));
    components.solids.resize(count); // once: componentOf points into the list
    components.inward.resize(roots.size() - count);
    std::size_t nextSolid = 0;
    std::size_t nextInward = 0;
    for (const uint32_t root : roots)
        componentOf[root] = outward(root) ? &components.solids[nextSolid++] : &components.inward[nextInward++];
    std::vector<Bounds> bounds(triangles.size()); // by root
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const uint32_t root = sets.find(uint32_t(t));
        bounds[root].extend(geometry.boundsOf(triangles[t]));
        if (componentOf[root]) componentOf[root]->triangles.push_back(triangles[t]);
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (sets.find(uint32_t(t)) != t) continue;
        components.all.push_back({triangles[t], bounds[t]});
        if (componentOf[t]) componentOf[t]->bounds = bounds[t];
    }
    return components;
}

std::vector<std::vector<uint32_t>> facetPatches(const BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    if (triangles.empty()) return {};
    DisjointSets sets(triangles.size());
    const std::vector<DirectedEdge> edges = edgesOf(weld(geometry, triangles));
    forEdges(edges, [&](std::span<const DirectedEdge> same) {
        if (same.size() != 2 || same[0].forward == same[1].forward) return;
        const vec3 normal = geometry.geometricNormal(triangles[same[0].triangle]);
        if (glm::dot(normal, geometry.geometricNormal(triangles[same[1].triangle])) < kSameSideCosine) return;
        sets.join(same[0].triangle, same[1].triangle);
    });
    return piecesOf(sets, triangles);
}

} // namespace halflight
