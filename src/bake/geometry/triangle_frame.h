#pragma once

#include "halflight/bake/integrator.h"
#include "halflight/shading/rays.h"

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
        if (flat_) normals_[0] = shading::shadingNormalOf(normals_[0], geometricNormal_);
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
        p.normal =
            flat_ ? normals_[0]
                  : shading::shadingNormalOf(
                        w * normals_[0] + barycentric.x * normals_[1] + barycentric.y * normals_[2], geometricNormal_);
    }

private:
    [[nodiscard]] vec3 shadingNormal(vec3 sum) const { return shading::shadingNormalOf(sum, geometricNormal_); }

    uint32_t triangle_;
    vec3 geometricNormal_;
    std::array<vec3, 3> positions_;
    std::array<vec3, 3> normals_;
    bool flat_; ///< all points have the normal normals_[0]
};

} // namespace halflight
