// How much light a surface stops.
#ifndef HALFLIGHT_SHADING_COVERAGE_H
#define HALFLIGHT_SHADING_COVERAGE_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Cutoff of a material without one.
HL_CONST float kNoCutoff = -3.0e38f;

// Light that a face of glass lets through at normal incidence: halflight::kGlassTransmittance.
HL_CONST float kFaceTransmittance = 0.96f;

// Share of light that a surface stops at a point: by the point's alpha, the material's cutoff, whether it is blended,
// and the share that passes as through glass. Material::coverage() is the same: the scene knows no shading.
HL_FN float coverageOf(float alpha, float cutoff, bool blended, float glass)
{
    if (alpha < cutoff) return 0.0f;
    return (blended ? saturate(alpha) : 1.0f) * (1.0f - glass);
}

// Light that a surface lets through at a point, by colour: glass passes its base colour, and so does what alpha leaves
// open where the material is tinted. behind: what a thickness behind the surface lets through. Material::passed() is
// the same.
HL_FN vec3 passedOf(float alpha, float cutoff, bool blended, float glass, vec3 base, bool tinted, vec3 behind)
{
    float there = alpha < cutoff ? 0.0f : (blended ? saturate(alpha) : 1.0f);
    vec3 color = clamp(base, vec3(0.0f), vec3(1.0f));
    return (1.0f - there) * (tinted ? color : vec3(1.0f)) + there * glass * color * behind;
}

// Light that a way through a volume leaves, by colour (Bouguer 1729, Lambert 1760, Beer 1852; KHR_materials_volume).
// attenuation in 1/m, of attenuationOf(material).
HL_FN vec3 volumeLeaves(vec3 attenuation, float meters)
{
    return vec3(exp(-attenuation.x * meters), exp(-attenuation.y * meters), exp(-attenuation.z * meters));
}

// Straight way in metres through a pane of a thickness in the mesh's space. normal: unit, in the world. scaled:
// transpose of the linear part of world from object, times the normal. direction: along the way, of any length.
HL_FN float wayThroughPane(float thickness, vec3 normal, vec3 scaled, vec3 direction)
{
    float cosine = abs(dot(normal, direction)) / length(direction);
    return thickness * length(scaled) / max(cosine, 1.0e-4f);
}

// Distances of two hits of a ray, in metres, that count as one place: a ray through the edge of two triangles may meet
// both.
HL_FN bool isSamePlace(float a, float b)
{
    return abs(a - b) <= 1.0e-6f * b;
}

// Length of a ray from which on it has no end, in metres.
HL_CONST float kEndlessRay = 1.0e30f;

// Light that glass leaves from the end of a ray to its origin, by colour. passed: product of what faces let through.
// way: sum of a volume's attenuation, in 1/m, times the distance, in metres, where the ray leaves the volume, less that
// where it enters one. inside: attenuation of volumes that it enters less that of those that it leaves: where it is
// above 0, the ray ends inside. end: the ray's length in metres. By volumeLeaves(), in any order of the faces.
HL_FN vec3 glassLeaves(vec3 passed, vec3 way, vec3 inside, float end)
{
    if (end < kEndlessRay) way += max(inside, vec3(0.0f)) * end;
    vec3 lost = max(way, vec3(0.0f));
    return passed * vec3(exp(-lost.x), exp(-lost.y), exp(-lost.z));
}

HL_NAMESPACE_END

#endif
