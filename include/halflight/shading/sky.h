// The sky by direction: a gradient, or an equirectangular picture.
#ifndef HALFLIGHT_SHADING_SKY_H
#define HALFLIGHT_SHADING_SKY_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Radiance (cd/m2) from unit direction d: linear in d.y from horizon to zenith above and from horizon to ground below.
HL_FN vec3 skyRadiance(vec3 zenith, vec3 horizon, vec3 ground, vec3 d)
{
    return d.y >= 0.0f ? mix(horizon, zenith, d.y) : mix(horizon, ground, -d.y);
}

// Where a picture shows unit direction d: u in 0...1 to the right, v from 0 at the top to 1 at the bottom. Unturned, +X
// is at u = 0.5, +Z at 0.75, -Z at 0.25 and +Y at v = 0. Blender's environment textures (its +X, its +Y at u = 0.25)
// and three.js's equirectangular textures have the same. `turn`: cosine and sine of the picture's rotation about +Y, by
// the right-hand rule: at a quarter turn the picture's middle shows at -Z.
HL_FN vec2 skyPictureUv(vec3 d, vec2 turn)
{
    float x = turn.x * d.x - turn.y * d.z;
    float z = turn.y * d.x + turn.x * d.z;
    float radius = sqrt(x * x + z * z);
    float around = radius > 0.0f ? atan(z, x) : 0.0f;
    return vec2(0.5f + around / (2.0f * kShadingPi), atan(radius, d.y) / kShadingPi);
}

// The direction that a picture shows at (u, v).
HL_FN vec3 skyPictureDirection(vec2 place, vec2 turn)
{
    float around = (2.0f * place.x - 1.0f) * kShadingPi;
    float down = place.y * kShadingPi;
    float x = sin(down) * cos(around);
    float z = sin(down) * sin(around);
    return vec3(turn.x * x + turn.y * z, cos(down), turn.x * z - turn.y * x);
}

// Mip level of a picture `width` texels wide (twice its height) in which a texel covers the solid angle of the specular
// lobe: 1 / pdf at its peak, 4 pi alpha^2 for GGX seen head-on (Krivanek and Colbert 2008, "Real-time Shading with
// Filtered Importance Sampling"). A texel of level 0 covers 8 pi / width^2 on average.
HL_FN float skyPictureLevel(float roughness, float width)
{
    float alpha = roughness * roughness;
    return log2(max(alpha * width * 0.70710678f, 1.0f));
}

HL_NAMESPACE_END

#endif
