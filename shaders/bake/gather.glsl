// The final gather: what its shaders have in common. Rays are numbered by chunks of blocks, in which a ray's number is
// its stratum.
#ifndef HALFLIGHT_BAKE_GATHER_GLSL
#define HALFLIGHT_BAKE_GATHER_GLSL

#include "scene.glsl"
#ifndef HALFLIGHT_TRACES
#include "invocation.glsl"
#endif

#include "bake_gpu/gather/gather_layout.h"
#include "halflight/shading/luminance.h"
#include "halflight/shading/gather.h"
#include "halflight/shading/patches.h"
#include "halflight/shading/pattern.h"

layout(buffer_reference, scalar) buffer Requests { GpuGatherRequest at[]; };
layout(buffer_reference, scalar) buffer Texels { GpuGatherTexel at[]; };
layout(buffer_reference, scalar) buffer Points { GpuPoint at[]; };
layout(buffer_reference, scalar) buffer Blocks { GpuBlock at[]; };
layout(buffer_reference, scalar) buffer SumsList { GpuSums at[]; };
layout(buffer_reference, scalar) buffer OpenList { GpuOpen at[]; };
layout(buffer_reference, scalar) buffer CutNodes { GpuCutNode at[]; };
layout(buffer_reference, scalar) buffer EmitterShares { GpuEmitterShare at[]; };
layout(buffer_reference, scalar) buffer HalvesList { GpuHalves at[]; };
layout(buffer_reference, scalar) buffer Surfaces { GpuSurface at[]; };
layout(buffer_reference, scalar) buffer Patches { GpuPatch at[]; };
layout(buffer_reference, scalar) buffer ComponentLights { GpuComponentLight at[]; };
layout(buffer_reference, scalar) buffer RayLights { GpuRayLight at[]; };
layout(buffer_reference, scalar) buffer EmitterHits { GpuEmitterHit at[]; };
layout(buffer_reference, scalar) buffer Guides { GpuSourceGuide at[]; };
layout(buffer_reference, scalar) buffer Entries { GpuEntry at[]; };
layout(buffer_reference, scalar) buffer Clusters { GpuCluster at[]; };
layout(buffer_reference, scalar) buffer SourceTriangles { GpuSourceTriangle at[]; };
layout(buffer_reference, scalar) buffer AliasBins { GpuAliasBin at[]; };
layout(buffer_reference, scalar) buffer Members { GpuMember at[]; };

// GpuGather::Tables: what a map's gather reads.
layout(buffer_reference, scalar) buffer Tables
{
    SceneData scene;
    Words pattern; // points of StratifiedPattern, and its tables
    Pairs radii;
    Pairs angles;
    Surfaces surfaces;
    Vectors normals; // by hit index
    Words elements;
    Patches patches;
    Words guideOfPatch;
    Words sourcesOfGuide; // samples of a block
    Guides guides;
    Entries entries;
    Floats cumulative;
    Clusters clusters;
    SourceTriangles triangles;
    Words sourceMasks; // by source triangle: its masked triangle, or kNone
    AliasBins bins;
    Members members;
    Vectors picture; // of the sky
    ComponentLights components; // of patches and elements: by patch, then by component
    uvec2 paths;     // paths/tables.glsl
    GpuGatherConstants all;
};

// GpuGather::Lists: what one call works on.
layout(buffer_reference, scalar) buffer Lists
{
    uvec2 mapTexels;    // texels.glsl; by request, as the next three
    uvec2 fragments;
    Requests requests;
    Texels texels;
    Points points;      // 16 for each texel
    Blocks blocks;
    Rays rays;
    Hits hits;
    Vectors gathered;   // irradiance along each gather ray
    Rays sourceRays;    // to secondary sources; then to emitters and the sky
    Vectors sources;    // irradiance without shadows
    Floats passed;      // transmittance of source rays: Vectors where glass has a colour
    SumsList sums;      // by block, of gather rays and secondary sources
    OpenList open;      // rays that go on as paths: each group of 64 rays has its own first in its place
    Words openBefore;   // by group of rays: how many of it are open; for paths.rgen, how many of all groups before
    CutNodes cuts;      // by node of a cut, then by texel
    Floats cutTotals;   // by texel, LightTree::Cut::total
    EmitterShares shares; // by block
    HalvesList emitted; // by block, of emitters and the sky
    Words counts;       // k…Count
    Vectors gatheredBefore; // light by component, from here on: by texel, as GpuGatherRequest::gathered
    RayLights rayLights; // by gather ray
    RayLights sourceLights; // by source ray
    EmitterHits emitterHits; // by gather ray
    Vectors pathLights; // radiance, by path of a launch
    HalvesList componentSums; // by block, of gather rays and secondary sources
    HalvesList componentEmitted; // by block, of emitters and the sky
    uint blockCount;
    uint texelCount;    // and of requests
};

