#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// The frame's samples as displayed pixels: what withoutCracks(), downsampled() and displayedPicture() do on the host.
#include "bindings.glsl"
#include "halflight/shading/display.h"

layout(location = 0) out vec4 outColor;

float luminance(vec3 linear)
{
    return dot(linear, vec3(0.2126, 0.7152, 0.0722));
}

vec3 sampleAt(ivec2 place)
{
    vec4 own = texelFetch(radianceSamples, place, 0);
    ivec2 size = ivec2(frame.pictureSize.xy);
    if (own.w > 0.0 || any(lessThan(place, ivec2(1))) || any(greaterThan(place, size - 2))) return own.rgb;
    vec3 sum = vec3(0.0);
    float darkest = 1.0e30;
    float brightest = 0.0;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            if (dx == 0 && dy == 0) continue;
            vec4 neighbour = texelFetch(radianceSamples, place + ivec2(dx, dy), 0);
            if (!(neighbour.w > 0.0)) return own.rgb;
            float level = luminance(neighbour.rgb);
            darkest = min(darkest, level);
            brightest = max(brightest, level);
            sum += neighbour.rgb;
        }
    }
    return isCrack(darkest, brightest) ? sum / 8.0 : own.rgb;
}

vec3 pixelAt(ivec2 place)
{
    int side = int(frame.display.y);
    vec3 sum = vec3(0.0);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) sum += sampleAt(place * side + ivec2(x, y));
    return sum / float(side * side);
}

// Between the four nearest pixels.
vec3 pixelsAround(vec2 place, ivec2 size)
{
    vec2 low = floor(place - 0.5);
    vec2 weight = place - 0.5 - low;
    ivec2 a = clamp(ivec2(low), ivec2(0), size - 1);
    ivec2 b = clamp(ivec2(low) + 1, ivec2(0), size - 1);
    return mix(mix(pixelAt(a), pixelAt(ivec2(b.x, a.y)), weight.x),
               mix(pixelAt(ivec2(a.x, b.y)), pixelAt(b), weight.x), weight.y);
}

void main()
{
    ivec2 size = ivec2(frame.pictureSize.xy) / int(frame.display.y);
    bool isEnlarged = ivec2(frame.displaySize.xy) != size;
    vec3 mean = isEnlarged ? pixelsAround(gl_FragCoord.xy * vec2(size) / frame.displaySize.xy, size)
                           : pixelAt(ivec2(gl_FragCoord.xy));
    vec3 color = frame.display.z < 0.0 ? clamp(mean, 0.0, 1.0)
                                    : srgbFromLinear(displayedColor(mean, frame.display.x, int(frame.display.z)));
    outColor = vec4(frame.display.w > 0.5 ? linearFromSrgb(color) : color, 1.0);
}
