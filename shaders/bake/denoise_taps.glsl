// The taps around an invocation's texel, and sums over them. Neighbourhood and detrendedOf() in src/bake/denoise/denoise.cpp
// do the same with taps side by side.
#ifndef HALFLIGHT_BAKE_DENOISE_TAPS_GLSL
#define HALFLIGHT_BAKE_DENOISE_TAPS_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "denoise.glsl"

Field field;

// What tap.h asks for.
struct Level {
    Grid grid;
    int number;
};

bool isValid(Level level, uint texel)
{
    return isValid(field, texel);
}
Tap tapOn(Level level, uint texel)
{
    Tap tap = noTap();
    GpuGuide guide = field.guides.at[texel];
    tap.valid = isValid(field, texel);
    tap.position = guide.position;
    tap.normal = guide.normal;
    tap.gathered = lightOf(push.gatheredIn.at[texel]);
    if (push.hasDirect != 0u) tap.direct = lightOf(push.directIn.at[texel]);
    if (push.directions != 0u) tap.moment = push.momentsIn.at[texel];
    return tap;
}
#include "bake/denoise/tap.h"

const uint kAllTaps = 0x1ffffffu;

// The taps around the invocation's texel: bits of them, and their values.
uint validTaps = 0u;
uint sameSideTaps = 0u;
vec4 gatheredOf[kTaps]; // NoisyLight
vec4 directOf[kTaps];
vec3 momentOf[kTaps];
float nearnessOf[kTaps];
float plane2Of[kTaps]; // squared distance from the middle's plane, in taps

void readTaps(Level level, uint texel)
{
    int spacing = 1 << level.number;
    GpuGuide own = field.guides.at[texel];
    float tapsPerMeter = 1.0 / (float(spacing) * own.texelMeters);
    [[dont_unroll]] for (int k = 0; k < kTaps; ++k) { // walks across seams are long
        Tap tap = tapAt(level, texel, ivec2(tapX(k), tapY(k)) * spacing);
        if (!tap.valid) tap = noTap();
        vec3 offset = tap.valid ? tap.position - own.position : vec3(0.0);
        float cosine = max(dot(own.normal, tap.normal), 0.0);
        nearnessOf[k] = tapNearness(offset, cosine, tapSpline(k), tap.valid ? 1.0 : 0.0, tapsPerMeter);
        plane2Of[k] = square(dot(own.normal * tapsPerMeter, offset));
        gatheredOf[k] = stored(tap.gathered);
        if (push.hasDirect != 0u) directOf[k] = stored(tap.direct);
        if (push.directions != 0u) momentOf[k] = tap.moment;
        if (tap.valid) validTaps |= 1u << k;
        if (cosine >= kSameSideOfTaps) sameSideTaps |= 1u << k;
    }
    // At rims, taps without their mirror image go.
    uint mirrored = bitfieldReverse(validTaps) >> (32 - kTaps);
    if ((validTaps & mirrored & ~(1u << kMiddleTap)) == 0u) return;
    for (int k = 0; k < kTaps; ++k)
        if (k != kMiddleTap && (mirrored & 1u << k) == 0u) nearnessOf[k] = 0.0;
}

float distanceOf(TapComparison to, vec4 light, int k)
{
    float x = float(tapX(k));
    float y = float(tapY(k));
    return tapDistance(to, luminanceOf(light.xyz), light.w, x, y, x * x, x * y, y * y);
}
TapComparison comparisonWith(vec4 middle, Trend trend, float tolerance)
{
    return tapComparison(luminanceOf(middle.xyz), middle.w, trend, tolerance);
}

// Weight of the taps that differ from the middle by no more than noise, 0 to 1.
float explainedBy(Trend trend)
{
    TapComparison to = comparisonWith(gatheredOf[kMiddleTap], trend, 0.0);
    float explained = 0.0;
    for (int k = 0; k < kTaps; ++k) explained += tapSpline(k) * falloff(distanceOf(to, gatheredOf[k], k));
    return explained;
}

vec3 slopeBetween(int behind, int ahead)
{
    uint both = 1u << behind | 1u << ahead;
    if ((sameSideTaps & both) != both) return vec3(0.0);
    return slopeOfTaps(gatheredOf[behind].xyz, gatheredOf[kMiddleTap].xyz, gatheredOf[ahead].xyz);
}

Trend fittedToTaps()
{
    LightSums sums = LightSums(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    for (int k = 0; k < kTaps; ++k) {
        float x = float(tapX(k));
        float y = float(tapY(k));
        vec3 light = gatheredOf[k].xyz;
        sums.all += light;
        sums.x += x * light;
        sums.y += y * light;
        sums.xx += x * x * light;
        sums.xy += x * y * light;
        sums.yy += y * y * light;
    }
    return fittedTrend(sums);
}

// As detrendedOf() in denoise.cpp.
Trend trendOfTaps(int number)
{
    Trend slopes = flatTrend();
    if (number > 0) { // single texels are too noisy
        slopes.x = slopeBetween(kMiddleTap - 2, kMiddleTap + 2);
        slopes.y = slopeBetween(kMiddleTap - 10, kMiddleTap + 10);
    }
    if ((validTaps & sameSideTaps) != kAllTaps) return slopes;
    Trend fitted = fittedToTaps();
    float explained = explainedBy(fitted);
    if (explained >= kEnoughExplained || explained >= kEnoughExplained * explainedBy(slopes)) return fitted;
    return slopes;
}

// Sums over taps for meanOfTaps().
struct TapSums {
    float weight;
    float variance;
    vec3 light;
    TermSums terms;
};
void add(inout TapSums sums, float weight, vec4 light, int k)
{
    float x = float(tapX(k));
    float y = float(tapY(k));
    sums.weight += weight;
    sums.variance += weight * weight * light.w;
    sums.light += weight * light.xyz;
    sums.terms.x += weight * x;
    sums.terms.y += weight * y;
    sums.terms.xx += weight * (x * x);
    sums.terms.xy += weight * (x * y);
    sums.terms.yy += weight * (y * y);
}
const TapSums kNoSums = TapSums(0.0, 0.0, vec3(0.0), TermSums(0.0, 0.0, 0.0, 0.0, 0.0));

float gatheredWeight(TapComparison to, int k)
{
    return nearnessOf[k] * falloff(plane2Of[k] + distanceOf(to, gatheredOf[k], k));
}

#endif
