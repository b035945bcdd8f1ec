// The radiosity passes: patches, and the sample points of items. PatchPass. Shaders that trace include paths/rays.glsl
// first, and define HALFLIGHT_TRACES.
#ifndef HALFLIGHT_BAKE_RADIOSITY_GLSL
#define HALFLIGHT_BAKE_RADIOSITY_GLSL

#include "../paths/surface.glsl"

#include "bake_gpu/radiosity/radiosity_layout.h"
#include "halflight/shading/form_factors.h"

layout(buffer_reference, scalar) buffer RadiosityItems { GpuRadiosityItem at[]; };
layout(buffer_reference, scalar) buffer PatchItems { GpuPatchItem at[]; };
layout(buffer_reference, scalar) buffer PatchPoints { GpuPatchPoint at[]; };
layout(buffer_reference, scalar) buffer FactorRays { GpuFactorRay at[]; };
layout(buffer_reference, scalar) buffer DirectSamples { GpuDirectSample at[]; };
layout(buffer_reference, scalar) buffer LightParts { GpuLightPart at[]; };

// RadiosityLists of src/bake_gpu/radiosity/radiosity.cpp: a pass, and what one call works on, in the place of the
// gather's lists.
layout(buffer_reference, scalar) buffer RadiosityLists
{
    uvec2 mapTexels; // texels.glsl
    uvec2 fragments;
    RadiosityItems requests;
    PatchItems items;
    PatchPoints points; // kPatchPoints of each item
    Words states;       // bytes by patch and element
    Words elements;     // by patch
    Floats widths;      // by hit index: of a texel, or of a triangle patch, in metres
    FactorRays rays;
    Vectors tints;      // of rays, where glass has a colour
    DirectSamples direct;
    Words found;  // a bit for each patch and element that an occluder crosses
    Words counts; // of rays
    Words emitters;   // by ray: component of the emitter that it hits
    LightParts parts; // by light sample
    uint itemCount;
    GpuRadiosityPass pass;
};

RadiosityLists work()
{
    return RadiosityLists(uvec2(push.lists));
}

bool hasState(uint patchId, uint state)
{
    return (byteAt(work().states, patchId) & state) != 0u;
}

// Element at a point that no occluder crosses; kNone.
uint openElementAt(GpuSurface surface, vec2 at, uint patchId)
{
    uint element = elementAt(surface, at, work().elements.at[patchId]);
    return element == kNone || hasState(element, kOccludedState) ? kNone : element;
}

// PatchPass::sourceOf(); kNone.
uint sourceAt(uint face, vec2 barycentric)
{
    GpuSurface surface = push.tables.surfaces.at[face & ~kBackBit];
    if ((surface.patches & kHasPatches) == 0u) return kNone;
    vec2 at = placeInPatches(surface, barycentric);
    uint patchId = patchAt(surface, (face & kBackBit) != 0u, at);
    uint kind = work().pass.kind;
    bool occluded = hasState(patchId, kOccludedState);
    if (kind == kElementsPass || kind == kBackElementsPass || (kind == kFrontsPass && occluded))
        return openElementAt(surface, at, patchId);
    if (kind == kFrontsPass) return patchId;
    return hasState(patchId, kHitState) && !occluded ? patchId : kNone;
}

// PatchPass::targetOf(); kNone.
uint targetAt(uint face, vec2 barycentric)
{
    GpuSurface surface = push.tables.surfaces.at[face & ~kBackBit];
    if ((surface.patches & kHasPatches) == 0u) return kNone;
    vec2 at = placeInPatches(surface, barycentric);
    uint patchId = patchAt(surface, (face & kBackBit) != 0u, at);
    if (hasState(patchId, kOccludedState)) return openElementAt(surface, at, patchId);
    bool filled = patchId < push.tables.all.chartPatches || work().pass.kind == kFrontsPass ||
                  hasState(patchId, kHitState);
    return filled ? patchId : kNone;
}

// Patches::widthOf().
float widthOf(uint patchId, uint face)
{
    float meters = work().widths.at[face & ~kBackBit];
    bool isElement = patchId >= work().pass.patchCount;
    if (patchId >= 2u * push.tables.all.chartPatches && !isElement) return meters;
    float texels = float(1 << push.tables.all.patchShift);
    if (isElement) texels = hasState(patchId, kTexelWideState) ? 1.0 : 0.5;
    return texels * meters;
}

GpuPatchPoint patchPoint(uint item, uint number)
{
    return work().points.at[item * kPatchPoints + number];
}

#endif
