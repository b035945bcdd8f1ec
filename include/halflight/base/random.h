#pragma once

#include "halflight/base/math.h"

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

/// Point of a rank-1 lattice in the unit square (Roberts 2018, the R2 sequence).
inline vec2 r2Point(int number)
{
    // Fractions of 32 bits, as exact for large numbers as for small ones.
    constexpr uint32_t kX = 3242174889u; // 0.7548776662
    constexpr uint32_t kY = 2447445413u; // 0.5698402910
    return {unitFloat(0x80000000u + uint32_t(number) * kX), unitFloat(0x80000000u + uint32_t(number) * kY)};
}

} // namespace halflight
