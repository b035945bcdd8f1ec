#version 460
#extension GL_GOOGLE_include_directive : require
#define HALFLIGHT_OPEN_RANGE
#include "sums.glsl"

layout(local_size_x = 64) in;

// Adds the light of the open rays whose paths a launch has traced. The first launch begins the sums.
void main()
{
    uint place;
    uint block;
    uint component;
    if (!sumsOf(place, block, component)) return;
    beginSums();
    if (push.first > 0u) halves = push.lists.componentSums.at[place].at;
    for (int s = 0; s < kPatternBlock; ++s) {
        uint ray = rayOf(block, s);
        uint lit = push.lists.rayLights.at[ray].lit;
        uint path = lit & ~kOpenRay;
        if (lit < kOpenRay || path < push.first || path >= push.end) continue;
        vec3 radiance = push.lists.pathLights.at[(path - push.first) * push.tables.all.components + component];
        addToSums(s, radiance * kShadingPi, push.lists.rays.at[ray].direction);
    }
    push.lists.componentSums.at[place].at = halves;
}
