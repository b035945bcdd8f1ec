// What rays carry to the shaders of their hits, and back.
#ifndef HALFLIGHT_BAKE_PAYLOADS_GLSL
#define HALFLIGHT_BAKE_PAYLOADS_GLSL

struct NearestPayload
{
    uint face;
    vec2 barycentric;
    float distance;
};
// Before the ray is traced `face` says which surfaces it meets.
const uint kAllFaces = 0u;
const uint kNoHiddenBacks = 1u;
const uint kCountSolids = 2u; // meets none, but adds solids left minus entered to barycentric.x

#ifdef HALFLIGHT_TINTED
#include "glass.glsl"
#endif

struct ThroughPayload
{
    uint depth; // -log2 of what passes, in units of 2^-16: integers add up in any order
    uint state;
#ifdef HALFLIGHT_TINTED
    GlassSums glass; // with a colour, which is not in `depth`
#endif
};
// Before the ray is traced `state` says what blended surfaces do.
const uint kMultiplies = 0u;     // they take their share of the light
const uint kStopsByChance = 1u;
const uint kPassed = 2u;         // afterwards: nothing stopped the ray
const uint kTints = 3u;          // glass with a colour that chance lets the ray pass gives it its tint; none stops it

struct SolidsPayload
{
    int left; // solids left minus entered
};

#endif
