// Shadow rays: what their shaders have in common. Rays are numbered by chunks of half-batches.
#ifndef HALFLIGHT_BAKE_SHADOWS_GLSL
#define HALFLIGHT_BAKE_SHADOWS_GLSL

#include "invocation.glsl"
#include "mathematics.glsl"
#include "texels.glsl"

#include "bake_gpu/shadows/shadow_layout.h"
#include "halflight/shading/gather.h"
#include "halflight/shading/pattern.h"
#include "halflight/shading/sobol.h"

layout(buffer_reference, scalar) buffer Lights { LightSource at[]; };
layout(buffer_reference, scalar) buffer Items { GpuShadowItem at[]; };
layout(buffer_reference, scalar) buffer Sources { GpuShadowSource at[]; };
layout(buffer_reference, scalar) buffer LitSums { GpuLitSum at[]; };

// GpuShadows::Tables: what all shadow rays read.
layout(buffer_reference, scalar) buffer Tables
{
    SurfaceData surfaces;
    Lights lights;
    Words firstBatches; // ShadowGroup::firstBatch()
    Pairs radii;        // of StratifiedPattern
    Pairs angles;
    uint firstBatchCount;
    float sceneScale; // for rayEpsilon()
    uint tinted; // glass has a colour
};

// GpuShadows::Lists: what one call works on.
layout(buffer_reference, scalar) buffer Lists
{
    MapTexels texels;
    Fragments fragments;
    Items items;
    Sources sources;
    Words numbers; // of the sources' lights
    Rays rays;
    Floats passed;  // transmittance of rays: Vectors where glass has a colour
    Floats weights; // of rays; 0: none
    LitSums sums;
    Vectors colors; // sums of weight times transmittance, where glass has a colour
    Words counts; // of rays
    uint itemCount;
};

layout(push_constant, scalar) uniform Push
{
    Tables tables;
    Lists lists;
} push;

TexelData map = TexelData(push.tables.surfaces, push.lists.texels, push.lists.fragments);

// The half-batch of a ray, and the ray's number in it. False beyond the list.
bool shadowRay(uint ray, out uint item, out uint number)
{
    item = itemOfRay(ray, kShadowHalf);
    number = numberInItem(ray, kShadowHalf);
    return item < push.lists.itemCount;
}
uint rayOf(uint item, uint number)
{
    return rayOfItem(item, number, kShadowHalf);
}
uint rayCount()
{
    return raysOfChunks(push.lists.itemCount, kShadowHalf);
}

// StratifiedPattern::disc().
vec2 discPoint(uint texelHash, uint number)
{
    uvec2 bits = scrambledSobol(number, texelHash);
    uint shift = 32u - uint(kPatternAngleBits);
    return push.tables.radii.at[bits.x >> shift].x * push.tables.angles.at[bits.y >> shift];
}

// The first light of a source that reaches a point, kNone if none does.
uint lightAt(GpuShadowSource source, vec3 position)
{
    for (uint i = 0u; i < source.lightCount; ++i) {
        uint number = push.lists.numbers.at[source.firstLight + i];
        if (lightReaches(push.tables.lights.at[number], position)) return number;
    }
    return kNone;
}

// A ray's target: a light of its source.
struct ShadowTarget
{
    TexelPoint point; // on the side that faces the light
    uint light;       // kNone: no ray
    vec2 disc;
    float weight;
};

// ShadowSource::facing() and targetOf(), for a ray of a half-batch.
ShadowTarget shadowTarget(uint item, uint number)
{
    GpuShadowItem i = push.lists.items.at[item];
    GpuShadowSource source = push.lists.sources.at[i.pointsAndSource >> 16u];
    GpuMapTexel texel = map.texels.at[i.texel];
    uint mask = i.pointsAndSource & 0xffffu;
    int batch = 0;
    if (mask == 0xffffu)
        batch = int(push.tables.firstBatches.at[hashPcg(texel.id) % push.tables.firstBatchCount] + i.halfBatch / 2u);
    uint ray = i.halfBatch * kShadowHalf + number;
    ShadowTarget target;
    int pointCount;
    target.point = texelPoint(map, texel, batch, mask, int(ray), pointCount);
    target.disc = discPoint(hashCombine(source.seed, texel.id), ray);
    target.weight = 0.0;
    vec3 position = target.point.position;
    // Light is that of both sides in mean texels alone; masks are of the side that faces the light.
    target.light = source.lit != 0u ? push.lists.numbers.at[source.firstLight] : lightAt(source, position);
    uint side = target.point.fragment.flags & kTexelSideBits;
    if (target.light != kNone && (side == kMeanTexel || (source.lit == 0u && side != 0u))) {
        LightSource light = push.tables.lights.at[target.light];
        vec3 towards = light.type == kLightDirectional ? -light.axis : light.position - position;
        if (dot(target.point.geometricNormal, towards) < 0.0) {
            target.point.geometricNormal = -target.point.geometricNormal;
            target.point.normal = -target.point.normal;
        }
    }
    if (source.lit == 0u) {
        if (target.light != kNone)
            target.weight = maskRayWeight(push.tables.lights.at[target.light], position, target.point.normal,
                                          target.disc);
    } else {
        for (uint l = 0u; l < source.lightCount && target.weight <= 0.0; ++l) {
            target.light = push.lists.numbers.at[source.firstLight + l];
            target.weight = irradianceRayWeight(push.tables.lights.at[target.light], position,
                                                target.point.normal, target.disc);
        }
    }
    if (!(target.weight > 0.0)) target.light = kNone;
    return target;
}

// DirectLight::shadowsFall().
bool shadowsFall(ShadowTarget target)
{
    return target.light != kNone && push.tables.lights.at[target.light].castShadows != 0u &&
           (target.point.fragment.flags & kReceivesShadows) != 0u;
}

float epsilonAt(vec3 position)
{
    return rayEpsilon(position, push.tables.sceneScale);
}

// smoothOrigin() in transport/sample/direct_light.cpp.
vec3 smoothOriginOf(TexelPoint p)
{
    uvec3 c = cornersOf(map.surfaces, p.fragment.triangle, p.fragment.instance);
    vec3 front = worldNormal(map.surfaces, p.fragment.instance, map.surfaces.frames.at[p.fragment.triangle].normal);
    vec3 weights = vec3(1.0 - p.barycentric.x - p.barycentric.y, p.barycentric);
    return pointOnCurvedSurface(p.position, weights, positionOf(map.surfaces, p.fragment.instance, c.x),
                                positionOf(map.surfaces, p.fragment.instance, c.y), positionOf(map.surfaces, p.fragment.instance, c.z),
                                normalOf(map.surfaces, p.fragment.instance, c.x),
                                normalOf(map.surfaces, p.fragment.instance, c.y),
                                normalOf(map.surfaces, p.fragment.instance, c.z), p.geometricNormal,
                                dot(front, p.geometricNormal) < 0.0);
}

// Both origins that a shadow ray may have: on the triangle, and on the curved surface.
void shadowOrigins(TexelPoint p, out vec3 onTriangle, out vec3 raised)
{
    vec3 offset = p.geometricNormal * epsilonAt(p.position);
    onTriangle = p.position + offset;
    raised = smoothOriginOf(p) + offset;
}
bool isLifted(TexelPoint p, vec3 onTriangle, vec3 raised)
{
    return distance(onTriangle, raised) > kLeastLift * epsilonAt(p.position);
}

#endif
