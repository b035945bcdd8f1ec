#include "bake/seams/surface_grid.h"

#include "bake/geometry/smooth_normals.h"
#include "bake/seams/seams.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <cmath>

namespace halflight {
static_assert(shading::kNowhere == kNoTexel);

// Of crossings of a texel's border at one place and in one direction, the first is taken in any case. Loose triangles
// have dozens, as each lies beside many others, and a search among all of them would take longer than all else.
void SurfaceGrid::dropCrowded(std::vector<Crossing>& crossings)
{
    std::size_t kept = 0;
    for (std::size_t i = 0, first = 0; i < crossings.size(); ++i) {
        const Crossing crossing = crossings[i];
        if (i == 0 || crossing.texel != crossings[i - 1].texel) first = kept;
        const auto isSame = [&](const Crossing& other) {
            // In texels; samples of one seam are twice as far apart.
            return glm::distance(crossing.place, other.place) < 0.25f &&
                   glm::dot(crossing.outward, other.outward) > kSmoothCosine;
        };
        const auto begin = crossings.begin() + std::ptrdiff_t(first);
        const auto end = crossings.begin() + std::ptrdiff_t(kept);
        if (std::none_of(begin, end, isSame)) crossings[kept++] = crossing;
    }
    crossings.resize(kept);
}

SurfaceGrid::SurfaceGrid(const TexelMap& map, std::span<const SeamSample> seams) : map_(map), grid_(map)
{
    chartHasSeams_.assign(map.chartCount, 0);
    for (const SeamSample& seam : seams) {
        const mat2 back = glm::inverse(seam.acrossFromA);
        if (!isFinite(seam.acrossFromA) || !isFinite(back)) continue; // a triangle without area
        const vec2 outwardB = -glm::normalize(glm::transpose(back) * seam.outwardA);
        const uint32_t a = grid_.atPlace(uint32_t(seam.pageA), seam.texelA - kInsetTexels * seam.outwardA);
        const uint32_t b = grid_.atPlace(uint32_t(seam.pageB), seam.texelB - kInsetTexels * outwardB);
        if (a == kNoTexel || b == kNoTexel) continue;
        crossings_.push_back({a, b, seam.texelA, seam.outwardA, seam.texelB, seam.acrossFromA});
        crossings_.push_back({b, a, seam.texelB, outwardB, seam.texelA, back});
        chartHasSeams_[map.texels[a].chart] = 1;
        chartHasSeams_[map.texels[b].chart] = 1;
    }
    std::stable_sort(crossings_.begin(), crossings_.end(),
                     [](const Crossing& a, const Crossing& b) { return a.texel < b.texel; });
    dropCrowded(crossings_);
    indexCrossings();
}

void SurfaceGrid::indexCrossings()
{
    firstCrossing_.assign(map_.texels.size() + 1, 0);
    for (const Crossing& crossing : crossings_) ++firstCrossing_[crossing.texel + 1];
    for (std::size_t i = 1; i < firstCrossing_.size(); ++i) firstCrossing_[i] += firstCrossing_[i - 1];
    crossingsAround_.assign(map_.texels.size(), 0);
    for (std::size_t l = 0; l < crossings_.size(); ++l) {
        const uint32_t border = crossings_[l].texel;
        if (l > 0 && crossings_[l - 1].texel == border) continue;
        for (int i = 0; i < 9; ++i) {
            const uint32_t beside = onChart(border, 1 - i % 3, 1 - i / 3);
            if (beside != kNoTexel) crossingsAround_[beside] |= uint16_t(1u << i);
        }
    }
}

SurfaceGrid::Footprint SurfaceGrid::beyond(uint32_t texel, int dx, int dy) const
{
    return shading::footprintBeyond(*this, texel, {dx, dy});
}

uint32_t SurfaceGrid::at(uint32_t texel, int dx, int dy) const
{
    return shading::texelOnSurface(*this, texel, {dx, dy});
}

} // namespace halflight
