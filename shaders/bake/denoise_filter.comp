#version 460
#extension GL_GOOGLE_include_directive : require
#include "denoise_taps.glsl"

NoisyLight filteredDirect(float correlation)
{
    NoisyLight own = lightOf(directOf[kMiddleTap]);
    if (!(own.variance > 0.0)) return own;
    TapComparison to = comparisonWith(directOf[kMiddleTap], flatTrend(), 0.0);
    TapSums sums = kNoSums;
    for (int k = 0; k < kTaps; ++k)
        add(sums, nearnessOf[k] * falloff(plane2Of[k] + distanceOf(to, directOf[k], k)), directOf[k], k);
    return meanOfTaps(own, sums.weight, sums.variance, sums.light, correlation);
}

// With the weights of gathered light; where there is direct light, directions stop at its edges too.
vec3 filteredMoment(TapComparison toGathered)
{
    bool hasDirect = push.hasDirect != 0u;
    TapComparison to = toGathered;
    if (hasDirect) {
        float tolerance = kMomentTolerance * luminanceOf(directOf[kMiddleTap].xyz);
        to = comparisonWith(directOf[kMiddleTap], flatTrend(), tolerance);
    }
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int k = 0; k < kTaps; ++k) {
        float weight = gatheredWeight(toGathered, k);
        if (hasDirect) weight *= falloff(distanceOf(to, directOf[k], k));
        weights += weight;
        sum += weight * momentOf[k];
    }
    return weights > kLeastWeight ? sum / weights : momentOf[kMiddleTap];
}

// One level of the filter, as filterTexel() in denoise.cpp.
void main()
{
    field = push.data.field;
    uint texel = texelOfInvocation();
    if (texel >= field.count || !isValid(field, texel)) return;
    readTaps(Level(field.grid, push.number), texel);
    float correlation = correlationOf(push.number);
    Trend trend = trendOfTaps(push.number);
    TapComparison to = comparisonWith(gatheredOf[kMiddleTap], trend, 0.0);
    TapSums sums = kNoSums;
    for (int k = 0; k < kTaps; ++k) add(sums, gatheredWeight(to, k), gatheredOf[k], k);
    vec3 light = sums.light - sumOfTrend(trend, sums.terms);
    push.gatheredOut.at[texel] = stored(
        meanOfTaps(lightOf(gatheredOf[kMiddleTap]), sums.weight, sums.variance, light, correlation * trend.noise));
    if (push.hasDirect != 0u) push.directOut.at[texel] = stored(filteredDirect(correlation));
    if (push.directions != 0u) push.momentsOut.at[texel] = filteredMoment(to);
}
