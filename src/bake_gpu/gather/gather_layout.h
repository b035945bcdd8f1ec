// Structures of the final gather that C++ and shaders share. C++ copies its own structures of the same layout: their
// names follow in brackets.
#ifndef HALFLIGHT_BAKE_GPU_GATHER_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_GATHER_LAYOUT_H

#include "bake_gpu/layout.h"

HL_NAMESPACE_BEGIN

// [DeviceGather::Texel, Block]
struct GpuGatherRequest {
    uint texel; // number of the map
    uint firstBlock;
    uint blockCount;
    vec3 gathered; // sum over the half-blocks before these blocks
    uint halfBlocks;
};
struct GpuGatherTexel {
    uint id;
    uint firstPoint;
    uint pointCount; // 1 ... kPatternBlock
    uint guide;      // kNone: none
    uint sources;    // samples of secondary sources of a block
};
// A sample point, from which rays start.
struct GpuPoint {
    vec3 position;
    vec3 normal;
    vec3 geometricNormal;
};
struct GpuBlock {
    uint texel;
    uint number;
};
// [DeviceGather::Half, Halves, Sums]
struct GpuHalf {
    vec3 irradiance;
    vec3 moment;
};
struct GpuHalves {
    GpuHalf at[2];
};
struct GpuSums {
    GpuHalf halves[2];
    float inverseSquares;
};
// Light by component (spec S33). What a gather ray, or a sample of a source, has of the light of its patch or path.
struct GpuRayLight {
    uint lit;     // patch or element; kNone; kOpenRay and the number of its path; of a sample of emission the component
    float weight; // of the radiance
};
HL_CONST uint kOpenRay = 0x80000000u;
// What a gather ray brings of the emitter that it hits.
struct GpuEmitterHit {
    uint component;
    vec3 irradiance; // zero: it hits none
};

// A ray that goes on as a path.
struct GpuOpen {
    uint block;
    uint stratum;
    uint face;
    vec2 barycentric;
    float distance;
    vec3 direction;
};
// Counters of a call.
HL_CONST uint kRayCount = 0u; // of sources, paths and emitters
HL_CONST uint kCounters = 1u;

// A node of a texel's cut through the tree of emitters (LightTree::Cut).
struct GpuCutNode {
    uint node;
    float probability;
};
// How a block samples emitters and the sky.
struct GpuEmitterShare {
    float survival; // of the roulette: share of the strata
    float sky;      // of the samples, the sky's share
};

// [PatchLayout::Surface, PatchRadiance]
struct GpuSurface {
    vec2 origin;
    vec2 edgeU;
    vec2 edgeV;
    uint patches; // first one, kHasPatches, kEmissive
    uint size;    // width, height: 16 bits each
};
HL_CONST uint kFirstPatchBits = 0x1fffffffu;
HL_CONST uint kHasPatches = 0x20000000u;
HL_CONST uint kEmissive = 0x40000000u;
struct GpuPatch {
    vec3 radiance;
    float minDistance;
    vec3 tilt;
};
// [ComponentRadiance]
struct GpuComponentLight {
    vec3 radiance;
    vec3 tilt;
};
// Of PatchLayout::Elements.
HL_CONST uint kFirstElementBits = 0x3fffffffu;
HL_CONST uint kHalfTexelElements = 0x40000000u;
HL_CONST uint kSplit = 0x80000000u;

// [Guide, Guides::Entry, SourceClusters::Cluster, SourceTriangle, AliasBin, Member]
struct GpuSourceGuide {
    uint localFirst;
    uint localCount;
    uint sharedFirst;
    uint sharedCount;
    float relativeVariance;
};
struct GpuEntry {
    uint cluster;
    float probability;
};
struct GpuCluster {
    uint firstTriangle;
    uint triangleCount;
};
struct GpuSourceTriangle {
    uint face;
    uint patchId;
    vec2 corners[3]; // barycentric
    vec3 origin;
    vec3 edge1;
    vec3 edge2;
    vec3 normal;
    float pdfArea; // given the cluster
};
struct GpuAliasBin {
    float share;
    uint aliasOffset;
};
struct GpuMember {
    uint cluster;
    float pdfArea;
};

HL_CONST uint kSky = 1u;        // not black
HL_CONST uint kSkyPicture = 2u; // a picture, not a gradient
HL_CONST uint kSkySplit = 4u;   // a gradient whose colours are of several components
// Numbers that all rays of a map share.
struct GpuGatherConstants {
    uint seed;
    uint sourceSeed;
    uint emitterSeed;
    uint rouletteSeed;
    uint chartPatches; // PatchLayout::chartPatches
    int patchShift;
    uint memberCount;
    uint guidedPatches; // patches that may have a guide
    uint sky;
    vec3 zenith; // or 1 / limit in x, for a picture
    vec3 horizon;
    vec3 ground;
    ivec2 pictureSize;
    vec2 turn;
    float limit;
    uint components;         // 0: light is estimated as one
    uint skyComponents[3];   // of zenith, horizon and ground
    uint emittingComponents; // a bit each: SceneLight::emittingComponents()
};

HL_NAMESPACE_END

#endif
