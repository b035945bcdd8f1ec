// Realtime attenuation R from shadow maps.
#ifndef HALFLIGHT_SHADOW_MAP_GLSL
#define HALFLIGHT_SHADOW_MAP_GLSL

#include "bindings.glsl"
#include "halflight/shading/area_light.h"
#include "halflight/shading/light.h"
#include "halflight/shading/penumbra.h"

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

// Slopes of surfaces nearer to edge-on than this cosine count as this steep. Their receivers move farther along the
// normal instead, up to kEdgeOnShift times; in perspective tiles, whose depths are coarse far from the light, from twice
// the cosine on.
const float kMinSlopeCosine = 0.1;

// A receiver as a tile sees it.
struct Receiver {
    int tile;
    bool inside;
    bool cascade;      // in cascadeMaps, else in atlasMap
    vec2 texel;        // of the map
    float depth;       // 0...1
    vec2 slope;        // of its plane: depth per texel
    vec4 bounds;       // of the tile: centres of its outermost texels
    float texelMeters; // at the receiver
    float meters;      // from the light along the tile's axis; of cascades along the light's direction
    float slopeBias;   // of the map's depths, in slopes
    vec3 position;     // of the world, not moved by any bias
    vec3 normal;
};

// A receiver whose triangle's normal n is on the light's side. What a texel's centre and the receiver may differ in
// depth is allowed for in three ways: the filter follows the receiver's plane (Isidoro 2006, "Shadow Mapping: GPU-based
// Tips and Techniques"; planes stay planes in clip space, so the slope is exact for perspective tiles too), the receiver
// moves along its normal, the more the more it is tilted, and towards the light by the constant bias.
Receiver receiverIn(bool cascade, int light, int tile, vec3 position, vec3 n, vec3 l, float distanceFactor)
{
    Receiver r;
    r.tile = tile;
    r.cascade = cascade;
    r.inside = false;
    r.texelMeters = tiles[tile].parameters.x * distanceFactor;
    float cosine = saturate(dot(n, l));
    float sine = sqrt(1.0 - cosine * cosine);
    float shift = mix(kEdgeOnShift, 1.0, min((cascade ? 1.0 : 0.5) * cosine / kMinSlopeCosine, 1.0));
    vec2 bias = lights[light].shadowBias.xy;
    vec3 p = position + n * (bias.y * r.texelMeters * sine * shift) + l * (bias.x * r.texelMeters);
    vec4 clip = tiles[tile].clipFromWorld * vec4(p, 1.0);
    if (clip.w <= 0.0) return r;
    vec3 ndc = clip.xyz / clip.w;
    if (any(greaterThan(abs(ndc.xy), vec2(1.0))) || ndc.z > 1.0) return r;
    r.inside = true;

    vec4 rectangle = tiles[tile].rectangle;
    vec4 plane = tiles[tile].planeFromWorld * vec4(n, -dot(n, p));
    r.slope = abs(plane.z) > 1.0e-20 ? -plane.xy / plane.z * (2.0 / rectangle.z) : vec2(0.0);
    r.slope *= min(cosine / kMinSlopeCosine, 1.0);
    r.texel = rectangle.xy + (ndc.xy * 0.5 + 0.5) * rectangle.z;
    r.bounds = vec4(rectangle.xy + 0.5, rectangle.xy + rectangle.z - 0.5);
    r.depth = ndc.z;
    vec2 range = tiles[tile].parameters.zw;
    r.meters = cascade ? mix(range.x, range.y, ndc.z) : clip.w;
    r.slopeBias = lights[light].shadowBias.w;
    r.position = position;
    r.normal = n;
    return r;
}

#include "shadow_creases.glsl"

float tentFilter(Receiver r)
{
    int h = frame.shadow.x;
    float sum = r.cascade
                    ? tentFilter(cascadeMaps, r.texel, r.bounds, tiles[r.tile].rectangle.w, r.depth, r.slope, h)
                    : tentFilter(atlasMap, r.texel, r.bounds, 0.0, r.depth, r.slope, h);
    return h > 0 && sum > 0.0 && sum < 1.0 ? tentWithinCreases(r, h, sum) : sum;
}

// Half the source, as texels of the tile at the receiver for a penumbra as wide as the source (penumbraOfSource() = 1);
// of directional lights, for a caster 1 m away. Columns: along the source's X and Y.
mat2 sourceInTexels(int light, Receiver r)
{
    if (isAreaLight(lights[light].info.x)) {
        vec2 scale = vec2(0.5 * tiles[r.tile].rectangle.z / r.meters);
        return mat2((tiles[r.tile].clipFromWorld * vec4(lights[light].halfX.xyz, 0.0)).xy * scale,
                    (tiles[r.tile].clipFromWorld * vec4(lights[light].halfY.xyz, 0.0)).xy * scale);
    }
    return mat2(lights[light].shadowBias.z / r.texelMeters);
}

// Of a kernel, along the wider of its axes.
float halfWidth(mat2 kernel) { return max(length(kernel[0]), length(kernel[1])); }

// The source's picture by casters at this distance, as columns in texels. `cut`: it was wider than the tile's border,
// which it now fits.
mat2 penumbraKernel(mat2 source, Receiver r, float casterMeters, out bool cut)
{
    mat2 kernel = source * (r.cascade ? max(r.meters - casterMeters, 0.0) : penumbraOfSource(r.meters, casterMeters));
    float widest = halfWidth(kernel);
    float reach = penumbraReach(tiles[r.tile].rectangle.z);
    cut = widest > reach;
    return cut ? kernel * (reach / widest) : kernel;
}

