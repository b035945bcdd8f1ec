#pragma once
// Connected components of triangles, and which of them are closed.

#include "halflight/bake/bake_geometry.h"

#include <span>
#include <vector>

namespace halflight {

/// A closed surface: a connected component of triangles.
struct Component {
    std::vector<uint32_t> triangles;
    Bounds bounds;
};
struct Components {
    std::vector<Component> solids; ///< facing outward
    std::vector<Component> inward; ///< facing inward: rooms, cavities of solids, or inverted surfaces
    /// A component, closed or open: one of its triangles, and its bounds.
    struct Any {
        uint32_t triangle = 0;
        Bounds bounds;
    };
    std::vector<Any> all;
};

/// The listed triangles in pieces, connected across edges whatever their winding.
std::vector<std::vector<uint32_t>> connectedPieces(const BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// The connected components of the listed triangles.
Components componentsOf(const BakeGeometry& geometry, std::span<const uint32_t> triangles);

} // namespace halflight
