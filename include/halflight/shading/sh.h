// Real spherical harmonics up to l = 2: Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance
// Environment Maps". Order of coefficients: 00, 1-1, 10, 11, 2-2, 2-1, 20, 21, 22.
#ifndef HALFLIGHT_SHADING_SH_H
#define HALFLIGHT_SHADING_SH_H

#include "language.h"

HL_NAMESPACE_BEGIN

HL_FN float shBasis(int i, vec3 d)
{
    if (i == 0) return 0.282094792f;
    if (i == 1) return 0.488602512f * d.y;
    if (i == 2) return 0.488602512f * d.z;
    if (i == 3) return 0.488602512f * d.x;
    if (i == 4) return 1.092548431f * d.x * d.y;
    if (i == 5) return 1.092548431f * d.y * d.z;
    if (i == 6) return 0.315391565f * (3.0f * d.z * d.z - 1.0f);
    if (i == 7) return 1.092548431f * d.x * d.z;
    return 0.546274215f * (d.x * d.x - d.y * d.y);
}

// Convolution of band l with the clamped cosine (their eq. 8): pi, 2 pi / 3, pi / 4.
HL_FN float shCosineLobe(int i)
{
    if (i == 0) return kShadingPi;
    if (i < 4) return 2.0f * kShadingPi / 3.0f;
    return kShadingPi / 4.0f;
}

// Weight of radiance coefficient i in the irradiance on a surface with normal n: irradiance = sum of coefficient *
// weight.
HL_FN float shIrradianceWeight(int i, vec3 n)
{
    return shCosineLobe(i) * shBasis(i, n);
}

HL_NAMESPACE_END

#endif