// Point i of n of a kernel, or of a search; `turn` is carried from one to the next.
vec2 kernelPoint(bool square, bool search, int i, int n, inout vec2 turn)
{
    if (square) return squarePoint(i, n);
    turn = turnByGoldenAngle(turn);
    return turn * (search ? searchRadius(i, n) : sunflowerRadius(i, n));
}

// Mean distance from the light of what lies before the receiver's plane within the kernel, and the part of the texels
// that is. Each of n places reads 2 x 2 texels.
float casterDistance(Receiver r, mat2 kernel, bool square, int n, out float part)
{
    vec2 range = tiles[r.tile].parameters.zw;
    vec2 inverseSize = 1.0 / vec2(r.cascade ? textureSize(cascadeDepths, 0).xy : textureSize(atlasDepths, 0).xy);
    float layer = r.cascade ? tiles[r.tile].rectangle.w : 0.0;
    vec2 turn = vec2(1.0, 0.0);
    float sum = 0.0;
    float count = 0.0;
    [[dont_unroll]] for (int i = 0; i < n; ++i) {
        vec2 p = clamp(r.texel + kernel * kernelPoint(square, true, i, n, turn), r.bounds.xy + 0.5,
                       r.bounds.zw - 0.5);
        vec2 corner = floor(p - 0.5) + 0.5; // the centre of the first of 2 x 2 texels; their order is textureGather()'s
        vec3 place = vec3((corner + 0.5) * inverseSize, layer);
        vec4 depths = r.cascade ? textureGather(cascadeDepths, place) : textureGather(atlasDepths, place);
        vec2 d = corner - r.texel;
        vec4 plane = r.depth + r.slope.x * (d.x + vec4(0, 1, 1, 0)) + r.slope.y * (d.y + vec4(1, 1, 0, 0));
        vec4 before = vec4(lessThan(depths, plane));
        vec4 meters = r.cascade ? mix(vec4(range.x), vec4(range.y), depths)
                                : range.x * range.y / (range.y - depths * (range.y - range.x));
        sum += dot(before, meters);
        count += dot(before, vec4(1.0));
    }
    part = count / float(4 * n);
    return sum / max(count, 1.0);
}

float kernelFilter(sampler2DArrayShadow map, float layer, Receiver r, mat2 kernel, bool square, int n)
{
    vec2 inverseSize = 1.0 / vec2(textureSize(map, 0).xy);
    vec2 turn = vec2(1.0, 0.0);
    float sum = 0.0;
    [[dont_unroll]] for (int i = 0; i < n; ++i) {
        vec2 p = clamp(r.texel + kernel * kernelPoint(square, false, i, n, turn), r.bounds.xy, r.bounds.zw);
        sum += texture(map, vec4(p * inverseSize, layer, r.depth + dot(r.slope, p - r.texel)));
    }
    return sum / float(n);
}

// Attenuation from one tile: the filter's tent, or the penumbra of the light's size where that is wider. `cut`: the
// tile's texels are too small for its width, or for a search as far as it might reach.
float tileShadow(int light, Receiver r, out bool cut)
{
    cut = false;
    bool square = lights[light].info.x == kLightRectangle;
    float tent = diskLikeTent(float(frame.shadow.x));
    mat2 kernel = mat2(0.0);
    float width = 0.0;
    if (lights[light].shadowBias.z > 0.0) {
        mat2 source = sourceInTexels(light, r);
        kernel = penumbraKernel(source, r, tiles[r.tile].parameters.z, cut);
        float reach = halfWidth(kernel);
        if (reach > tent) {
            float part;
            float casterMeters = casterDistance(r, kernel, square, penumbraTaps(reach) / 4, part);
            if (part == 0.0) return 1.0;
            bool isWide;
            kernel = penumbraKernel(source, r, casterMeters, isWide);
            cut = cut && isWide;
            width = part < 1.0 ? halfWidth(kernel) : 0.0;
        }
    }
    if (width <= tent) return tentFilter(r);
    kernel *= diskOfComparisons(width) / width;
    int n = penumbraTaps(width);
    return r.cascade ? kernelFilter(cascadeMaps, tiles[r.tile].rectangle.w, r, kernel, square, n)
                     : kernelFilter(atlasMap, 0.0, r, kernel, square, n);
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
    bool cascade = lights[light].info.x == kLightDirectional;
    int firstTile = lights[light].info.w;
    int lastTile = firstTile;
    float nextWeight = 0.0;
    float distanceFactor = 1.0;
    if (cascade) {
        lastTile += frame.shadow.y - 1;
        firstTile += selectCascade(cameraDistance, nextWeight);
    } else {
        vec3 fromLight = position - lights[light].positionRange.xyz;
        distanceFactor = max(dot(fromLight, lights[light].axis.xyz), 0.0);
        if (lights[light].spot.z > 2.0) firstTile += cubeFace(fromLight, distanceFactor);
        lastTile = firstTile;
    }
    // The cascade, and the next one where they blend. Each hands over to those after it, whose texels are larger, where
    // a penumbra does not fit.
    float sum = 0.0;
    [[dont_unroll]] for (int next = 0; next <= (nextWeight > 0.0 ? 1 : 0); ++next) {
        float shadow = 1.0;
        bool cut = true;
        [[dont_unroll]] for (int tile = firstTile + next; cut && tile <= lastTile; ++tile) {
            if (tiles[tile].parameters.y == 0.0) break;
            Receiver r = receiverIn(cascade, light, tile, position, n, l, distanceFactor);
            if (!r.inside) break;
            shadow = tileShadow(light, r, cut);
        }
        sum += shadow * (next == 1 ? nextWeight : 1.0 - nextWeight);
    }
    return sum;
}

#endif
