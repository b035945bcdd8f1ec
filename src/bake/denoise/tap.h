// What a level of the denoiser's filter reads at a tap: the values of a texel, or beyond a seam the bilinear mean of
// those around a place. C++ and GLSL 4.60 compile this file (halflight/shading/language.h). Level is a type with
// members `grid` (surface_walk.h) and `number`, and these functions:
//   bool isValid(Level, uint texel)  outside geometry
//   Tap tapOn(Level, uint texel)
#ifndef HALFLIGHT_BAKE_TAP_H
#define HALFLIGHT_BAKE_TAP_H

#include "bake/seams/surface_walk.h"

#include "halflight/shading/denoise.h"

HL_NAMESPACE_BEGIN

// Nearest texels would lie up to 0.7 texels off, towards the light on one side of a seam and away from it on the other.
HL_FN_OF(Level) Tap tapBeyond(HL_IN(Level) level, Footprint footprint)
{
    const float kEnough = 0.5f; // of a footprint's weight; with less, its mean is that of other places
    Tap sum = noTap();
    float weight = 0.0f;
    for (uint n = 0u; n < footprint.count; ++n) {
        if (isValid(level, footprint.texels[n])) weight += footprint.weights[n];
    }
    if (weight < kEnough) return sum;
    for (uint n = 0u; n < footprint.count; ++n) {
        if (!isValid(level, footprint.texels[n])) continue;
        float w = footprint.weights[n] / weight;
        float ofVariance = level.number == 0 ? w * w : w; // values of later levels share texels
        Tap tap = tapOn(level, footprint.texels[n]);
        sum.position += w * tap.position;
        sum.normal += w * tap.normal;
        sum.gathered.irradiance += w * tap.gathered.irradiance;
        sum.gathered.variance += ofVariance * tap.gathered.variance;
        sum.direct.irradiance += w * tap.direct.irradiance;
        sum.direct.variance += ofVariance * tap.direct.variance;
        sum.moment += w * tap.moment;
    }
    sum.valid = length(sum.normal) > 0.0f;
    if (sum.valid) sum.normal = normalize(sum.normal);
    return sum;
}

// The tap at an offset in texels.
HL_FN_OF(Level) Tap tapAt(HL_IN(Level) level, uint texel, ivec2 offset)
{
    uint other = texelOnChart(level.grid, texel, offset);
    if (other != kNowhere) return tapOn(level, other);
    return tapBeyond(level, footprintBeyond(level.grid, texel, offset));
}

HL_NAMESPACE_END

#endif
