// Random numbers of paths: Owen-scrambled Sobol' points in the unit square (Sobol' 1967; Burley 2020, "Practical
// Hash-based Owen Scrambling"). Each pair of dimensions is the first two of Sobol', shuffled and scrambled with its own
// seed. A value is a function of (seed, texel, sample, dimension).
#ifndef HALFLIGHT_SHADING_SOBOL_H
#define HALFLIGHT_SHADING_SOBOL_H

#include "random.h"

HL_NAMESPACE_BEGIN

HL_FN uint reverseBits(uint x)
{
    x = (x << 24u) | ((x & 0xff00u) << 8u) | ((x >> 8u) & 0xff00u) | (x >> 24u);
    x = ((x & 0x0f0f0f0fu) << 4u) | ((x >> 4u) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2u) | ((x >> 2u) & 0x33333333u);
    return ((x & 0x55555555u) << 1u) | ((x >> 1u) & 0x55555555u);
}

// Nested uniform scramble, high bits first (Laine and Karras 2011, with the constants of Vegdahl 2021).
HL_FN uint owenScramble(uint x, uint seed)
{
    x = reverseBits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

// Point `index` of the sequence as 32-bit fractions. The generator matrix of the second dimension is Pascal's triangle
// modulo 2, a Kronecker power of (1 1; 0 1): one step for each of its five factors.
HL_FN uint sobolFirst(uint index)
{
    return reverseBits(index);
}
HL_FN uint sobolSecond(uint index)
{
    uint x = reverseBits(index);
    x ^= x << 16u;
    x ^= (x & 0x00ff00ffu) << 8u;
    x ^= (x & 0x0f0f0f0fu) << 4u;
    x ^= (x & 0x33333333u) << 2u;
    return x ^ (x & 0x55555555u) << 1u;
}

// Scrambled, not shuffled.
HL_FN uint scrambledFirst(uint index, uint seed)
{
    return owenScramble(sobolFirst(index), hashPcg(seed + 1u));
}
HL_FN uint scrambledSecond(uint index, uint seed)
{
    return owenScramble(sobolSecond(index), hashPcg(seed + 2u));
}

struct PathSampler {
    uint texel; // hashed with the seed
    uint number;
    uint dimension; // the next one
};

HL_FN PathSampler pathSampler(uint seed, uint texel, uint number)
{
    PathSampler numbers;
    numbers.texel = hashCombine(seed, texel);
    numbers.number = number;
    numbers.dimension = 0u;
    return numbers;
}

// The next pair of dimensions.
HL_FN vec2 nextPair(HL_INOUT(PathSampler) numbers)
{
    uint seed = hashCombine(numbers.texel, numbers.dimension);
    numbers.dimension += 1u;
    uint index = owenScramble(numbers.number, seed);
    return vec2(unitFloat(scrambledFirst(index, seed)), unitFloat(scrambledSecond(index, seed)));
}

// The first of the next pair alone.
HL_FN float nextNumber(HL_INOUT(PathSampler) numbers)
{
    uint seed = hashCombine(numbers.texel, numbers.dimension);
    numbers.dimension += 1u;
    return unitFloat(scrambledFirst(owenScramble(numbers.number, seed), seed));
}

// Russian roulette (Arvo and Kirk 1990, "Particle Transport and Image Synthesis"): whether a path goes on, with
// `throughput` raised in proportion.
HL_FN bool survivesRoulette(float probability, HL_INOUT(PathSampler) numbers, HL_INOUT(vec3) throughput)
{
    if (probability >= 1.0f) return true;
    if (!(nextNumber(numbers) < probability)) return false;
    throughput /= probability;
    return true;
}

// Probability of sampling lights that give about `emitted` (lux) beside other light (the same source).
HL_FN float rouletteSurvival(float emitted, float otherIlluminance)
{
    float least = 0.1f; // of the probability, and the share of other light from which on it is 1
    return otherIlluminance > 0.0f ? clamp(emitted / (least * otherIlluminance), least, 1.0f) : 1.0f;
}

HL_NAMESPACE_END

#endif
