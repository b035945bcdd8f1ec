// Structures that the baker's C++ and its shaders share. Shaders lay them out as scalars: a vec3 has 12 bytes.
#ifndef HALFLIGHT_BAKE_GPU_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_LAYOUT_H

#include "halflight/shading/language.h"

HL_NAMESPACE_BEGIN

#ifdef __cplusplus
using halflight::ivec2;
using halflight::vec2;
using halflight::vec3;
#endif

HL_CONST uint kGroupSize = 64u; // invocations of a compute shader's group
HL_CONST uint kNone = 0xffffffffu;

// Some items have the same number of rays each. Rays of a chunk of items are numbered by their number in the item
// first, so that neighbouring rays start from neighbouring texels in similar directions. A launch has whole chunks.
HL_CONST uint kItemsOfChunk = 32u;
HL_FN uint raysOfChunks(uint items, uint raysOfItem)
{
    return (items + kItemsOfChunk - 1u) / kItemsOfChunk * kItemsOfChunk * raysOfItem;
}
HL_FN uint itemOfRay(uint ray, uint raysOfItem)
{
    return ray / (kItemsOfChunk * raysOfItem) * kItemsOfChunk + ray % kItemsOfChunk;
}
HL_FN uint numberInItem(uint ray, uint raysOfItem)
{
    return ray % (kItemsOfChunk * raysOfItem) / kItemsOfChunk;
}
HL_FN uint rayOfItem(uint item, uint number, uint raysOfItem)
{
    return item / kItemsOfChunk * kItemsOfChunk * raysOfItem + number * kItemsOfChunk + item % kItemsOfChunk;
}

// A ray, and what it hits: Ray and RayHit of src/transport.
struct GpuRay {
    vec3 origin;
    float tMin;
    vec3 direction;
    float tMax; // below tMin: not traced
};
struct GpuHit {
    uint face; // hit index, and kBackBit
    vec2 barycentric;
    float distance; // infinite: nothing was hit
    vec3 tint;
};
HL_CONST uint kBackBit = 0x80000000u;
HL_CONST uint kHiddenBit = 0x40000000u; // of a hit on its way through the shaders: the back is hidden

// One geometry of one instance in the tree.
struct GpuSlot {
    uint firstHit;      // hit index of its first triangle
    uint firstTriangle; // added to the numbers of masked triangles
    uint firstFace;     // of its first triangle among the faces of all trees
    uint firstMasked;   // the same among masked triangles; kNone: its triangles are opaque
    uint mirrored;      // barycentric weights change places
};
// A byte of each face.
HL_CONST uint kFaceSolid = 1u;
HL_CONST uint kFaceHiddenBack = 2u;

// One channel of a picture, a byte a texel.
struct GpuBytes {
    ivec2 size;
    int wrapU;
    int wrapV;
    uint nearest;
    uint first; // byte among those of all pictures
};
// A texture that a material reads.
struct GpuTextureUse {
    int picture; // -1: none
    uint set;    // 0 or 1: which coordinates of GpuMaskedTriangle
    vec2 offset;
    vec2 scale;
    vec2 turn;
};
// What decides how much of a ray a surface stops.
struct GpuMask {
    float opacity;
    float cutoff;
    uint blended;    // its alpha is a share, not a cutoff
    uint multiplied; // light that passes is multiplied: blended, or glass
    float glass;     // kGlassTransmittance x transmission
    float metallic;
    uint tint; // number of a GpuGlass; kNone: light that passes keeps its colour
    GpuTextureUse alpha;
    GpuTextureUse metallicTexture;
    GpuTextureUse transmissionTexture;
};
// What gives light that passes a colour.
struct GpuGlass {
    vec3 base;                    // linear
    vec3 attenuation;             // of the volume behind the surface, in 1/m
    float thickness;              // where the surface is of no solid, in the mesh's space
    uint tinted;                  // what alpha leaves open takes the base colour too
    GpuTextureUse baseTexture[3]; // by channel
    GpuTextureUse thicknessTexture;
};
// Of a masked triangle whose mask has a tint. Normals are in the space in which it is stored.
struct GpuGlassTriangle {
    vec3 colors[3]; // of the vertices
    vec3 normal;
    float scale; // metres of thickness: length of the transpose of world from object times the normal; 1 in instances
};
struct GpuMaskedTriangle {
    uint triangle; // from GpuSlot::firstTriangle on
    uint mask;
    vec3 alpha; // of the vertices' colours
    vec2 uv[6]; // corners 0 to 2 of set 0, then of set 1
};

// BakeGeometry::Instance.
struct GpuInstance {
    vec3 linear[3]; // columns
    vec3 origin;
    vec3 worldFromNormal[3];
    vec2 texelScale;
    vec2 texelOffset;
    uint mirrored;
};
// [BakeGeometry::Frame]
struct GpuTriangleFrame {
    vec3 normal;
    float texelMeters;
};

HL_NAMESPACE_END

#endif
