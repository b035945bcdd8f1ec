// The dim and the bright part of a sky's picture, and the areas between the centres of its texels: a bright area is
// sampled as a light. (src/transport/sample/sky_light.h says why.)
#ifndef HALFLIGHT_SHADING_SKY_PICTURE_H
#define HALFLIGHT_SHADING_SKY_PICTURE_H

#include "luminance.h"
#include "sky.h"

HL_NAMESPACE_BEGIN

// The four texels around a point, and where it is between them.
struct SkyPlace {
    ivec2 low; // column and row
    ivec2 high;
    vec2 between; // 0...1
};

// An area lies between four texels' centres. Those of the first and the last row, 0 and the picture's height, reach to
// the poles.
HL_FN SkyPlace skyArea(int column, int row, vec2 between, ivec2 size)
{
    SkyPlace place;
    place.low = ivec2(column, max(row - 1, 0));
    place.high = ivec2((column + 1) % size.x, min(row, size.y - 1));
    place.between = between;
    return place;
}

// Where an area begins and ends from the top, 0...1.
HL_FN vec2 skyRowRange(int row, int height)
{
    return vec2(max(float(row) - 0.5f, 0.0f) / float(height), min(float(row) + 0.5f, float(height)) / float(height));
}

HL_FN SkyPlace skyPlaceOf(vec3 direction, vec2 turn, ivec2 size)
{
    vec2 at = skyPictureUv(direction, turn) * vec2(size) + vec2(-0.5f, 0.5f);
    vec2 low = floor(at);
    return skyArea((int(low.x) + size.x) % size.x, clamp(int(low.y), 0, size.y), at - low, size);
}

// The share of a texel that rays receive: the rest, what its luminance exceeds the limit by, is the bright part.
HL_FN float skyDimShare(vec3 texel, float limit)
{
    float bright = luminanceOf(texel);
    return bright > limit ? limit / bright : 1.0f;
}

// How far away samples of the sky are where they are taken as those of emitters: beyond all geometry, which is at most
// 1e7 m from the origin, and near enough for the square of it.
HL_CONST float kSkyMeters = 1.0e9f;

// A point of an area that is uniform in solid angle, for u in the unit square.
struct SkyPoint {
    vec3 direction;
    SkyPlace place;
};

HL_FN SkyPoint skyPointOf(int column, int row, vec2 u, vec2 turn, ivec2 size)
{
    vec2 range = skyRowRange(row, size.y);
    float cosine = mix(cos(range.x * kShadingPi), cos(range.y * kShadingPi), u.y);
    vec2 uv = vec2((float(column) + 0.5f + u.x) / float(size.x), acos(clamp(cosine, -1.0f, 1.0f)) / kShadingPi);
    float down = uv.y * float(size.y) + 0.5f - float(row);
    SkyPoint point;
    point.direction = skyPictureDirection(uv, turn);
    point.place = skyArea(column, row, vec2(u.x, clamp(down, 0.0f, 1.0f)), size);
    return point;
}

HL_NAMESPACE_END

#endif
