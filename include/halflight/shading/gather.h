// Rays that gather light at a surface, and next-event samples of what emits or reflects it.
#ifndef HALFLIGHT_SHADING_GATHER_H
#define HALFLIGHT_SHADING_GATHER_H

#include "sampling.h"

HL_NAMESPACE_BEGIN

// The largest float below 1.
HL_CONST float kBelowOne = 0.999999940395355224609375f;
// Share of the way to a point on a surface at which shadow rays end, so that rounding does not make them hit it.
HL_CONST float kShortOfSurface = 1.0f - 1.0e-4f;

// Hemispheres about interpolated normals reach below the triangle; such directions are reflected out of it.
HL_FN vec3 outOfSurface(vec3 direction, vec3 geometricNormal)
{
    float side = dot(direction, geometricNormal);
    return direction - (side < 0.0f ? 2.0f * side : 0.0f) * geometricNormal;
}

// A gather direction: cosine-distributed about the normal, reflected out of the surface if below it.
HL_FN vec3 gatherDirection(vec3 normal, vec3 geometricNormal, vec2 u)
{
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(normal, tangent, bitangent);
    vec3 local = sampleCosineHemisphere(u);
    return outOfSurface(local.x * tangent + local.y * bitangent + local.z * normal, geometricNormal);
}

// Density of a gather direction per steradian; above 0 for reflected directions too.
HL_FN float gatherDirectionPdf(vec3 normal, vec3 direction)
{
    return max(dot(normal, direction), 1.0e-4f) / kShadingPi;
}

// Next-event sample of a point on an emitter, seen from a receiver.
struct NextEventContribution {
    vec3 direction;
    float distance; // 0 = no contribution
    float factor;   // irradiance without shadows per radiance of the emitter: cosines, MIS weight and 1/pdf
};

// Power heuristic (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering") for area
// samples of emitters against cosine-distributed directions, where `rayVisible` says that rays can hit the emitter.
// Without branches, so that loops over receivers can be vectorized.
HL_FN NextEventContribution nextEventContribution(vec3 position, vec3 normal, vec3 geometricNormal,
                                                  vec3 emitterPosition, vec3 emitterNormal, float pdfArea,
                                                  bool doubleSided, bool rayVisible)
{
    vec3 way = emitterPosition - position;
    float distance2 = dot(way, way);
    float distance = sqrt(distance2);
    vec3 direction = way * (1.0f / distance);
    float cosine = dot(normal, direction);
    float front = -dot(emitterNormal, direction);
    float emitterCosine = doubleSided ? abs(front) : front;
    float inversePdf = emitterCosine / (pdfArea * distance2);
    float weight = rayVisible ? powerHeuristic(1.0f, cosine / kShadingPi * inversePdf) : 1.0f;
    bool contributes = pdfArea > 0.0f && distance2 > 0.0f && cosine > 0.0f && emitterCosine > 0.0f &&
                       dot(direction, geometricNormal) > 0.0f;
    NextEventContribution next;
    next.direction = direction;
    next.distance = contributes ? distance : 0.0f;
    next.factor = contributes ? cosine * inversePdf * weight : 0.0f;
    return next;
}

// An area sample of an emitter as a direction from a place: all around it. `pdf`: per steradian; 0 = the emitter does
// not send light there.
struct SeenEmitter {
    vec3 direction;
    float distance;
    float pdf;
};
HL_FN SeenEmitter emitterSeenFrom(vec3 from, vec3 emitterPosition, vec3 emitterNormal, float pdfArea, bool doubleSided)
{
    SeenEmitter seen;
    seen.direction = vec3(0.0f);
    seen.distance = 0.0f;
    seen.pdf = 0.0f;
    vec3 way = emitterPosition - from;
    float distance2 = dot(way, way);
    if (!(pdfArea > 0.0f) || !(distance2 > 0.0f)) return seen;
    seen.distance = sqrt(distance2);
    seen.direction = way / seen.distance;
    float front = -dot(emitterNormal, seen.direction);
    float cosine = doubleSided ? abs(front) : front;
    if (cosine > 0.0f) seen.pdf = pdfArea * distance2 / cosine;
    return seen;
}

// MIS weight of a ray that hits a surface which is sampled by area too. `directionPdf`: per steradian; `pdfArea`: of
// the area samples at the hit, per square metre; `cosine`: at the hit.
HL_FN float misWeightOfRay(float directionPdf, float pdfArea, float distance, float cosine)
{
    return powerHeuristic(directionPdf, pdfArea * distance * distance / cosine);
}

// Alias table (Walker 1977): whether a number in [0, 1) selects a bin's own outcome, which has `share` of it. The
// number becomes one in [0, 1) again.
HL_FN bool selectsOwn(float share, HL_INOUT(float) u)
{
    bool own = u < share;
    u = min(own ? u / share : (u - share) / (1.0f - share), kBelowOne);
    return own;
}

HL_NAMESPACE_END

#endif
