// Random numbers without state: hashes of integers, and points spread evenly.
#ifndef HALFLIGHT_SHADING_RANDOM_H
#define HALFLIGHT_SHADING_RANDOM_H

#include "language.h"

HL_NAMESPACE_BEGIN

// PCG's output permutation used as an integer hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
HL_FN uint hashPcg(uint value)
{
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

HL_FN uint hashCombine(uint a, uint b)
{
    return hashPcg(a ^ hashPcg(b));
}

// 32 random bits to a float in [0, 1), all of them multiples of 2^-24.
HL_FN float unitFloat(uint bits)
{
    return float(bits >> 8u) * 5.9604644775390625e-8f;
}

// Point of a rank-1 lattice in the unit square (Roberts 2018, the R2 sequence).
HL_FN vec2 r2Point(int number)
{
    // Fractions of 32 bits, as exact for large numbers as for small ones: 0.7548776662 and 0.5698402910.
    uint n = uint(number);
    return vec2(unitFloat(0x80000000u + n * 3242174889u), unitFloat(0x80000000u + n * 2447445413u));
}

HL_NAMESPACE_END

#ifdef __cplusplus
namespace halflight {
using shading::hashCombine;
using shading::hashPcg;
using shading::r2Point;
using shading::unitFloat;
} // namespace halflight
#endif

#endif
