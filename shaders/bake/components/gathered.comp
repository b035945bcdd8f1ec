#version 460
#extension GL_GOOGLE_include_directive : require
#include "sums.glsl"

layout(local_size_x = 64) in;

// FinalGather::addComponents() for one ray.
vec3 gatheredLight(uint ray, vec3 direction, uint component)
{
    GpuHit hit = push.lists.hits.at[ray];
    vec3 scale = hit.tint * kShadingPi;
    if (isinf(hit.distance)) return skyOfComponent(component, direction) * scale;
    GpuRayLight light = push.lists.rayLights.at[ray];
    if (light.lit >= kOpenRay) return vec3(0.0); // of a path
    return componentAlong(light.lit, component, direction) * (light.weight * scale);
}

// Adds the light of gather rays but for their paths (paths.comp), and of samples of secondary sources.
void main()
{
    uint place;
    uint block;
    uint component;
    if (!sumsOf(place, block, component)) return;
    halves = push.lists.componentSums.at[place].at;
    for (int s = 0; s < kPatternBlock; ++s) {
        uint ray = rayOf(block, s);
        vec3 direction = push.lists.rays.at[ray].direction;
        addToSums(s, gatheredLight(ray, direction, component), direction);
        if (paths().all.emitterNodes == 0u) continue;
        GpuEmitterHit hit = push.lists.emitterHits.at[ray];
        if (hit.component == component) addToSums(s, hit.irradiance, direction);
    }
    bool sources = push.lists.texels.at[push.lists.blocks.at[block].texel].sources > 0u;
    for (int s = 0; s < kPatternBlock && sources; ++s) {
        uint i = rayOf(block, s);
        GpuRay ray = push.lists.sourceRays.at[i];
        if (ray.tMax < ray.tMin) continue;
        GpuRayLight light = push.lists.sourceLights.at[i];
        addToSums(s, componentAlong(light.lit, component, ray.direction) * (light.weight * passedOf(i)),
                  ray.direction);
    }
    push.lists.componentSums.at[place].at = halves;
}
