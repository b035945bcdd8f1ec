// From the samples of a frame to displayed pixels: src/render/passes/samples.cpp, src/render/passes/display.cpp,
// shaders/display.frag.
#ifndef HALFLIGHT_SHADING_DISPLAY_H
#define HALFLIGHT_SHADING_DISPLAY_H

#include "color.h"
#include "tone_mapping.h"

HL_NAMESPACE_BEGIN

// Brightest over darkest neighbour up to which they count as one surface, also where two walls meet. Between leaves
// the sky shows through holes that are true, and these differ more.
HL_CONST float kOneSurface = 2.0f;

// Whether a single sample of sky is a crack, by the luminance of the eight samples around it, which all show surfaces.
HL_FN bool isCrack(float darkest, float brightest)
{
    return brightest <= kOneSurface * darkest;
}

// Radiance beyond this, times the exposure's factor, is white.
HL_CONST float kMostDisplayed = 1.0e6f;

// Display-referred linear colour, 0…1; `mapper` as in toneMapped(). Channels that are no numbers are black.
HL_FN vec3 displayedColor(vec3 radiance, float exposure, int mapper)
{
    vec3 linear = radiance * exposure;
    linear = vec3(linear.x >= 0.0f ? linear.x : 0.0f, linear.y >= 0.0f ? linear.y : 0.0f,
                  linear.z >= 0.0f ? linear.z : 0.0f);
    return clamp(toneMapped(min(linear, vec3(kMostDisplayed)), mapper), vec3(0.0f), vec3(1.0f));
}

HL_NAMESPACE_END

#endif
