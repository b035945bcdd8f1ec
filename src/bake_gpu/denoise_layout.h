// Structures that the denoiser's C++ and its shaders share. Shaders lay them out as scalars: a vec3 has 12 bytes.
#ifndef HALFLIGHT_BAKE_GPU_DENOISE_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_DENOISE_LAYOUT_H

#include "bake/seams/seam_crossing.h"

HL_NAMESPACE_BEGIN

HL_CONST uint kDenoiseGroup = 64u; // invocations of a group

// As TexelGrid::Cell.
struct GpuCell {
    uint texel;
    uint chart;
};

// A texel. Its bits: which of the 3 × 3 around it have crossings (9 of them), the flags below, its page.
struct GpuTexel {
    uint columnRow; // 16 bits each
    uint bits;
    uint chart;
};
HL_CONST uint kCrossingBits = 0x1ffu;
HL_CONST uint kHasSeams = 0x200u; // its chart has
HL_CONST uint kIsValid = 0x400u;
HL_CONST uint kIsWhole = 0x800u;
HL_CONST uint kHasFewSamples = 0x1000u; // fewer than prove that light is real
HL_CONST uint kPageShift = 13u;
HL_CONST uint kMostPages = 0x80000u;

// As TexelPlace.
struct GpuGuide {
    vec3 position;
    vec3 normal;
    float texelMeters;
};

HL_NAMESPACE_END

#endif
