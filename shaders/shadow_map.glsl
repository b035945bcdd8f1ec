// Realtime attenuation R from shadow maps.
#ifndef HALFLIGHT_SHADOW_MAP_GLSL
#define HALFLIGHT_SHADOW_MAP_GLSL

#include "bindings.glsl"
#include "halflight/shading/light.h"

// Percentage-closer filtering (Reeves et al. 1987, "Rendering Antialiased Shadows with Depth Maps") under a tent of
// half-width h texels. Each bilinear comparison covers 2 x 2 texels, its place between them chosen by their weights
// (Castano 2013, "Shadow Mapping Summary"), so h * h comparisons weigh (2h)^2 texels exactly. A tent of whole half-width
// sampled at whole steps sums to h per axis, hence the division. Each comparison is made against the receiver's plane
// at its own place: `slope` is that plane's depth per texel.
float tentFilter(sampler2DArrayShadow map, vec2 texel, vec4 bounds, float layer, float depth, vec2 slope, int h)
{
    vec2 inverseSize = 1.0 / vec2(textureSize(map, 0).xy);
    if (h == 0) {
        vec2 p = clamp(floor(texel) + 0.5, bounds.xy, bounds.zw); // a texel's centre: that texel alone
        return texture(map, vec4(p * inverseSize, layer, depth + dot(slope, p - texel)));
    }
    vec2 base = floor(texel - 0.5);
    vec2 f = texel - 0.5 - base;
    float inverseH = 1.0 / float(h);
    float sum = 0.0;
    for (int j = 1 - h; j < h; j += 2) {
        vec2 wy = 1.0 - abs(vec2(j, j + 1) - f.y) * inverseH;
        float weightY = wy.x + wy.y;
        float y = base.y + float(j) + 0.5 + wy.y / weightY;
        for (int i = 1 - h; i < h; i += 2) {
            vec2 wx = 1.0 - abs(vec2(i, i + 1) - f.x) * inverseH;
            float weightX = wx.x + wx.y;
            float x = base.x + float(i) + 0.5 + wx.y / weightX;
            vec2 p = clamp(vec2(x, y), bounds.xy, bounds.zw);
            sum += weightX * weightY * texture(map, vec4(p * inverseSize, layer, depth + dot(slope, p - texel)));
        }
    }
    return sum * inverseH * inverseH;
}

// Slopes of surfaces nearer to edge-on than this cosine count as this steep.
const float kMinSlopeCosine = 0.1;

// Attenuation from one tile, for a receiver whose triangle's normal n is on the light's side. What a texel's centre and
// the receiver may differ in depth is allowed for in three ways: the filter follows the receiver's plane (Isidoro 2006,
// "Shadow Mapping: GPU-based Tips and Techniques"; planes stay planes in clip space, so the slope is exact for
// perspective tiles too), the receiver moves along its normal, the more the more it is tilted, and towards the light by
// the constant bias.
float tileShadow(bool cascade, int light, int tile, vec3 position, vec3 n, vec3 l, float distanceFactor)
{
    if (tiles[tile].parameters.y == 0.0) return 1.0;
    float texelMeters = tiles[tile].parameters.x * distanceFactor;
    float cosine = saturate(dot(n, l));
    float sine = sqrt(1.0 - cosine * cosine);
    vec2 bias = lights[light].shadowBias.xy;
    vec3 p = position + n * (bias.y * texelMeters * sine) + l * (bias.x * texelMeters);
    vec4 clip = tiles[tile].clipFromWorld * vec4(p, 1.0);
    if (clip.w <= 0.0) return 1.0;
    vec3 ndc = clip.xyz / clip.w;
    if (any(greaterThan(abs(ndc.xy), vec2(1.0))) || ndc.z > 1.0) return 1.0;

    vec4 rectangle = tiles[tile].rectangle;
    vec4 plane = tiles[tile].planeFromWorld * vec4(n, -dot(n, p));
    vec2 slope = abs(plane.z) > 1.0e-20 ? -plane.xy / plane.z * (2.0 / rectangle.z) : vec2(0.0);
    slope *= min(cosine / kMinSlopeCosine, 1.0);

    vec2 texel = rectangle.xy + (ndc.xy * 0.5 + 0.5) * rectangle.z;
    vec4 bounds = vec4(rectangle.xy + 0.5, rectangle.xy + rectangle.z - 0.5);
    int h = frame.shadow.x;
    if (cascade) return tentFilter(cascadeMaps, texel, bounds, rectangle.w, ndc.z, slope, h);
    return tentFilter(atlasMap, texel, bounds, 0.0, ndc.z, slope, h);
}

// Interleaved gradient noise, 0…1: Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare".
float pixelNoise(vec2 pixel) { return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))); }

// First cascade that reaches as far as the fragment, and how much of the next one is blended in.
int selectCascade(float cameraDistance, out float nextWeight)
{
    int last = frame.shadow.y - 1;
    int cascade = 0;
    while (cascade < last && cameraDistance > frame.cascadeFar[cascade]) ++cascade;
    nextWeight = 0.0;
    if (cascade == last || frame.shadow.z == kBlendHard || frame.shadowBias.z <= 0.0) return cascade;
    float end = frame.cascadeFar[cascade];
    nextWeight = saturate((cameraDistance - end) / (frame.shadowBias.z * end) + 1.0);
    if (frame.shadow.z == kBlendSoft || nextWeight == 0.0) return cascade;
    if (pixelNoise(gl_FragCoord.xy) < nextWeight) ++cascade;
    nextWeight = 0.0;
    return cascade;
}

// Face of a cube around a light, in the order +X -X +Y -Y +Z -Z, and the distance along its axis.
int cubeFace(vec3 fromLight, out float axisDistance)
{
    vec3 a = abs(fromLight);
    if (a.x >= a.y && a.x >= a.z) {
        axisDistance = a.x;
        return fromLight.x >= 0.0 ? 0 : 1;
    }
    if (a.y >= a.z) {
        axisDistance = a.y;
        return fromLight.y >= 0.0 ? 2 : 3;
    }
    axisDistance = a.z;
    return fromLight.z >= 0.0 ? 4 : 5;
}

// R of a light that has shadow maps this frame.
float realtimeAttenuation(int light, vec3 position, vec3 n, vec3 l, float cameraDistance)
{
    int firstTile = lights[light].info.w;
    int type = lights[light].info.x;
    if (type == kLightDirectional) {
        float nextWeight;
        int cascade = selectCascade(cameraDistance, nextWeight);
        float shadow = tileShadow(true, light, firstTile + cascade, position, n, l, 1.0);
        if (nextWeight > 0.0)
            shadow = mix(shadow, tileShadow(true, light, firstTile + cascade + 1, position, n, l, 1.0), nextWeight);
        return shadow;
    }
    vec3 fromLight = position - lights[light].positionRange.xyz;
    if (lights[light].spot.z < 2.0)
        return tileShadow(false, light, firstTile, position, n, l, max(dot(fromLight, lights[light].axis.xyz), 0.0));
    float axisDistance;
    int face = cubeFace(fromLight, axisDistance);
    return tileShadow(false, light, firstTile + face, position, n, l, axisDistance);
}

#endif
