#pragma once
// The triangles of one mesh, welded by position and measured in world units: what charts are cut from.

#include "halflight/scene/scene.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight::charts {

using dvec2 = glm::dvec2;
using dvec3 = glm::dvec3;
using dmat3 = glm::dmat3;

inline constexpr uint32_t kNone = ~0u;

/// All parts of a mesh as one triangle list. Triangles keep their order (part by part), degenerate ones included: those
/// have area 0, a zero normal and no neighbours.
struct Surface {
    std::vector<dvec3> positions; ///< welded vertices, world scale
    std::vector<uvec3> triangles; ///< indices into positions
    std::vector<dvec3> normals;   ///< unit
    std::vector<double> areas;    ///< square metres of the world, times the square of lightmapScale
    std::vector<uint32_t>
        neighbors; ///< 3 * triangle + edge (edge k runs from corner k to k + 1): a half edge, or kNone

    [[nodiscard]] std::size_t triangleCount() const { return triangles.size(); }
    [[nodiscard]] bool degenerate(std::size_t triangle) const { return areas[triangle] <= 0.0; }
    [[nodiscard]] dvec3 corner(std::size_t triangle, int k) const { return positions[triangles[triangle][k]]; }
    [[nodiscard]] dvec3 centroid(std::size_t triangle) const
    {
        return (corner(triangle, 0) + corner(triangle, 1) + corner(triangle, 2)) / 3.0;
    }
};

/// `worldFromObject` is the linear part only: it gives areas and lengths their world size, and may mirror or flatten.
/// `portions`: a number for each triangle, or nothing; triangles of different numbers are no neighbours.
/// `texelWidths`: by triangle, or nothing: a triangle is so many times smaller, as it gets fewer texels; triangles of
/// different widths are of different portions.
Surface buildSurface(const Mesh& mesh, const dmat3& worldFromObject, std::span<const uint32_t> portions = {},
                     std::span<const float> texelWidths = {});

} // namespace halflight::charts
