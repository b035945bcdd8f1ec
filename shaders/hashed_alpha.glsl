// Blended surfaces in shadow maps: a texel is covered where the surface's alpha is above the texel's threshold (Wyman and
// McGuire 2017, "Hashed Alpha Testing"). Thresholds are spread evenly instead of hashed, which leaves a third of the noise
// after the shadow filter.
#ifndef HALFLIGHT_HASHED_ALPHA_GLSL
#define HALFLIGHT_HASHED_ALPHA_GLSL

#include "render/scene/gpu_layout.h"

const int kAlphaLayers = 8;

// Threshold in (0, 1) of a texel. Each layer has a lattice of its own of kAlphaPeriod levels, found by search: through any
// two layers light passes as through two independent ones. Two surfaces of one layer cover the same texels.
float alphaThreshold(ivec2 texel, int layer)
{
    const ivec2 steps[kAlphaLayers] = ivec2[kAlphaLayers](ivec2(7, 15), ivec2(15, 23), ivec2(19, 27), ivec2(25, 11),
                                                          ivec2(12, 27), ivec2(24, 21), ivec2(9, 17), ivec2(15, 7));
    int level = (texel.x * steps[layer].x + texel.y * steps[layer].y) & (kAlphaPeriod - 1);
    // Within a level thresholds vary from place to place, so that each alpha has its mean (Jimenez 2014, as in pixelNoise()).
    float within = fract(52.9829189 * fract(dot(vec2(texel & (kAlphaPeriod - 1)), vec2(0.06711056, 0.00583715))));
    return (float(level) + clamp(within, 0.01, 0.99)) / float(kAlphaPeriod);
}

#endif
