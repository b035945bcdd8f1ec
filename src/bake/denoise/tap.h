// What a level of the denoiser's filter reads at a tap: the values of a texel, or beyond a seam the bilinear mean of
// those around a place. C++ and GLSL 4.60 compile this file (halflight/shading/language.h). Level is a type with
// members `grid` (surface_walk.h) and `number`, and these functions (setPlace() and setLight() read their part of a tap
// alone):
//   bool isValid(Level, uint texel)  outside geometry
//   Tap tapOn(Level, uint texel)
#ifndef HALFLIGHT_BAKE_TAP_H
#define HALFLIGHT_BAKE_TAP_H

#include "bake/seams/surface_walk.h"

#include "halflight/shading/denoise.h"

HL_NAMESPACE_BEGIN

// Texels of a footprint that are outside geometry, with weights that add up to 1; none where they have too little of
// it: their mean would be that of other places.
HL_FN_OF(Level) Footprint validPart(HL_IN(Level) level, Footprint footprint)
{
    const float kEnough = 0.5f; // of a footprint's weight
    Footprint part;
    part.count = 0u;
    float weight = 0.0f;
    for (uint n = 0u; n < footprint.count; ++n) {
        if (isValid(level, footprint.texels[n])) weight += footprint.weights[n];
    }
    if (weight < kEnough) return part;
    for (uint n = 0u; n < footprint.count; ++n) {
        if (!isValid(level, footprint.texels[n])) continue;
        part.texels[part.count] = footprint.texels[n];
        part.weights[part.count++] = footprint.weights[n] / weight;
    }
    return part;
}

// Sets a tap to the mean place of a part. Nearest texels would lie up to 0.7 texels off, towards the light on one side
// of a seam and away from it on the other.
HL_FN_OF(Level) void setPlace(HL_IN(Level) level, Footprint part, HL_INOUT(Tap) tap)
{
    for (uint n = 0u; n < part.count; ++n) {
        Tap one = tapOn(level, part.texels[n]);
        tap.position += part.weights[n] * one.position;
        tap.normal += part.weights[n] * one.normal;
    }
    tap.valid = length(tap.normal) > 0.0f;
    if (tap.valid) tap.normal = normalize(tap.normal);
}

// Sets a tap to the mean light of a part.
HL_FN_OF(Level) void setLight(HL_IN(Level) level, Footprint part, HL_INOUT(Tap) tap)
{
    for (uint n = 0u; n < part.count; ++n) {
        float w = part.weights[n];
        float ofVariance = level.number == 0 ? w * w : w; // values of later levels share texels
        Tap one = tapOn(level, part.texels[n]);
        tap.gathered.irradiance += w * one.gathered.irradiance;
        tap.gathered.variance += ofVariance * one.gathered.variance;
        tap.direct.irradiance += w * one.direct.irradiance;
        tap.direct.variance += ofVariance * one.direct.variance;
        tap.moment += w * one.moment;
    }
}

// The texels of a tap beyond the texel's own chart.
HL_FN_OF(Level) Footprint partBeyond(HL_IN(Level) level, uint texel, ivec2 offset)
{
    return validPart(level, footprintBeyond(level.grid, texel, offset));
}

// The tap at an offset in texels.
HL_FN_OF(Level) Tap tapAt(HL_IN(Level) level, uint texel, ivec2 offset)
{
    uint other = texelOnChart(level.grid, texel, offset);
    if (other != kNowhere) return tapOn(level, other);
    Footprint part = partBeyond(level, texel, offset);
    Tap tap = noTap();
    setPlace(level, part, tap);
    if (tap.valid) setLight(level, part, tap);
    return tap;
}

HL_NAMESPACE_END

#endif
