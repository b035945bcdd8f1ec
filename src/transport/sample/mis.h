#pragma once
// Multiple importance sampling of area samples against cosine-distributed directions.

#include "halflight/base/math.h"
#include "halflight/shading/sampling.h"

#include <cmath>

namespace halflight {

/// Next-event sample of a point on an emitter, seen from a receiver.
struct NextEventContribution {
    vec3 direction{0.0f};
    float distance = 0.0f; ///< 0 = no contribution
    float factor = 0.0f;   ///< irradiance without shadows per radiance of the emitter: cosines, MIS weight and 1/pdf
};

/// Power heuristic (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering") for
/// area samples of emitters against cosine-distributed directions, where `rayVisible` says that rays can hit the
/// emitter. Without branches, so that loops over receivers can be vectorized.
inline NextEventContribution nextEventContribution(vec3 position, vec3 normal, vec3 geometricNormal,
                                                   vec3 emitterPosition, vec3 emitterNormal, float pdfArea,
                                                   bool doubleSided, bool rayVisible)
{
    const vec3 way = emitterPosition - position;
    const float distance2 = glm::dot(way, way);
    const float distance = std::sqrt(distance2);
    const vec3 direction = way * (1.0f / distance);
    const float cosine = glm::dot(normal, direction);
    const float front = -glm::dot(emitterNormal, direction);
    const float emitterCosine = doubleSided ? std::abs(front) : front;
    const float inversePdf = emitterCosine / (pdfArea * distance2);
    const float weight = rayVisible ? shading::powerHeuristic(1.0f, cosine / kPi * inversePdf) : 1.0f;
    const bool contributes = pdfArea > 0.0f && distance2 > 0.0f && cosine > 0.0f && emitterCosine > 0.0f &&
                             glm::dot(direction, geometricNormal) > 0.0f;
    return {direction, contributes ? distance : 0.0f, contributes ? cosine * inversePdf * weight : 0.0f};
}

/// MIS weight of a ray that hits a surface which is sampled by area too. `directionPdf`: per steradian; `pdfArea`: of
/// the area samples at the hit, per square metre; `cosine`: at the hit.
inline float misWeightOfRay(float directionPdf, float pdfArea, float distance, float cosine)
{
    return shading::powerHeuristic(directionPdf, pdfArea * distance * distance / cosine);
}

} // namespace halflight
