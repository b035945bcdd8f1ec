#pragma once
// Directions of rays that gather light at a surface.

#include "halflight/bake/integrator.h"
#include "halflight/shading/sampling.h"

#include <algorithm>

namespace halflight {

/// A gather direction about the point's normal: cosine-distributed, reflected out of the surface if below it.
inline vec3 gatherDirection(const SurfacePoint& point, vec2 u)
{
    vec3 tangent;
    vec3 bitangent;
    shading::orthonormalBasis(point.normal, tangent, bitangent);
    const vec3 local = shading::sampleCosineHemisphere(u);
    vec3 direction = local.x * tangent + local.y * bitangent + local.z * point.normal;
    // Hemispheres about interpolated normals reach below the triangle; such directions are reflected out of it.
    const float side = glm::dot(direction, point.geometricNormal);
    if (side < 0.0f) direction -= 2.0f * side * point.geometricNormal;
    return direction;
}

/// Its density per steradian; above 0 for reflected directions too.
inline float gatherPdf(vec3 normal, vec3 direction)
{
    return std::max(glm::dot(normal, direction), 1.0e-4f) / kPi;
}

} // namespace halflight
