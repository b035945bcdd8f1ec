// Rays of paths: RayKernels' verbs for one ray. Hits of the first kind of rays find the nearest surface, those of the
// second kind what passes.
#ifndef HALFLIGHT_BAKE_PATH_RAYS_GLSL
#define HALFLIGHT_BAKE_PATH_RAYS_GLSL

#include "../payloads.glsl"

layout(location = 0) rayPayloadEXT NearestPayload nearest;
layout(location = 1) rayPayloadEXT ThroughPayload through;

uint traced = 0u; // rays

void traceNearest(vec3 origin, float tMin, vec3 direction, float tMax, uint faces, uint flags)
{
    nearest.face = faces;
    nearest.distance = -1.0;
    traceRayEXT(accelerationStructureEXT(push.scene.tree), flags, 0xff, 0, 0, 0, origin, tMin, direction, tMax, 0);
}

// As nearest.rgen and then fronts.rgen.
GpuHit nearestHit(vec3 origin, vec3 direction)
{
    ++traced;
    GpuHit hit;
    hit.face = 0u;
    hit.barycentric = vec2(0.0);
    hit.distance = uintBitsToFloat(0x7f800000u);
    hit.tint = vec3(1.0);
    traceNearest(origin, 0.0, direction, kLongestRay, kAllFaces, gl_RayFlagsNoneEXT);
    if (nearest.distance < 0.0) return hit;
    hit.face = nearest.face & ~kHiddenBit;
    hit.barycentric = nearest.barycentric;
    hit.distance = nearest.distance;
    if ((nearest.face & kHiddenBit) == 0u) return hit;
    float near = hit.distance * 1.0e-6 + rayEpsilon(origin + direction * hit.distance, push.scene.scale);
    traceNearest(origin, max(hit.distance - near, 0.0), direction, hit.distance + near, kNoHiddenBacks,
                 gl_RayFlagsNoOpaqueEXT);
    if (nearest.distance < 0.0) return hit;
    hit.face = nearest.face;
    hit.barycentric = nearest.barycentric;
    hit.distance = nearest.distance;
    return hit;
}

// `state`: kMultiplies, or kStopsByChance as RayKernels::occluded() does.
float transmittance(vec3 origin, vec3 direction, float tMin, float tMax, uint state)
{
    ++traced;
    through.depth = 0u;
    through.state = state;
    traceRayEXT(accelerationStructureEXT(push.scene.tree),
                gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT, 0xff, 1, 0, 1, origin, tMin,
                direction, min(tMax, kLongestRay), 1);
    return through.state == kPassed ? exp2(-float(through.depth) / 65536.0) : 0.0;
}

#endif
