// Rays that surfaces let through, of the second kind in pipelines that also find hits. Shaders include nearest.glsl
// before.
#ifndef HALFLIGHT_BAKE_THROUGH_GLSL
#define HALFLIGHT_BAKE_THROUGH_GLSL

#include "payloads.glsl"

layout(location = 1) rayPayloadEXT ThroughPayload through;

// Light that passes: by colour where glass has one.
#ifdef HALFLIGHT_TINTED
#define Passed vec3
#else
#define Passed float
#endif

// Sets `through`. `state`: kMultiplies, or kStopsByChance as RayKernels::occluded() does.
void traceThrough(GpuRay ray, uint state)
{
    through.depth = 0u;
    through.state = state;
#ifdef HALFLIGHT_TINTED
    through.glass = noGlass(ray.tMax);
#endif
    traceRayEXT(accelerationStructureEXT(push.scene.tree),
                gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT, 0xff, 1, 0, 1, ray.origin,
                ray.tMin, ray.direction, min(ray.tMax, kLongestRay), 1);
}

Passed passedBy()
{
    float passed = through.state == kPassed ? exp2(-float(through.depth) / 65536.0) : 0.0;
#ifdef HALFLIGHT_TINTED
    return passed > 0.0 ? passed * leftBy(through.glass) : vec3(0.0);
#else
    return passed;
#endif
}

#ifdef HALFLIGHT_TINTED
// RayHit::tint of a hit that preferFront() has found.
vec3 tintOf(GpuRay ray, GpuHit hit)
{
    through.state = kTints;
    through.glass = noGlass(min(hit.distance, ray.tMax));
    traceRayEXT(accelerationStructureEXT(push.scene.tree),
                gl_RayFlagsCullOpaqueEXT | gl_RayFlagsSkipClosestHitShaderEXT, 0xff, 1, 0, 1, ray.origin, ray.tMin,
                ray.direction, min(through.glass.end, kLongestRay), 1);
    return leftBy(through.glass);
}
#endif

#endif
