#include "bake/seams/surface_grid.h"

#include "bake/geometry/smooth_normals.h"
#include "bake/seams/seams.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace halflight {
namespace {

/// Charts that a line to a neighbour may cross: tiles of a texel or two have more, and lose their farthest neighbours.
constexpr int kMostSeams = 8;

vec2 centreOf(const Texel& texel)
{
    return vec2(texel.x, texel.y) + 0.5f;
}

} // namespace

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

/// The seam that a line to `to` crosses where it leaves the chart at `exit`, beside `texel`: the nearest one that has
/// `to` on its other side.
const SurfaceGrid::Crossing* SurfaceGrid::crossingNear(uint32_t texel, vec2 exit, vec2 to) const
{
    const Crossing* nearest = nullptr;
    float least = kInfinity;
    for (uint32_t left = crossingsAround_[texel]; left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        const uint32_t border = onChart(texel, i % 3 - 1, i / 3 - 1);
        for (uint32_t l = firstCrossing_[border]; l < firstCrossing_[border + 1]; ++l) {
            const Crossing& crossing = crossings_[l];
            const float distance = glm::dot(crossing.place - exit, crossing.place - exit);
            if (distance >= least || glm::dot(to - crossing.place, crossing.outward) <= 0.0f) continue;
            least = distance;
            nearest = &crossing;
        }
    }
    return nearest;
}

std::optional<SurfaceGrid::ChartPlace> SurfaceGrid::placeBeyond(uint32_t texel, int dx, int dy) const
{
    if (!chartHasSeams_[map_.texels[texel].chart]) return std::nullopt;
    vec2 from = centreOf(map_.texels[texel]);
    vec2 to = from + vec2(dx, dy);
    for (int seam = 0; seam <= kMostSeams; ++seam) {
        const Texel& start = map_.texels[texel];
        const vec2 line = to - from;
        const int steps = std::max(1, int(std::ceil(std::max(std::abs(line.x), std::abs(line.y)))));
        int step = 1;
        for (; step <= steps; ++step) {
            const uint32_t next = grid_.atPlace(start, from + line * (float(step) / float(steps)));
            if (next == kNoTexel) break;
            texel = next;
        }
        if (step > steps) return ChartPlace{to, texel};
        const Crossing* crossing = crossingNear(texel, from + line * ((float(step) - 0.5f) / float(steps)), to);
        if (crossing == nullptr) return std::nullopt;
        to = crossing->targetPlace + crossing->across * (to - crossing->place);
        from = crossing->targetPlace;
        texel = crossing->target;
    }
    return std::nullopt;
}

SurfaceGrid::Footprint SurfaceGrid::beyond(uint32_t texel, int dx, int dy) const
{
    Footprint footprint;
    const std::optional<ChartPlace> found = placeBeyond(texel, dx, dy);
    if (!found) return footprint;
    const vec2 base = glm::floor(found->place - 0.5f);
    const vec2 f = found->place - 0.5f - base;
    for (int i = 0; i < 4; ++i) {
        const float weight = ((i & 1) ? f.x : 1.0f - f.x) * ((i >> 1) ? f.y : 1.0f - f.y);
        const uint32_t other = grid_.atPlace(map_.texels[found->texel], base + vec2(i & 1, i >> 1) + 0.5f);
        if (other == kNoTexel || weight <= 0.0f) continue;
        footprint.texels[footprint.count] = other;
        footprint.weights[footprint.count++] = weight;
    }
    return footprint;
}

uint32_t SurfaceGrid::at(uint32_t texel, int dx, int dy) const
{
    const uint32_t own = onChart(texel, dx, dy);
    if (own != kNoTexel) return own;
    const std::optional<ChartPlace> found = placeBeyond(texel, dx, dy);
    const uint32_t other = found ? grid_.atPlace(map_.texels[found->texel], found->place) : kNoTexel;
    return other != texel ? other : kNoTexel; // round a closed surface
}

} // namespace halflight
