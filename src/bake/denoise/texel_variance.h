// The calibration of a texel's variance by second differences. C++ and GLSL 4.60 compile this file
// (halflight/shading/language.h). Field is a type with a member `grid` (surface_walk.h), and these functions:
//   bool isValid(Field, uint texel)               outside geometry
//   NoisyLight statedLight(Field, uint texel)     gathered light as the estimates state it
//   SecondDifference differenceAt(Field, uint texel)  what secondDifference() gave for the texel
#ifndef HALFLIGHT_BAKE_TEXEL_VARIANCE_H
#define HALFLIGHT_BAKE_TEXEL_VARIANCE_H

#include "bake/seams/surface_walk.h"

#include "halflight/shading/denoise.h"

HL_NAMESPACE_BEGIN

HL_FN SecondDifference differenceOf(float measured, float expected)
{
    SecondDifference difference;
    difference.measured = measured;
    difference.expected = expected;
    return difference;
}

// Over 3 × 3 texels. 0 where one is missing on the chart: texels beyond seams lie off the grid.
HL_FN_OF(Field) SecondDifference secondDifference(HL_IN(Field) field, uint texel)
{
    float difference = 0.0f;
    float variance = 0.0f;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            uint j = texelOnChart(field.grid, texel, ivec2(dx, dy));
            if (j == kNowhere || !isValid(field, j)) return differenceOf(0.0f, 0.0f);
            float weight = secondDifferenceWeight(dx, dy);
            NoisyLight light = statedLight(field, j);
            difference += weight * luminanceOf(light.irradiance);
            variance += weight * weight * light.variance;
        }
    }
    return differenceOf(difference * difference, variance);
}

// A factor, at most 1, by which the variance of a texel's gathered light is scaled before filtering. Estimates derive
// their variance from half blocks of samples as if these were independent. Half blocks are stratified together, so the
// stated variance is too large, by a factor that grows with the number of blocks.
HL_FN_OF(Field) float varianceScaleAt(HL_IN(Field) field, uint texel)
{
    const int kRadius = 3; // texels: 49 differences, a standard error of 20 % of their mean square
    SecondDifference sums = differenceOf(0.0f, 0.0f);
    float count = 0.0f;
    for (int dy = -kRadius; dy <= kRadius; ++dy) {
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
            uint j = texelOnChart(field.grid, texel, ivec2(dx, dy));
            if (j == kNowhere) continue;
            SecondDifference difference = differenceAt(field, j);
            sums.measured += difference.measured;
            sums.expected += difference.expected;
            count += difference.expected > 0.0f ? 1.0f : 0.0f;
        }
    }
    return varianceScale(sums, count);
}

HL_NAMESPACE_END

#endif
