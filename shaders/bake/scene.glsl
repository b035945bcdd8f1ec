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

// GpuScene::Addresses.
layout(buffer_reference, scalar) buffer SceneData
{
    uvec2 tree;
    Slots slots;
    Words faces;
    MaskedTriangles masked;
    Masks masks;
    Pictures pictures;
    Words bytes;
    float scale; // of the scene, for rayEpsilon()
};

uint byteAt(Words words, uint index)
{
    return words.at[index >> 2u] >> ((index & 3u) * 8u) & 0xffu;
}

// Value 0 to 1 of a texture at a triangle; 1 where there is none.
float textureValue(SceneData scene, GpuTextureUse use, GpuMaskedTriangle triangle, vec2 barycentric)
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
    float top = mix(float(byteAt(scene.bytes, row + uint(at.low.x))), float(byteAt(scene.bytes, row + uint(at.high.x))),
                    at.weight.x);
    float bottom = mix(float(byteAt(scene.bytes, next + uint(at.low.x))),
                       float(byteAt(scene.bytes, next + uint(at.high.x))), at.weight.x);
    return mix(top, bottom, at.weight.y) / 255.0;
}

// As Materials::coverageAt().
float coverageAt(SceneData scene, GpuMaskedTriangle triangle, vec2 barycentric)
{
    GpuMask m = scene.masks.at[triangle.mask];
    vec3 weights = vec3(1.0 - barycentric.x - barycentric.y, barycentric);
    float alpha = m.opacity * textureValue(scene, m.alpha, triangle, barycentric) * dot(weights, triangle.alpha);
    float glass = m.glass;
    if (glass > 0.0)
        glass *= textureValue(scene, m.transmissionTexture, triangle, barycentric) *
                 (1.0 - m.metallic * textureValue(scene, m.metallicTexture, triangle, barycentric));
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
