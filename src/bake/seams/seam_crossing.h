// A way from one chart to another. C++ and GLSL 4.60 compile this file (halflight/shading/language.h).
#ifndef HALFLIGHT_BAKE_SEAM_CROSSING_H
#define HALFLIGHT_BAKE_SEAM_CROSSING_H

#include "halflight/shading/language.h"

HL_NAMESPACE_BEGIN

#ifdef __cplusplus
using halflight::ivec2;
using halflight::mat2;
using halflight::vec2;
using halflight::vec3;
#endif

HL_CONST uint kNowhere = 0xffffffffu; // kNoTexel

// A sample of a seam, seen from one of its sides.
struct SeamCrossing {
    uint texel;  // at the border, on this side
    uint target; // on the other side
    vec2 place;  // on this side's page, texels
    vec2 outward;
    vec2 targetPlace;
    mat2 across; // offsets on the other side's page for offsets on this one's
};

HL_NAMESPACE_END

#endif
