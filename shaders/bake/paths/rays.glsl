// Rays of paths: RayKernels' verbs for one ray. Hits of the first kind of rays find the nearest surface, those of the
// second kind what passes.
#ifndef HALFLIGHT_BAKE_PATH_RAYS_GLSL
#define HALFLIGHT_BAKE_PATH_RAYS_GLSL

#include "../nearest.glsl"

#include "../through.glsl"

uint traced = 0u; // rays

// As nearest.rgen, then fronts.rgen, then tints.rgen.
GpuHit nearestHit(vec3 origin, vec3 direction)
{
    ++traced;
    GpuRay ray;
    ray.origin = origin;
    ray.tMin = 0.0;
    ray.direction = direction;
    ray.tMax = kLongestRay;
    GpuHit hit = noHit();
    traceNearest(ray);
    takeHit(hit);
    preferFront(ray, hit);
#ifdef HALFLIGHT_TINTED
    hit.tint = tintOf(ray, hit);
#endif
    return hit;
}

void countAndTrace(vec3 origin, vec3 direction, float tMax, uint state)
{
    ++traced;
    GpuRay ray;
    ray.origin = origin;
    ray.tMin = 0.0;
    ray.direction = direction;
    ray.tMax = tMax;
    traceThrough(ray, state);
}
// RayKernels::occluded().
bool isOccluded(vec3 origin, vec3 direction, float tMax)
{
    countAndTrace(origin, direction, tMax, kStopsByChance);
    return through.state != kPassed;
}
Passed transmittance(vec3 origin, vec3 direction, float tMax)
{
    countAndTrace(origin, direction, tMax, kMultiplies);
    return passedBy();
}

#endif
