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

HL_NAMESPACE_END

#endif
