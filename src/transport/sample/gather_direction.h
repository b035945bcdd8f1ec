#pragma once
// Directions of rays that gather light at a surface.

#include "halflight/bake/integrator.h"
#include "halflight/shading/gather.h"

namespace halflight {

/// A gather direction about the point's normal: cosine-distributed, reflected out of the surface if below it.
inline vec3 gatherDirection(const SurfacePoint& point, vec2 u)
{
    vec3 tangent;
    vec3 bitangent;
    shading::orthonormalBasis(point.normal, tangent, bitangent);
    const vec3 local = shading::sampleCosineHemisphere(u);
    const vec3 direction = local.x * tangent + local.y * bitangent + local.z * point.normal;
    return shading::outOfSurface(direction, point.geometricNormal);
}

/// Its density per steradian; above 0 for reflected directions too.
inline float gatherPdf(vec3 normal, vec3 direction)
{
    return shading::gatherDirectionPdf(normal, direction);
}

} // namespace halflight
