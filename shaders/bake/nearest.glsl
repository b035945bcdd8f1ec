// Nearest hits, for shaders that make rays. They have the scene among their push constants.
#ifndef HALFLIGHT_BAKE_NEAREST_GLSL
#define HALFLIGHT_BAKE_NEAREST_GLSL

#include "payloads.glsl"

layout(location = 0) rayPayloadEXT NearestPayload payload;

// Sets `payload`; its distance is below 0 where nothing is hit.
void traceNearest(GpuRay ray)
{
    payload.face = kAllFaces;
    payload.distance = -1.0;
    traceRayEXT(accelerationStructureEXT(push.scene.tree), gl_RayFlagsNoneEXT, 0xff, 0, 0, 0, ray.origin, ray.tMin,
                ray.direction, min(ray.tMax, kLongestRay), 0);
}

// Sets `payload` to what is hit beside a hidden back, at `distance` along the ray, but for hidden backs. Where two
// surfaces lie back to back, a front is preferred to a hidden back: rounding would decide.
void traceFrontBeside(GpuRay ray, float distance)
{
    float near = distance * 1.0e-6 + rayEpsilon(ray.origin + ray.direction * distance, push.scene.scale);
    payload.face = kNoHiddenBacks;
    payload.distance = -1.0;
    traceRayEXT(accelerationStructureEXT(push.scene.tree), gl_RayFlagsNoOpaqueEXT, 0xff, 0, 0, 0, ray.origin,
                max(distance - near, 0.0), ray.direction, distance + near, 0);
}

GpuHit noHit()
{
    GpuHit hit;
    hit.face = 0u;
    hit.barycentric = vec2(0.0);
    hit.distance = uintBitsToFloat(0x7f800000u);
    hit.tint = vec3(1.0);
    return hit;
}
// Takes the payload's hit, if it has one.
void takeHit(inout GpuHit hit)
{
    if (payload.distance < 0.0) return;
    hit.face = payload.face;
    hit.barycentric = payload.barycentric;
    hit.distance = payload.distance;
}

// In place of a hidden back the front beside it, if there is one.
void preferFront(GpuRay ray, inout GpuHit hit)
{
    if ((hit.face & kHiddenBit) == 0u) return;
    hit.face &= ~kHiddenBit;
    traceFrontBeside(ray, hit.distance);
    takeHit(hit);
}

#endif
