// How much light a surface stops.
#ifndef HALFLIGHT_SHADING_COVERAGE_H
#define HALFLIGHT_SHADING_COVERAGE_H

#include "language.h"

HL_NAMESPACE_BEGIN

// Cutoff of a material without one.
HL_CONST float kNoCutoff = -3.0e38f;

// Share of light that a surface stops at a point: by the point's alpha, the material's cutoff, whether it is blended,
// and the share that passes as through glass. Material::coverage() is the same: the scene knows no shading.
HL_FN float coverageOf(float alpha, float cutoff, bool blended, float glass)
{
    if (alpha < cutoff) return 0.0f;
    return (blended ? saturate(alpha) : 1.0f) * (1.0f - glass);
}

// Light that a surface lets through at a point, by colour: glass passes its base colour, and so does what alpha leaves
// open where the material is tinted. Material::passed() is the same of glass without thickness.
HL_FN vec3 passedOf(float alpha, float cutoff, bool blended, float glass, vec3 base, bool tinted)
{
    float there = alpha < cutoff ? 0.0f : (blended ? saturate(alpha) : 1.0f);
    vec3 color = clamp(base, vec3(0.0f), vec3(1.0f));
    return (1.0f - there) * (tinted ? color : vec3(1.0f)) + there * glass * color;
}

HL_NAMESPACE_END

#endif
