#pragma once
// Rays, and what they hit.

#include "halflight/base/math.h"

#include <cstdint>
#include <limits>

namespace halflight {

/// One side of a triangle that rays can hit.
struct FaceId {
    uint32_t hitIndex : 31 = 0; ///< as RayScene::hitIndex()
    uint32_t back : 1 = 0;
};
static_assert(sizeof(FaceId) == 4);

/// A ray, in metres. One whose tMax is below its tMin meets nothing, and is not traced.
struct Ray {
    vec3 origin{0.0f};
    float tMin = 0.0f;
    vec3 direction{0.0f}; ///< tMin and tMax count in its length; nearest() and transmittance() need a unit vector
    float tMax = -1.0f;

    [[nodiscard]] bool meetsNothing() const { return !(tMax >= tMin); }
};
static_assert(sizeof(Ray) == 32);

/// The nearest surface along a ray, without its properties, and what the glass before it does to light.
struct RayHit {
    FaceId face;
    vec2 barycentric{0.0f};                                  ///< weights of vertices 1 and 2 of the triangle
    float distance = std::numeric_limits<float>::infinity(); ///< infinite: nothing was hit
    vec3 tint{1.0f};                                         ///< see RayKernels::nearest()

    [[nodiscard]] bool found() const { return distance < std::numeric_limits<float>::infinity(); }
};
static_assert(sizeof(RayHit) == 28);

} // namespace halflight
