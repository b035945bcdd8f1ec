#pragma once
// Lightmap pages of a bake that runs: light by texel, and rectangles of what changed.

#include "halflight/bake/bake_session.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

class LivePages {
public:
    /// The map outlives it.
    explicit LivePages(const TexelMap& map);

    /// Light of single texels, lux, spread over all texels of their charts' surroundings: each texel gets the weighted
    /// mean of those in the squares of `side` texels around it. There is one of each chart in each square that it has
    /// texels in (sampleTexels()).
    void spread(std::span<const uint32_t> texels, std::span<const vec3> light, int side);
    void set(uint32_t texel, vec3 light);
    [[nodiscard]] float brightest() const;

    /// Whole pages, RGB9E5 in units of `unitLux`; nothing has changed afterwards.
    std::vector<Image<uint32_t>> takeAll(float unitLux);
    /// What has changed since.
    std::vector<LightTile> takeChanged(float unitLux);

private:
    static constexpr int kBlock = 64; ///< texels along a side of what changes at once
    [[nodiscard]] LightTile tileOf(int page, ivec2 begin, ivec2 end, float unitLux) const;

    const TexelMap& map_;
    std::vector<vec3> light_;             ///< by texel, lux
    std::vector<Image<uint32_t>> texels_; ///< by page: the texel whose light is shown at a place, or kNoTexel
    int blocks_ = 0;                      ///< along a side of a page
    std::vector<uint8_t> changed_;        ///< by page, row and column of blocks
};

/// A texel of each chart in each square of `side` texels (a power of two) of each page: the one nearest to the middle
/// of the chart's texels there. In the order of the squares.
std::vector<uint32_t> sampleTexels(const TexelMap& map, int side);

} // namespace halflight
