// Warps from the unit square, and how pdfs combine.
#ifndef HALFLIGHT_SHADING_SAMPLING_H
#define HALFLIGHT_SHADING_SAMPLING_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Two unit vectors that make a right-handed basis with unit n: Duff et al. 2017, "Building an Orthonormal Basis,
// Revisited".
HL_FN void orthonormalBasis(vec3 n, HL_INOUT(vec3) tangent, HL_INOUT(vec3) bitangent)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z);
    float b = n.x * n.y * a;
    tangent = vec3(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    bitangent = vec3(b, s + n.y * n.y * a, -n.y);
}

// Unit disc, concentric: Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square". pdf 1 / pi.
HL_FN vec2 sampleDisc(vec2 u)
{
    vec2 o = 2.0f * u - vec2(1.0f);
    if (o.x == 0.0f && o.y == 0.0f) return vec2(0.0f);
    float r;
    float phi;
    if (abs(o.x) > abs(o.y)) {
        r = o.x;
        phi = (kShadingPi / 4.0f) * (o.y / o.x);
    } else {
        r = o.y;
        phi = kShadingPi / 2.0f - (kShadingPi / 4.0f) * (o.x / o.y);
    }
    return r * vec2(cos(phi), sin(phi));
}

// Cosine-weighted hemisphere about +Z (Malley's method). pdf cos(theta) / pi.
HL_FN vec3 sampleCosineHemisphere(vec2 u)
{
    vec2 d = sampleDisc(u);
    return vec3(d, sqrt(max(0.0f, 1.0f - dot(d, d))));
}

// Unit sphere. pdf 1 / (4 pi).
HL_FN vec3 sampleSphere(vec2 u)
{
    float z = 1.0f - 2.0f * u.x;
    float r = sqrt(max(0.0f, 1.0f - z * z));
    float phi = 2.0f * kShadingPi * u.y;
    return vec3(r * cos(phi), r * sin(phi), z);
}

// Barycentric coordinates (of the first two vertices) uniform over a triangle: Heitz 2019, "A Low-Distortion Map
// Between Triangle and Square".
HL_FN vec2 sampleTriangle(vec2 u)
{
    return u - 0.5f * min(u.x, u.y);
}

// Veach 1997, "Robust Monte Carlo Methods for Light Transport Simulation", section 9.2.4: power heuristic, beta = 2.
HL_FN float powerHeuristic(float pdf, float otherPdf)
{
    if (pdf <= 0.0f) return 0.0f;
    float ratio = otherPdf / pdf; // squares of the densities themselves would leave the range of floats
    return 1.0f / (1.0f + ratio * ratio);
}

HL_NAMESPACE_END

#endif
