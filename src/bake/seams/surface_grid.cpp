#include "bake/seams/surface_grid.h"

#include "bake/geometry/smooth_normals.h"
#include "bake/seams/seams.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/finite.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <functional>
#include <tuple>

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
    std::vector<Crossing> all = largeVector<Crossing>(2 * seams.size());
    forEachIndex(seams.size(), [&](std::size_t i) { std::tie(all[2 * i], all[2 * i + 1]) = crossingsOf(seams[i]); });
    std::vector<uint64_t> order; // by texel, and in the order of samples
    order.reserve(all.size());
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].texel != kNoTexel) order.push_back(uint64_t(all[i].texel) << 32 | i);
    parallelSort(order, std::less<>());
    crossings_ = largeVector<Crossing>(order.size());
    forEachIndex(order.size(), [&](std::size_t i) { crossings_[i] = all[uint32_t(order[i])]; });
    chartHasSeams_.assign(map.chartCount, 0);
    for (const Crossing& crossing : crossings_) chartHasSeams_[map.texels[crossing.texel].chart] = 1;
    dropCrowded(crossings_);
    indexCrossings();
}

/// A seam sample seen from both sides; without texels where it is of no use.
std::pair<SurfaceGrid::Crossing, SurfaceGrid::Crossing> SurfaceGrid::crossingsOf(const SeamSample& seam) const
{
    Crossing nowhere{};
    nowhere.texel = kNoTexel;
    const mat2 back = glm::inverse(seam.acrossFromA);
    if (!isFinite(seam.acrossFromA) || !isFinite(back)) return {nowhere, nowhere}; // a triangle without area
    const vec2 outwardB = -glm::normalize(glm::transpose(back) * seam.outwardA);
    const uint32_t a = grid_.atPlace(uint32_t(seam.pageA), seam.texelA - kInsetTexels * seam.outwardA);
    const uint32_t b = grid_.atPlace(uint32_t(seam.pageB), seam.texelB - kInsetTexels * outwardB);
    if (a == kNoTexel || b == kNoTexel) return {nowhere, nowhere};
    return {{a, b, seam.texelA, seam.outwardA, seam.texelB, seam.acrossFromA},
            {b, a, seam.texelB, outwardB, seam.texelA, back}};
}

void SurfaceGrid::indexCrossings()
{
    firstCrossing_ = largeVector<uint32_t>(map_.texels.size() + 1);
    parallelFor(firstCrossing_.size(), 65536, [&](std::size_t begin, std::size_t end) {
        auto next = std::ranges::lower_bound(crossings_, begin, {}, &Crossing::texel);
        for (std::size_t i = begin; i < end; ++i) {
            while (next != crossings_.end() && next->texel < i) ++next;
            firstCrossing_[i] = uint32_t(next - crossings_.begin());
        }
    });
    crossingsAround_ = largeVector<uint16_t>(map_.texels.size());
    for (std::size_t l = 0; l < crossings_.size(); ++l) {
        const uint32_t border = crossings_[l].texel;
        if (l > 0 && crossings_[l - 1].texel == border) continue;
        for (int i = 0; i < 9; ++i) {
            const uint32_t beside = shading::texelOnChart(*this, border, ivec2(1 - i % 3, 1 - i / 3));
            if (beside != kNoTexel) crossingsAround_[beside] |= uint16_t(1u << i);
        }
    }
}

} // namespace halflight
