#pragma once
// What the radiosity passes bring on the processor and on a device, compared.

#include "transport/radiosity/form_factors.h"

namespace halflight::test {

/// What of both differs.
struct Differences {
    std::size_t occluded = 0; ///< patches and elements that an occluder crosses
    std::size_t otherOccluded = 0;
    std::size_t links = 0;
    std::size_t otherLinks = 0;
    std::size_t tints = 0; ///< links through coloured glass
    std::size_t otherTints = 0;
    std::size_t samples = 0; ///< sums of light, by entry of FormFactorRange::samples
    std::size_t otherSamples = 0;
    std::size_t parts = 0; ///< the same of components
    std::size_t otherParts = 0;
    double light = 0.0; ///< of all samples
    double lightDifference = 0.0;
    uint64_t raysOfCpu = 0;
    uint64_t raysOfGpu = 0;
};

/// Whether two sums of one sample differ by more than rounding does.
inline bool isOther(vec3 a, vec3 b, float near = 1.0e-3f)
{
    return glm::distance(a, b) > near * (glm::length(a) + 1.0e-4f);
}
inline bool isOther(const LobeMoments& a, const LobeMoments& b)
{
    // A sampled direction of a lobe that falls below the surface counts as none.
    return isOther(a.albedo, b.albedo) || isOther(a.exitance, b.exitance) || isOther(a.normal, b.normal) ||
           isOther(vec3(a.evenLight, a.evenCosine, a.sampledExitance),
                   vec3(b.evenLight, b.evenCosine, b.sampledExitance), 5.0e-3f) ||
           isOther(a.sampledMoment, b.sampledMoment, 5.0e-3f);
}

inline bool isOther(const ComponentSamples& a, const ComponentSamples& b)
{
    return isOther(a.gathered, b.gathered) || isOther(a.direct, b.direct) || isOther(a.exitance, b.exitance) ||
           isOther(vec3(a.sampledExitance), vec3(b.sampledExitance), 5.0e-3f) ||
           isOther(a.sampledMoment, b.sampledMoment, 5.0e-3f);
}

} // namespace halflight::test
