// Rays of paths: RayKernels' verbs for one ray. Hits of the first kind of rays find the nearest surface, those of the
// second kind what passes.
#ifndef HALFLIGHT_BAKE_PATH_RAYS_GLSL
#define HALFLIGHT_BAKE_PATH_RAYS_GLSL

#include "../nearest.glsl"

layout(location = 1) rayPayloadEXT ThroughPayload through;

uint traced = 0u; // rays

// As nearest.rgen and then fronts.rgen.
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
    return hit;
}

// `state`: kMultiplies, or kStopsByChance as RayKernels::occluded() does.
float transmittance(vec3 origin, vec3 direction, float tMax, uint state)
{
    ++traced;
    through.depth = 0u;
    through.state = state;
    traceRayEXT(accelerationStructureEXT(push.scene.tree),
                gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT, 0xff, 1, 0, 1, origin, 0.0,
                direction, min(tMax, kLongestRay), 1);
    return through.state == kPassed ? exp2(-float(through.depth) / 65536.0) : 0.0;
}

#endif
