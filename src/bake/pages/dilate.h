#pragma once
// Texels without light of their own: inside geometry, and around charts.

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Fills texels inside geometry (valid 0), from the first of these that exists: adjacent valid texels of the same
/// chart; valid texels of any chart within a few texels in the world, with a similar normal (for charts that are inside
/// but for a sliver); texels farther away on the same chart. Other texels keep their values. `values`: one entry per
/// texel; of several quantities each has the same texels' means.
template<typename T> void fillInvalid(const BakeGeometry& geometry, const TexelMap& map,
                                      const std::vector<uint8_t>& valid, std::span<std::vector<T>* const> values);
template<typename T> void fillInvalid(const BakeGeometry& geometry, const TexelMap& map,
                                      const std::vector<uint8_t>& valid, std::vector<T>& values)
{
    std::vector<T>* const one = &values;
    fillInvalid<T>(geometry, map, valid, std::span(&one, 1));
}

/// Rings of texels that dilation adds around charts: one for bilinear filtering, one more for bicubic. At most the
/// padding: more rings would reach other charts.
constexpr int kDilationRings = 2;
/// Pages with the values of the covered texels, extended into the padding ring by ring. An empty texel gets the
/// weighted mean of its neighbours of one chart; with `extrapolate` the linear extrapolation of pairs of them, which
/// suits distances and not light.
template<typename T>
std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings, bool extrapolate = false);

} // namespace halflight
