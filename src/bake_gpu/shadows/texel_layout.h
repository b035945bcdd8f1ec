// Structures of a lightmap's texels that C++ and shaders share.
#ifndef HALFLIGHT_BAKE_GPU_TEXEL_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_TEXEL_LAYOUT_H

#include "bake_gpu/layout.h"

HL_NAMESPACE_BEGIN

struct GpuMapTexel {
    uint id;            // texelId()
    uint place;         // column and row on the page: 16 bits each
    uint firstFragment; // index into a list of fragments
    uint fragmentCount;
    uint validPoints; // a bit for each
};
struct GpuFragment {
    uint triangle; // stored
    uint instance; // kNone: stored in world space
    uint flags;    // TexelSide, kReceivesShadows
    uint hitIndex; // kNone: rays do not hit it, or no shader asks
    vec2 barycentric;
    float area;
};
HL_CONST uint kTexelSideBits = 3u;
HL_CONST uint kFrontOfBoth = 1u; // of TexelSide
HL_CONST uint kMeanTexel = 2u;
HL_CONST uint kReceivesShadows = 4u;

HL_NAMESPACE_END

#endif
