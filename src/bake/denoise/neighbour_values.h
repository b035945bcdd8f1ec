#pragma once
// Values of a texel's neighbours, and ranks among them. shaders/bake/neighbour_values.glsl does the same.

#include <algorithm>
#include <array>

namespace halflight::shading {

constexpr int kMostNeighbours = 80; ///< 9 × 9 without the middle

struct NeighbourValues {
    std::array<float, kMostNeighbours> luminances; ///< lux
    std::array<float, kMostNeighbours> variances;  ///< lux²
};

inline void keepNeighbour(NeighbourValues& values, int i, float luminance, float variance)
{
    values.luminances[std::size_t(i)] = luminance;
    values.variances[std::size_t(i)] = variance;
}

/// The value of the given rank among the first `count`, in ascending order.
inline float valueOfRank(const std::array<float, kMostNeighbours>& values, int count, int rank)
{
    std::array<float, kMostNeighbours> sorted;
    const auto end = std::copy(values.begin(), values.begin() + count, sorted.begin());
    std::nth_element(sorted.begin(), sorted.begin() + rank, end);
    return sorted[std::size_t(rank)];
}
inline float luminanceOfRank(const NeighbourValues& values, int count, int rank)
{
    return valueOfRank(values.luminances, count, rank);
}
inline float varianceOfRank(const NeighbourValues& values, int count, int rank)
{
    return valueOfRank(values.variances, count, rank);
}

/// valueOfRank() > bound, in one pass.
inline bool rankIsAbove(const std::array<float, kMostNeighbours>& values, int count, int rank, float bound)
{
    const auto above = std::count_if(values.begin(), values.begin() + count, [&](float v) { return v > bound; });
    return above >= std::ptrdiff_t(count - rank);
}
inline bool luminanceRankIsAbove(const NeighbourValues& values, int count, int rank, float bound)
{
    return rankIsAbove(values.luminances, count, rank, bound);
}
inline bool varianceRankIsAbove(const NeighbourValues& values, int count, int rank, float bound)
{
    return rankIsAbove(values.variances, count, rank, bound);
}

} // namespace halflight::shading
