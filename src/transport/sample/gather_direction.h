#pragma once
// Directions of rays that gather light at a surface.

#include "halflight/bake/integrator.h"
#include "halflight/shading/gather.h"

namespace halflight {

/// A gather direction about the point's normal: cosine-distributed, reflected out of the surface if below it.
inline vec3 gatherDirection(const SurfacePoint& point, vec2 u)
{
    return shading::gatherDirection(point.normal, point.geometricNormal, u);
}

/// Its density per steradian; above 0 for reflected directions too.
inline float gatherPdf(vec3 normal, vec3 direction)
{
    return shading::gatherDirectionPdf(normal, direction);
}

} // namespace halflight
