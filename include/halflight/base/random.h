#pragma once

#include <cstdint>

namespace halflight {

/// PCG's output permutation used as an integer hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
inline uint32_t hashPcg(uint32_t value)
{
    const uint32_t state = value * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

inline uint32_t hashCombine(uint32_t a, uint32_t b)
{
    return hashPcg(a ^ hashPcg(b));
}

/// 32 random bits to a float in [0, 1), all of them multiples of 2^-24.
inline float unitFloat(uint32_t bits)
{
    return float(bits >> 8) * 0x1.0p-24f;
}

} // namespace halflight
