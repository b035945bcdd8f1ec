#pragma once

#include "halflight/bake/integrator.h"

#include <array>
#include <cstdint>

namespace halflight {

/// Makes surface points of one triangle.
class TriangleFrame {
public:
    TriangleFrame(const BakeGeometry& geometry, uint32_t triangle)
        : triangle_(triangle), geometricNormal_(geometry.geometricNormal(triangle)),
          positions_(geometry.cornersOf(triangle)), normals_(geometry.normalsOf(triangle))
    {
        flat_ = normals_[0] == normals_[1] && normals_[0] == normals_[2];
        if (flat_) normals_[0] = shadingNormal(normals_[0]);
    }
    /// Writes the point at barycentric weights (of vertices 1 and 2) to `p`. An output parameter avoids
    /// store-forwarding stalls of copies.
    void put(vec2 barycentric, SurfacePoint& p) const
    {
        const float w = 1.0f - barycentric.x - barycentric.y;
        p.triangle = triangle_;
        p.barycentric = barycentric;
        p.position = w * positions_[0] + barycentric.x * positions_[1] + barycentric.y * positions_[2];
        p.geometricNormal = geometricNormal_;
        p.normal = flat_ ? normals_[0]
                         : shadingNormal(w * normals_[0] + barycentric.x * normals_[1] + barycentric.y * normals_[2]);
    }

private:
    /// The normalized sum; the geometric normal where the sum points to the back. (Smooth normals on coarse meshes, and
    /// files whose normals contradict the winding, would put the hemisphere inside the surface.)
    [[nodiscard]] vec3 shadingNormal(vec3 sum) const
    {
        const float length = glm::length(sum);
        const vec3 normal = length > 0.0f ? sum * (1.0f / length) : geometricNormal_;
        return glm::dot(normal, geometricNormal_) > 0.0f ? normal : geometricNormal_;
    }

    uint32_t triangle_;
    vec3 geometricNormal_;
    std::array<vec3, 3> positions_;
    std::array<vec3, 3> normals_;
    bool flat_; ///< all points have the normal normals_[0]
};

} // namespace halflight
