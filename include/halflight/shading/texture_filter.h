// Which texels of a texture a coordinate reads, by glTF's wrap modes.
#ifndef HALFLIGHT_SHADING_TEXTURE_FILTER_H
#define HALFLIGHT_SHADING_TEXTURE_FILTER_H

#include "language.h"

HL_NAMESPACE_BEGIN

// As Texture::Wrap.
HL_CONST int kWrapRepeat = 0;
HL_CONST int kWrapClampToEdge = 1;
HL_CONST int kWrapMirroredRepeat = 2;

// Remainder in 0 … period - 1. GLSL leaves % of negative numbers open.
HL_FN int remainderOf(int i, int period)
{
    return i >= 0 ? i % period : period - 1 - (-1 - i) % period;
}

HL_FN int wrapTexel(int i, int size, int mode)
{
    if (i >= 0 && i < size) return i;
    if (mode == kWrapClampToEdge) return clamp(i, 0, size - 1);
    if (mode == kWrapMirroredRepeat) {
        int m = remainderOf(i, 2 * size);
        return m < size ? m : 2 * size - 1 - m;
    }
    return (size & (size - 1)) == 0 ? i & (size - 1) : remainderOf(i, size);
}

// Index of the texel at a coordinate; 0 for coordinates that are not finite.
HL_FN int texelNumber(float coordinate, int size)
{
    float t = coordinate * float(size);
    return abs(t) < 3.0e38f ? int(floor(clamp(t, -1.0e9f, 1.0e9f))) : 0;
}

// The four texels of bilinear filtering. Without filtering all are the same.
struct TexelPlace {
    ivec2 low;   // column and row
    ivec2 high;  // the next ones
    vec2 weight; // of the second column and of the second row
};

HL_FN TexelPlace texelPlace(vec2 uv, ivec2 size, int wrapU, int wrapV, bool nearest)
{
    TexelPlace place;
    if (nearest) {
        place.low = ivec2(wrapTexel(texelNumber(uv.x, size.x), size.x, wrapU),
                          wrapTexel(texelNumber(uv.y, size.y), size.y, wrapV));
        place.high = place.low;
        place.weight = vec2(0.0f);
        return place;
    }
    vec2 at = uv * vec2(size) - 0.5f;
    int x = texelNumber(at.x / float(size.x), size.x);
    int y = texelNumber(at.y / float(size.y), size.y);
    place.low = ivec2(wrapTexel(x, size.x, wrapU), wrapTexel(y, size.y, wrapV));
    place.high = ivec2(wrapTexel(x + 1, size.x, wrapU), wrapTexel(y + 1, size.y, wrapV));
    place.weight = clamp(at - vec2(float(x), float(y)), 0.0f, 1.0f);
    return place;
}

// KHR_texture_transform: offset + rotation * (scale * uv). `turn`: cosine and sine of the rotation.
HL_FN vec2 transformedCoordinate(vec2 uv, vec2 offset, vec2 scale, vec2 turn)
{
    vec2 scaled = uv * scale;
    return offset + vec2(turn.x * scaled.x + turn.y * scaled.y, -turn.y * scaled.x + turn.x * scaled.y);
}

HL_NAMESPACE_END

#endif
