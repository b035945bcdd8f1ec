// Values of a texel's neighbours, and ranks among them, as src/bake/denoise/neighbour_values.h has them. They are the
// invocation's own; functions would copy arrays that they are given.
#ifndef HALFLIGHT_BAKE_NEIGHBOUR_VALUES_GLSL
#define HALFLIGHT_BAKE_NEIGHBOUR_VALUES_GLSL

struct NeighbourValues {
    int none;
};

const int kMostNeighbours = 80;
float luminancesOfNeighbours[kMostNeighbours];
float variancesOfNeighbours[kMostNeighbours];

void keepNeighbour(NeighbourValues values, int i, float luminance, float variance)
{
    luminancesOfNeighbours[i] = luminance;
    variancesOfNeighbours[i] = variance;
}

bool luminanceRankIsAbove(NeighbourValues values, int count, int rank, float bound)
{
    int above = 0;
    for (int i = 0; i < count; ++i) above += luminancesOfNeighbours[i] > bound ? 1 : 0;
    return above >= count - rank;
}
bool varianceRankIsAbove(NeighbourValues values, int count, int rank, float bound)
{
    int above = 0;
    for (int i = 0; i < count; ++i) above += variancesOfNeighbours[i] > bound ? 1 : 0;
    return above >= count - rank;
}

// Integers in the order of floats, and back.
uint orderOf(float value)
{
    uint bits = floatBitsToUint(value);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float valueOf(uint order)
{
    return uintBitsToFloat((order & 0x80000000u) != 0u ? order & 0x7fffffffu : ~order);
}

// The value of a rank is found bit by bit: the least one that more than `rank` values do not exceed.
float luminanceOfRank(NeighbourValues values, int count, int rank)
{
    uint order = 0u;
    for (uint bit = 0x80000000u; bit != 0u; bit >>= 1u) {
        int below = 0;
        for (int i = 0; i < count; ++i) below += orderOf(luminancesOfNeighbours[i]) < (order | bit) ? 1 : 0;
        if (below <= rank) order |= bit;
    }
    return valueOf(order);
}
float varianceOfRank(NeighbourValues values, int count, int rank)
{
    uint order = 0u;
    for (uint bit = 0x80000000u; bit != 0u; bit >>= 1u) {
        int below = 0;
        for (int i = 0; i < count; ++i) below += orderOf(variancesOfNeighbours[i]) < (order | bit) ? 1 : 0;
        if (below <= rank) order |= bit;
    }
    return valueOf(order);
}

#endif
