#pragma once
// Precomputed stratified sample points of ray bundles.

#include "halflight/base/math.h"
#include "halflight/base/mathematics.h"
#include "halflight/shading/pattern.h"
#include "halflight/shading/sobol.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Stratified points of the unit square in blocks of 16: one point in each stratum of a 4 x 4 grid, in the order of the
/// strata. So the n-th points of neighbouring texels are close, and their rays are coherent. The blocks of one sequence
/// are an Owen-scrambled (0,2)-sequence (Burley 2020, "Practical Hash-based Owen Scrambling"), so all blocks of a texel
/// together are stratified too. A texel takes one of the stored sequences with an XOR shuffle of its coordinates' bits
/// (random digit scrambling: Kollig and Keller 2002, "Efficient Multidimensional Sampling"), which permutes the strata.
class StratifiedPattern {
public:
    static constexpr int kBlock = shading::kPatternBlock;
    static constexpr int kBlocks = shading::kPatternBlocks;
    static constexpr int kSequences = shading::kPatternSequences;

    explicit StratifiedPattern(uint32_t seed) : points_(std::size_t(kBlocks) * kSequences * kBlock)
    {
        for (uint32_t q = 0; q < kSequences; ++q) {
            for (uint32_t i = 0; i < kBlocks * kBlock; ++i) {
                const uvec2 p = shading::scrambledSobol(i, hashCombine(seed, q));
                const uint32_t point = (p.x >> 16) | (p.y & 0xffff0000u);
                points_[((i / kBlock) * kSequences + q) * kBlock + shading::patternStratum(point)] = point;
            }
        }
        for (std::size_t i = 0; i < kAngles; ++i) {
            const float u = (float(i) + 0.5f) / float(kAngles);
            radii_[i] = {std::sqrt(u), std::sqrt(1.0f - u)};
            angles_[i] = {math::cos(2.0f * kPi * u), math::sin(2.0f * kPi * u)};
        }
    }

    /// The points of one texel, one pair of dimensions and one block, by stratum.
    class Block {
    public:
        /// Both coordinates in 16 bits: x low, y high.
        [[nodiscard]] uint32_t bits(int stratum) const
        {
            return points_[uint32_t(stratum) ^ stratumShuffle_] ^ shuffle_;
        }
        [[nodiscard]] vec2 unit(int stratum) const { return shading::patternUnit(bits(stratum)); }

    private:
        friend StratifiedPattern;
        const uint32_t* points_ = nullptr;
        uint32_t shuffle_ = 0;
        uint32_t stratumShuffle_ = 0;
    };
    [[nodiscard]] Block block(uint32_t texelHash, int number) const
    {
        Block b;
        b.points_ = &points_[shading::patternBlockOf(texelHash, number, b.shuffle_)];
        b.stratumShuffle_ = shading::patternStratum(b.shuffle_);
        return b;
    }

    /// The stored points and tables.
    struct Tables {
        std::span<const uint32_t> points; ///< by block, sequence and stratum
        std::span<const vec2> radii;      ///< of direction(): sine and cosine of the angle to +Z
        std::span<const vec2> angles;     ///< cosine and sine of the angle about it
    };
    [[nodiscard]] Tables tables() const { return {points_, radii_, angles_}; }

    /// Cosine-distributed direction about +Z, from tables of 2^11 radii and angles.
    [[nodiscard]] vec3 direction(uint32_t bits) const
    {
        const vec2 r = radii_[(bits & 0xffffu) >> (16 - kAngleBits)];
        const vec2 a = angles_[bits >> (32 - kAngleBits)];
        return {r.x * a.x, r.x * a.y, r.y};
    }

    /// Point `number` of a texel in the unit disc: an Owen-scrambled (0,2)-sequence of squared radius and angle. With
    /// texelPoints() as origins, this mapping leaves less noise in penumbrae than one that preserves the neighbourhoods
    /// of the square.
    [[nodiscard]] vec2 disc(uint32_t texelHash, uint32_t number) const
    {
        const uvec2 bits = shading::scrambledSobol(number, texelHash);
        return radii_[bits.x >> (32 - kAngleBits)].x * angles_[bits.y >> (32 - kAngleBits)];
    }

private:
    static constexpr int kAngleBits = shading::kPatternAngleBits; ///< both tables fit the first-level cache
    static constexpr std::size_t kAngles = std::size_t(1) << kAngleBits;

    std::vector<uint32_t> points_; ///< by block, sequence and stratum
    std::array<vec2, kAngles> radii_;
    std::array<vec2, kAngles> angles_;
};

} // namespace halflight
