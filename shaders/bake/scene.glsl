// The scene that rays hit, and the surfaces that they pass.
#ifndef HALFLIGHT_BAKE_SCENE_GLSL
#define HALFLIGHT_BAKE_SCENE_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require

#include "bake_gpu/layout.h"
#include "halflight/shading/coverage.h"
#include "halflight/shading/random.h"
#include "halflight/shading/rays.h"
#include "halflight/shading/texture_filter.h"

// Rays end somewhere: not every device takes an infinite length.
const float kLongestRay = 1.0e30;

layout(buffer_reference, scalar) buffer Rays { GpuRay at[]; };
layout(buffer_reference, scalar) buffer Hits { GpuHit at[]; };
layout(buffer_reference, scalar) buffer Floats { float at[]; };
layout(buffer_reference, scalar) buffer Vectors { vec3 at[]; };
layout(buffer_reference, scalar) buffer Pairs { vec2 at[]; };
layout(buffer_reference, scalar) buffer Slots { GpuSlot at[]; };
layout(buffer_reference, scalar) buffer Words { uint at[]; };
layout(buffer_reference, scalar) buffer MaskedTriangles { GpuMaskedTriangle at[]; };
layout(buffer_reference, scalar) buffer Masks { GpuMask at[]; };
layout(buffer_reference, scalar) buffer Pictures { GpuBytes at[]; };

layout(buffer_reference, scalar) buffer GlassList { GpuGlass at[]; };
layout(buffer_reference, scalar) buffer GlassTriangles { GpuGlassTriangle at[]; };

// DeviceScene::Addresses.
layout(buffer_reference, scalar) buffer SceneData
{
    uvec2 tree;
    Slots slots;
    Words faces;
    MaskedTriangles masked;
    Masks masks;
    Pictures pictures;
    Words bytes;
    GlassList glass;
    Words glassOf;           // by masked triangle; kNone, or its number among the next
    GlassTriangles panes;
    Floats linear;           // by byte in sRGB
    float scale; // of the scene, for rayEpsilon()
    uint tinted; // some glass has a colour: the lists of glass are there
};

uint byteAt(Words words, uint index)
{
    return words.at[index >> 2u] >> ((index & 3u) * 8u) & 0xffu;
}

float byteValue(SceneData scene, uint index, bool isColor)
{
    uint value = byteAt(scene.bytes, index);
    return isColor ? scene.linear.at[value] : float(value);
}

// Value 0 to 1 of a texture at a triangle; 1 where there is none. isColor: its bytes are in sRGB.
float textureValue(SceneData scene, GpuTextureUse use, GpuMaskedTriangle triangle, vec2 barycentric, bool isColor)
{
    if (use.picture < 0) return 1.0;
    uint first = use.set * 3u;
    vec2 uv = (1.0 - barycentric.x - barycentric.y) * triangle.uv[first] + barycentric.x * triangle.uv[first + 1u] +
              barycentric.y * triangle.uv[first + 2u];
    GpuBytes picture = scene.pictures.at[use.picture];
    TexelPlace at = texelPlace(transformedCoordinate(uv, use.offset, use.scale, use.turn), picture.size, picture.wrapU,
                               picture.wrapV, picture.nearest != 0u);
    uint row = picture.first + uint(at.low.y * picture.size.x);
    uint next = picture.first + uint(at.high.y * picture.size.x);
    float top = mix(byteValue(scene, row + uint(at.low.x), isColor), byteValue(scene, row + uint(at.high.x), isColor),
                    at.weight.x);
    float bottom = mix(byteValue(scene, next + uint(at.low.x), isColor),
                       byteValue(scene, next + uint(at.high.x), isColor), at.weight.x);
    float value = mix(top, bottom, at.weight.y);
    return isColor ? value : value / 255.0;
}

// Alpha at a point, and the share that passes as through glass.
void alphaAndGlass(SceneData scene, GpuMask m, GpuMaskedTriangle triangle, vec2 barycentric, out float alpha,
                   out float glass)
{
    vec3 weights = vec3(1.0 - barycentric.x - barycentric.y, barycentric);
    alpha = m.opacity * textureValue(scene, m.alpha, triangle, barycentric, false) * dot(weights, triangle.alpha);
    glass = m.glass;
    if (glass > 0.0)
        glass *= textureValue(scene, m.transmissionTexture, triangle, barycentric, false) *
                 (1.0 - m.metallic * textureValue(scene, m.metallicTexture, triangle, barycentric, false));
}

// As Materials::coverageAt().
float coverageAt(SceneData scene, GpuMaskedTriangle triangle, vec2 barycentric)
{
    GpuMask m = scene.masks.at[triangle.mask];
    float alpha;
    float glass;
    alphaAndGlass(scene, m, triangle, barycentric, alpha, glass);
    return coverageOf(alpha, m.cutoff, m.blended != 0u, glass);
}

// Whether a ray passes a surface of a coverage between 0 and 1: by chance, by a hash of the ray.
bool passesByChance(uint triangle, float coverage, vec3 origin, vec3 direction)
{
    uint bits = triangle;
    for (int i = 0; i < 3; ++i) bits = hashCombine(bits, floatBitsToUint(origin[i]));
    for (int i = 0; i < 3; ++i) bits = hashCombine(bits, floatBitsToUint(direction[i]));
    return unitFloat(bits) >= coverage;
}

// Whether a ray passes a triangle of a slot, where the slot's barycentric weights say: by a hole, or by chance.
bool passesTriangle(SceneData scene, GpuSlot slot, uint number, vec2 barycentric, vec3 origin, vec3 direction)
{
    if (slot.firstMasked == kNone) return false;
    GpuMaskedTriangle triangle = scene.masked.at[slot.firstMasked + number];
    float coverage = coverageAt(scene, triangle, slot.mirrored != 0u ? barycentric.yx : barycentric);
    return coverage < 1.0 && passesByChance(slot.firstTriangle + triangle.triangle, coverage, origin, direction);
}

// A ray that is not traced.
GpuRay noRay()
{
    GpuRay ray;
    ray.origin = vec3(0.0);
    ray.tMin = 0.0;
    ray.direction = vec3(0.0, 0.0, 1.0);
    ray.tMax = -1.0;
    return ray;
}

#endif
