#pragma once
// Surfaces between sample points, found without rays.

#include "transport/texels/texel_points.h"
#include "transport/trace/ray_tracer.h"

#include <vector>

namespace halflight {

/// A box whose axes are those of a frame, not of the world.
struct OrientedBox {
    mat3 worldFromBox{1.0f}; ///< columns: its axes, unit
    Bounds bounds;           ///< in these axes

    void extend(vec3 point) { bounds.extend(point * worldFromBox); } // v * M: the transposed matrix, its inverse
};

/// An empty box, one of whose axes is a unit normal.
OrientedBox boxAlong(vec3 normal);

/// The triangles near some points, for tests whether points are mutually visible.
class NearTriangles {
public:
    /// Triangles near `box`, which all boxes of later tests are within.
    NearTriangles(const RayTracer& tracer, const OrientedBox& box);

    /// Whether no shadow caster reaches into a box, so that points in it are mutually visible. False too where too
    /// many triangles are near to test them.
    [[nodiscard]] bool isEmpty(const OrientedBox& box) const;

private:
    const BakeGeometry& geometry_;
    std::vector<uint32_t> triangles_;
    bool known_ = false;
};

} // namespace halflight
