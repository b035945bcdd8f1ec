// Random numbers of paths: Owen-scrambled Sobol' points in the unit square (Sobol' 1967; Burley 2020, "Practical
// Hash-based Owen Scrambling"). Each pair of dimensions is the first two of Sobol', shuffled and scrambled with its own
// seed. A value is a function of (seed, texel, sample, dimension).
#ifndef HALFLIGHT_SHADING_SOBOL_H
#define HALFLIGHT_SHADING_SOBOL_H

#include "random.h"

HL_NAMESPACE_BEGIN

HL_FN uint reversedBits(uint x)
{
    x = (x << 24u) | ((x & 0xff00u) << 8u) | ((x >> 8u) & 0xff00u) | (x >> 24u);
    x = ((x & 0x0f0f0f0fu) << 4u) | ((x >> 4u) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2u) | ((x >> 2u) & 0x33333333u);
    return ((x & 0x55555555u) << 1u) | ((x >> 1u) & 0x55555555u);
}

// Nested uniform scramble of a number whose bits are reversed (Laine and Karras 2011, with the constants of Vegdahl
// 2021). The result has its bits in order.
HL_FN uint owenScrambleOfReversed(uint x, uint seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reversedBits(x);
}
HL_FN uint owenScramble(uint x, uint seed)
{
    return owenScrambleOfReversed(reversedBits(x), seed);
}

// The second dimension, with its bits reversed: Pascal's triangle modulo 2 times the index. As a polynomial over the
// field of two elements that is p(x + 1), by halves, since (x + 1)^(2^k) is x^(2^k) + 1.
HL_FN uint sobolSecondReversed(uint index)
{
    index ^= index >> 16u;
    index ^= (index & 0xff00ff00u) >> 8u;
    index ^= (index & 0xf0f0f0f0u) >> 4u;
    index ^= (index & 0xccccccccu) >> 2u;
    return index ^ ((index & 0xaaaaaaaau) >> 1u);
}

// Both coordinates of point `index` as fractions of 32 bits: scrambled, not shuffled.
HL_FN uint scrambledSobolFirst(uint index, uint seed)
{
    return owenScrambleOfReversed(index, hashPcg(seed + 1u)); // the first dimension is the index with reversed bits
}
HL_FN uvec2 scrambledSobol(uint index, uint seed)
{
    return uvec2(scrambledSobolFirst(index, seed),
                 owenScrambleOfReversed(sobolSecondReversed(index), hashPcg(seed + 2u)));
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
    uvec2 bits = scrambledSobol(index, seed);
    return vec2(unitFloat(bits.x), unitFloat(bits.y));
}

// The first of the next pair alone.
HL_FN float nextNumber(HL_INOUT(PathSampler) numbers)
{
    uint seed = hashCombine(numbers.texel, numbers.dimension);
    numbers.dimension += 1u;
    return unitFloat(scrambledSobolFirst(owenScramble(numbers.number, seed), seed));
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
