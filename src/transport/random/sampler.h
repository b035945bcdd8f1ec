#pragma once

#include "halflight/base/math.h"
#include "halflight/shading/sobol.h"

#include <cstdint>

namespace halflight {

/// The random numbers of a path (shading/sobol.h).
class Sampler {
public:
    Sampler(uint32_t seed, uint32_t texel, uint32_t sample) : state_(shading::pathSampler(seed, texel, sample)) {}

    /// The next pair of dimensions.
    vec2 next2() { return shading::nextPair(state_); }
    /// The first of the next pair alone.
    float next1() { return shading::nextNumber(state_); }

private:
    friend bool survivesRoulette(float probability, Sampler& sampler, vec3& throughput);
    shading::PathSampler state_;
};

/// Russian roulette: whether a path goes on, with `throughput` raised in proportion.
inline bool survivesRoulette(float probability, Sampler& sampler, vec3& throughput)
{
    return shading::survivesRoulette(probability, sampler.state_, throughput);
}

} // namespace halflight