// HALFLIGHT_TRACES: the shader is of a pipeline that traces rays. All of its shaders have the scene first.
layout(push_constant, scalar) uniform Push
{
#ifdef HALFLIGHT_TRACES
    SceneData scene;
#endif
    Tables tables;
    Lists lists;
#ifdef HALFLIGHT_OPEN_RANGE
    uint first; // number of a launch's first path among all open rays
    uint end;
#endif
#ifdef HALFLIGHT_TRACES
    uint whole; // paths are whole, and the lists those of paths/starts.glsl
    uint first; // number of the launch's first path among all open rays
#endif
} push;

// The sample of a ray. False beyond the list of blocks.
bool sampleOf(uint ray, out uint block, out int stratum)
{
    block = itemOfRay(ray, uint(kPatternBlock));
    stratum = int(numberInItem(ray, uint(kPatternBlock)));
    return block < push.lists.blockCount;
}
uint rayCount()
{
    return raysOfChunks(push.lists.blockCount, uint(kPatternBlock));
}
uint rayOf(uint block, int stratum)
{
    return rayOfItem(block, uint(stratum), uint(kPatternBlock));
}

#ifndef HALFLIGHT_TRACES
uint invocation()
{
    return invocationOf(kGroupSize);
}
#endif

// A ray to where next-event estimation has chosen a point.
GpuRay rayTo(vec3 origin, NextEventContribution next)
{
    GpuRay ray;
    ray.origin = origin;
    ray.tMin = 0.0;
    ray.direction = next.direction;
    ray.tMax = next.distance * kShortOfSurface;
    return ray;
}

GpuPoint pointOf(GpuGatherTexel texel, uint block, int stratum)
{
    return push.lists.points.at[texel.firstPoint +
                                uint(gatherPointOf(texel.id, int(texel.pointCount), int(block), stratum))];
}

uint patternPoint(uint texelHash, uint block, int stratum)
{
    uint shuffle;
    uint first = patternBlockOf(texelHash, int(block), shuffle);
    return push.tables.pattern.at[first + (uint(stratum) ^ patternStratum(shuffle))] ^ shuffle;
}

// StratifiedPattern::direction() about a normal, out of the surface.
vec3 patternDirection(uint bits, vec3 normal, vec3 geometricNormal)
{
    vec2 r = push.tables.radii.at[(bits & 0xffffu) >> uint(16 - kPatternAngleBits)];
    vec2 a = push.tables.angles.at[bits >> uint(32 - kPatternAngleBits)];
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(normal, tangent, bitangent);
    return outOfSurface(r.x * a.x * tangent + r.x * a.y * bitangent + r.y * normal, geometricNormal);
}

vec2 placeInPatches(GpuSurface surface, vec2 barycentric)
{
    return surface.origin + barycentric.x * surface.edgeU + barycentric.y * surface.edgeV;
}

// PatchLayout::patchAt() and where the hit lies, in patches.
uint patchAt(GpuSurface surface, bool back, vec2 at)
{
    uint front = (surface.patches & kFirstPatchBits) +
                 patchNumberAt(at, int(surface.size & 0xffffu), int(surface.size >> 16u));
    if (!back) return front;
    return front + (front < push.tables.all.chartPatches ? push.tables.all.chartPatches : 1u);
}

// PatchLayout::elementShift().
int elementShiftOf(uint elements)
{
    return push.tables.all.patchShift + ((elements & kHalfTexelElements) != 0u ? 1 : 0);
}
// PatchLayout::elementAt(); `elements` are those of the patch. kNone: it has none.
uint elementAt(GpuSurface surface, vec2 at, uint elements)
{
    if ((elements & kSplit) == 0u) return kNone;
    int shift = elementShiftOf(elements);
    return (elements & kFirstElementBits) + (elementNumberAlong(at.y, int(surface.size >> 16u), shift) << shift) +
           elementNumberAlong(at.x, int(surface.size & 0xffffu), shift);
}

// RadianceCache::find(): number of the patch or element with the light at the end of a ray; kNone if the ray is too
// short.
uint litPatchAt(GpuSurface surface, vec2 at, uint patchId, float distance)
{
    if (distance >= push.tables.patches.at[patchId].minDistance) return patchId;
    uint element = elementAt(surface, at, push.tables.elements.at[patchId]);
    if (element == kNone) return kNone;
    return distance >= push.tables.patches.at[element].minDistance ? element : kNone;
}

// Guides::probability() of a list.
float probabilityIn(uint first, uint count, uint cluster)
{
    if (count == 0u) return 0.0;
    while (count > 1u) {
        uint middle = count / 2u;
        if (push.tables.entries.at[first + middle].cluster <= cluster) first += middle;
        count -= middle;
    }
    GpuEntry entry = push.tables.entries.at[first];
    return entry.cluster == cluster ? entry.probability : 0.0;
}

float sharedFraction(GpuSourceGuide guide)
{
    return guide.sharedCount == 0u ? 0.0 : guide.localCount == 0u ? 1.0 : 0.5;
}

float probabilityOf(GpuSourceGuide guide, uint cluster)
{
    float local = probabilityIn(guide.localFirst, guide.localCount, cluster);
    if (guide.sharedCount == 0u) return local;
    float fraction = sharedFraction(guide);
    return (1.0 - fraction) * local + fraction * probabilityIn(guide.sharedFirst, guide.sharedCount, cluster);
}

#endif
