#pragma once
// Sample points for bundles of rays: made once, looked up millions of times.

#include "bake_cpu/sample/sampler.h"

#include "halflight/base/math.h"
#include "halflight/base/random.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace halflight {

/// Points of the unit square in blocks of 16. Each block has one point in each cell of a 4 x 4 grid and is sorted by
/// cell, so that the n-th points of neighbouring texels lie near one another: their rays travel together. Blocks follow
/// one another as an Owen-scrambled (0,2)-sequence (Burley 2020, "Practical Hash-based Owen Scrambling"), so that all
/// blocks of a texel together are well spread too. A texel picks one of the stored sequences and flips bits of its
/// coordinates (random digit scrambling: Kollig and Keller 2002, "Efficient Multidimensional Sampling"), which keeps
/// every cell's share.
class StratifiedPattern {
public:
    static constexpr int kBlock = 16;
    static constexpr int kBlocks = 64;    ///< in a stored sequence; more blocks begin another sequence
    static constexpr int kSequences = 32; ///< a power of two

    explicit StratifiedPattern(uint32_t seed) : points_(std::size_t(kBlocks) * kSequences * kBlock)
    {
        for (uint32_t q = 0; q < kSequences; ++q) {
            for (uint32_t i = 0; i < kBlocks * kBlock; ++i) {
                const uvec2 p = Sampler::scrambledBits(i, hashCombine(seed, q));
                const uint32_t point = (p.x >> 16) | (p.y & 0xffff0000u);
                points_[((i / kBlock) * kSequences + q) * kBlock + cellOf(point)] = point;
            }
        }
        for (std::size_t i = 0; i < kAngles; ++i) {
            const float u = (float(i) + 0.5f) / float(kAngles);
            radii_[i] = {std::sqrt(u), std::sqrt(1.0f - u)};
            angles_[i] = {std::cos(2.0f * kPi * u), std::sin(2.0f * kPi * u)};
        }
    }

    /// The points of one texel, one pair of dimensions and one block, in order of their cells.
    class Block {
    public:
        /// Both coordinates in 16 bits: x low, y high.
        [[nodiscard]] uint32_t bits(int cell) const { return points_[uint32_t(cell) ^ cellFlip_] ^ flip_; }
        [[nodiscard]] vec2 unit(int cell) const
        {
            const uint32_t p = bits(cell);
            return (vec2(float(p & 0xffffu), float(p >> 16)) + 0.5f) * 0x1.0p-16f;
        }

    private:
        friend StratifiedPattern;
        const uint32_t* points_ = nullptr;
        uint32_t flip_ = 0;
        uint32_t cellFlip_ = 0;
    };
    [[nodiscard]] Block block(uint32_t texelHash, int number) const
    {
        const uint32_t h = hashCombine(texelHash, uint32_t(number / kBlocks));
        Block b;
        b.points_ = &points_[(std::size_t(number % kBlocks) * kSequences + (hashPcg(h) & (kSequences - 1))) * kBlock];
        b.flip_ = h;
        b.cellFlip_ = cellOf(h);
        return b;
    }

    /// Cosine-distributed direction about +Z. The tables' steps are far below what a block of samples resolves.
    [[nodiscard]] vec3 direction(uint32_t bits) const
    {
        const vec2 r = radii_[(bits & 0xffffu) >> (16 - kAngleBits)];
        const vec2 a = angles_[bits >> (32 - kAngleBits)];
        return {r.x * a.x, r.x * a.y, r.y};
    }

    /// Where a few cells of a block are to stand for all of them, those of the lowest ranks, 0 … kBlock - 1, are well
    /// spread, half of them in either half; over four blocks a quarter of each is all of them. Cells in the order of a
    /// (0,2)-sequence (Sobol' 1967, "On the Distribution of Points in a Cube and the Approximate Evaluation of
    /// Integrals").
    static int strataOrder(int cell, int block)
    {
        // The sequence's first coordinate is the cell's row, which tells the low bits of the number; the second one,
        // its column, the others.
        const int bit0 = cell >> 3 & 1;
        const int bit1 = cell >> 2 & 1;
        const int bit3 = (cell & 1) ^ bit1;
        const int bit2 = (cell >> 1 & 1) ^ bit0 ^ bit1 ^ bit3;
        return ((bit0 | bit1 << 1 | bit2 << 2 | bit3 << 3) - 4 * block) & (kBlock - 1);
    }

    /// The n-th of a texel's points of the unit disc: an Owen-scrambled (0,2)-sequence, one coordinate the squared
    /// radius, the other the angle. Beside the lattice of texelPoints() these leave less noise in penumbrae than points
    /// that keep the square's neighbourhoods.
    [[nodiscard]] vec2 disc(uint32_t texelHash, uint32_t number) const
    {
        const uvec2 bits = Sampler::scrambledBits(number, texelHash);
        return radii_[bits.x >> (32 - kAngleBits)].x * angles_[bits.y >> (32 - kAngleBits)];
    }

private:
    static constexpr int kAngleBits = 11;
    static constexpr std::size_t kAngles = std::size_t(1) << kAngleBits;
    static uint32_t cellOf(uint32_t point) { return ((point >> 12) & 0xcu) | (point >> 30); }

    std::vector<uint32_t> points_; ///< by block, sequence and cell
    std::array<vec2, kAngles> radii_;
    std::array<vec2, kAngles> angles_;
};

} // namespace halflight
