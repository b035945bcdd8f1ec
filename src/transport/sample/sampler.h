#pragma once

#include "halflight/base/math.h"
#include "halflight/shading/random.h"

#include <array>
#include <cstdint>

namespace halflight {

/// Owen-scrambled Sobol' points in the unit square (Sobol' 1967; Burley 2020, "Practical Hash-based Owen Scrambling").
/// Each pair of dimensions is the first two of Sobol', shuffled and scrambled with its own seed. A value is a function
/// of (seed, texel, sample, dimension).
class Sampler {
public:
    Sampler(uint32_t seed, uint32_t texel, uint32_t sample) : texel_(hashCombine(seed, texel)), sample_(sample) {}

    /// The next pair of dimensions.
    vec2 next2()
    {
        const uint32_t seed = hashCombine(texel_, dimension_++);
        const uvec2 bits = scrambledBits(owenScramble(sample_, seed), seed);
        return {unitFloat(bits.x), unitFloat(bits.y)};
    }
    /// The first of the next pair alone.
    float next1()
    {
        const uint32_t seed = hashCombine(texel_, dimension_++);
        return unitFloat(owenScramble(sobolFirst(owenScramble(sample_, seed)), hashPcg(seed + 1u)));
    }

    /// Point `index` of the sequence as 32-bit fractions: scrambled, not shuffled.
    static uvec2 scrambledBits(uint32_t index, uint32_t seed)
    {
        return {owenScramble(sobolFirst(index), hashPcg(seed + 1u)),
                owenScramble(sobolSecond(index), hashPcg(seed + 2u))};
    }

private:
    static uint32_t reverseBits(uint32_t x)
    {
        x = (x << 24) | ((x & 0xff00u) << 8) | ((x >> 8) & 0xff00u) | (x >> 24);
        x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
        x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
        return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
    }
    /// Nested uniform scramble, high bits first (Laine and Karras 2011, with the constants of Vegdahl 2021).
    static uint32_t owenScramble(uint32_t x, uint32_t seed)
    {
        x = reverseBits(x);
        x ^= x * 0x3d20adeau;
        x += seed;
        x *= (seed >> 16) | 1u;
        x ^= x * 0x05526c56u;
        x ^= x * 0x53a22864u;
        return reverseBits(x);
    }
    static uint32_t sobolFirst(uint32_t index) { return reverseBits(index); }
    static uint32_t sobolSecond(uint32_t index)
    {
        return kSobol[0][index & 0xffu] ^ kSobol[1][(index >> 8) & 0xffu] ^ kSobol[2][(index >> 16) & 0xffu] ^
               kSobol[3][index >> 24];
    }

    /// The generator matrix of the second dimension (Pascal's triangle modulo 2), applied to each byte of an index.
    static constexpr std::array<std::array<uint32_t, 256>, 4> makeSobolTable()
    {
        std::array<std::array<uint32_t, 256>, 4> table{};
        uint32_t column = 0x80000000u;
        for (uint32_t bit = 0; bit < 32; ++bit, column ^= column >> 1) {
            for (uint32_t byte = 0; byte < 256; ++byte) {
                if ((byte >> (bit % 8)) & 1u) table[bit / 8][byte] ^= column;
            }
        }
        return table;
    }
    static const std::array<std::array<uint32_t, 256>, 4> kSobol;

    uint32_t texel_;
    uint32_t sample_;
    uint32_t dimension_ = 0;
};

inline constexpr std::array<std::array<uint32_t, 256>, 4> Sampler::kSobol = Sampler::makeSobolTable();

/// Russian roulette (Arvo and Kirk 1990, "Particle Transport and Image Synthesis"): whether a path goes on, with
/// `throughput` raised in proportion.
inline bool survivesRoulette(float probability, Sampler& sampler, vec3& throughput)
{
    if (probability >= 1.0f) return true;
    if (!(sampler.next1() < probability)) return false;
    throughput /= probability;
    return true;
}

} // namespace halflight
