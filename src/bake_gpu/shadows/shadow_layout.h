// Structures of shadow rays that C++ and shaders share. C++ copies its own structures of the same layout: their names
// follow in brackets.
#ifndef HALFLIGHT_BAKE_GPU_SHADOW_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_SHADOW_LAYOUT_H

#include "bake_gpu/layout.h"
#include "halflight/shading/light_rays.h"

HL_NAMESPACE_BEGIN

HL_CONST uint kShadowHalf = 8u; // rays of a half-batch

// [DeviceShadows::Item]
struct GpuShadowItem {
    uint texel;
    uint halfBatch;
    uint pointsAndSource; // 16 bits each
};
// [LitSum]
struct GpuLitSum {
    float lit;
    float all;
    uint range; // least and most: a byte each
};
HL_CONST uint kLitByte = 254u;

struct GpuShadowSource {
    uint firstLight; // among the numbers of the sources' lights
    uint lightCount;
    uint lit;
    uint seed;
};

HL_NAMESPACE_END

#endif
