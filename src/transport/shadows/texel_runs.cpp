#include "transport/shadows/texel_runs.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

/// Extends bounds by a box around a fragment's centroid that contains the texel's square on the fragment's triangle.
void extendByFragment(const BakeGeometry& geometry, const TexelFragment& fragment, Bounds& bounds)
{
    const std::array<vec3, 3> corners = geometry.cornersOf(fragment.triangle);
    const std::array<vec2, 3> texels = geometry.texelsOf(fragment.triangle);
    const vec3 edge1 = corners[1] - corners[0];
    const vec3 edge2 = corners[2] - corners[0];
    const vec2 texel1 = texels[1] - texels[0];
    const vec2 texel2 = texels[2] - texels[0];
    const float area = cross2(texel1, texel2);
    const vec3 center = corners[0] + fragment.barycentric.x * edge1 + fragment.barycentric.y * edge2;
    // Sum of the absolute steps of one texel along both axes: twice the half size of the square.
    const vec3 half = (glm::abs(edge1 * texel2.y - edge2 * texel1.y) + glm::abs(edge2 * texel1.x - edge1 * texel2.x)) /
                      std::abs(area);
    if (!(half.x + half.y + half.z < kInfinity)) {
        bounds.extend(geometry.boundsOf(fragment.triangle));
        return;
    }
    bounds.extend(center - half);
    bounds.extend(center + half);
}

} // namespace

TexelRuns::TexelRuns(const BakeGeometry& geometry, const TexelMap& map, std::span<const uint32_t> texels)
    : bounds_((texels.size() + kTexels - 1) / kTexels), count_(texels.size())
{
    parallelFor(bounds_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t run = begin; run < end; ++run) {
            for (std::size_t i = run * kTexels; i < std::min((run + 1) * kTexels, count_); ++i) {
                const Texel& texel = map.texels[texels[i]];
                for (uint32_t f = 0; f < texel.fragmentCount; ++f)
                    extendByFragment(geometry, map.fragments[texel.firstFragment + f], bounds_[run]);
            }
        }
    });
}

std::vector<uint32_t> TexelRuns::reachedBy(std::span<const PunctualLight* const> lights, std::size_t firstRun,
                                           std::size_t endRun) const
{
    std::vector<uint32_t> places;
    for (std::size_t run = firstRun; run < endRun; ++run) {
        const bool any = std::any_of(lights.begin(), lights.end(),
                                     [&](const PunctualLight* light) { return mayReach(*light, bounds_[run]); });
        if (!any) continue;
        for (std::size_t i = run * kTexels; i < std::min((run + 1) * kTexels, count_); ++i)
            places.push_back(uint32_t(i));
    }
    return places;
}

} // namespace halflight
