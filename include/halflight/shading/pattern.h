// Stratified sample points of texels: which of the stored ones a texel takes (transport/random/stratified_pattern.h).
#ifndef HALFLIGHT_SHADING_PATTERN_H
#define HALFLIGHT_SHADING_PATTERN_H

#include "random.h"

HL_NAMESPACE_BEGIN

HL_CONST int kPatternBlock = 16;     // samples of a block, one for each stratum
HL_CONST int kPatternBlocks = 64;    // of a stored sequence; later blocks take another sequence
HL_CONST int kPatternSequences = 32; // a power of two
HL_CONST int kPatternAngleBits = 11; // of the tables of radii and angles: steps of 0.2 degrees

// Points are both coordinates in 16 bits: x low, y high. The stratum is a place of a 4 x 4 grid.
HL_FN uint patternStratum(uint point)
{
    return ((point >> 12u) & 0xcu) | (point >> 30u);
}

// Where the points of block `number` of a texel begin among the stored ones. `shuffle`: XOR of their bits, and by
// patternStratum() of their order.
HL_FN uint patternBlockOf(uint texelHash, int number, HL_INOUT(uint) shuffle)
{
    shuffle = hashCombine(texelHash, uint(number / kPatternBlocks));
    uint sequence = hashPcg(shuffle) & uint(kPatternSequences - 1);
    return (uint(number % kPatternBlocks) * uint(kPatternSequences) + sequence) * uint(kPatternBlock);
}

HL_FN vec2 patternUnit(uint point)
{
    return (vec2(float(point & 0xffffu), float(point >> 16u)) + 0.5f) * 1.52587890625e-5f;
}

// Half of a block that a stratum belongs to: each half has two strata of each row and column.
HL_FN uint patternHalf(uint stratum)
{
    return ((stratum >> 2u) ^ (stratum >> 1u)) & 1u;
}

// Index of the point of a texel that the ray of a stratum starts from. A block uses each of 16 points once, and over 16
// blocks each stratum uses all points. Fewer points are used equally often over the blocks.
HL_FN int gatherPointOf(uint texelId, int pointCount, int block, int stratum)
{
    int number = (stratum ^ (block * 11) ^ int(texelId * 0x9e3779b9u >> 28u)) & (kPatternBlock - 1);
    return pointCount == kPatternBlock ? number : (block * kPatternBlock + number) % pointCount;
}

// Whether a texel that takes `samples` samples of a block's sources, in quarters of it, takes one in a stratum: each
// quarter of a block is one stratum in each row and column of the pattern.
HL_FN bool takesSourceSample(int samples, int block, int stratum)
{
    int diagonal = ((stratum >> 2) ^ stratum ^ block) & 3;
    int quarter = ((diagonal & 1) << 1) | (diagonal >> 1); // two quarters are every other diagonal
    return quarter * (kPatternBlock / 4) < samples;
}

// Position of a stratum, 0...15, in an order whose first strata are spread evenly: every pair has one stratum in each
// half of the block, every four one in each row and column. Over four blocks the first four of each are all strata. The
// order is that of a (0,2)-sequence (Sobol' 1967, "On the Distribution of Points in a Cube and the Approximate
// Evaluation of Integrals").
HL_FN int patternOrder(int stratum, int block)
{
    // The sequence's first coordinate is the row and has the low bits of the number; the second is the column.
    int bit0 = stratum >> 3 & 1;
    int bit1 = stratum >> 2 & 1;
    int bit3 = (stratum & 1) ^ bit1;
    int bit2 = (stratum >> 1 & 1) ^ bit0 ^ bit1 ^ bit3;
    return ((bit0 | bit1 << 1 | bit2 << 2 | bit3 << 3) - 4 * block) & (kPatternBlock - 1);
}

// How many of a block's strata take a sample that has a probability; `bits` are random, for what is left over.
HL_FN int strataOfShare(float probability, uint bits)
{
    return min(int(probability * float(kPatternBlock) + unitFloat(bits)), kPatternBlock);
}

// XOR shuffle of the strata of a texel that samples only some of a block's: each texel samples other parts of the unit
// square in the same strata. Rows and columns of the pattern remain such.
HL_FN int strataShuffle(uint texelId)
{
    return int(hashCombine(0x5eed0011u, texelId) & uint(kPatternBlock - 1));
}

HL_NAMESPACE_END

#endif
