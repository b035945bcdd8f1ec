// Structures of the radiosity passes that C++ and shaders share. C++ copies its own structures of the same layout:
// their names follow in brackets.
#ifndef HALFLIGHT_BAKE_GPU_RADIOSITY_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_RADIOSITY_LAYOUT_H

#include "bake_gpu/layout.h"
#include "halflight/shading/lobe_moments.h"

HL_NAMESPACE_BEGIN

// PassKind.
HL_CONST uint kFrontsPass = 0u;
HL_CONST uint kElementsPass = 1u;
HL_CONST uint kBacksPass = 2u;
HL_CONST uint kBackElementsPass = 3u;
HL_CONST uint kTrianglesPass = 4u;

// PatchState, a byte each.
HL_CONST uint kOccludedState = 1u;
HL_CONST uint kHitState = 2u;
HL_CONST uint kTexelWideState = 4u;

// [RimPoint]
struct GpuRimPoint {
    int point;
    float toBorder;
};
// What all items of a pass share.
struct GpuRadiosityPass {
    uint kind;
    uint seed;
    uint patchCount; // without elements
    uint rangeItems;
    int blocks; // of form-factor rays
    int strata; // of each of them
    int direct; // light samples
    uint parts; // DeviceRadiosity::partsOf()
    float lineLift;
    GpuRimPoint rim[7];
};

// An item of a pass.
struct GpuRadiosityItem {
    uint face;  // of a triangle: its side
    uint id;    // the same: seed of its random numbers
    uint group; // FormFactorEffort::groupOf()
};
// The sample points of an item. Unused ones have no source.
struct GpuPatchItem {
    uint id;
    uint pointCount; // 0: nothing starts there
    uint whole;      // a texel that is wholly covered
    uint group;      // of the item
};
struct GpuPatchPoint {
    vec3 position;
    vec3 normal;
    vec3 geometricNormal;
    vec2 barycentric;
    uint face;
    uint source; // patch or element; kNone
};
HL_CONST uint kPatchPoints = 16u; // of an item

// [DeviceRadiosity::FactorRay, DirectSample]
struct GpuFactorRay {
    uint source;
    uint target;
    vec3 gathered;
};
HL_CONST uint kFactorNear = 0x80000000u; // DeviceRadiosity::kNearBit, kLeaves, kOpen
HL_CONST uint kFactorLeaves = 0x20000000u;
HL_CONST uint kFactorOpen = 0x20000001u;
struct GpuDirectSample {
    uint source;
    float minDistance;
    vec3 irradiance;
    vec3 albedo;
    LobeSums lobes;
};

// [DeviceRadiosity::LightPart]
struct GpuLightPart {
    uint component;
    vec3 irradiance;
    vec3 exitance;
    float sampledExitance;
    vec3 sampledMoment;
};

HL_CONST uint kOccluderTargets = 8u; // OccluderSearch::kTargets

HL_NAMESPACE_END

#endif
