#include "bake_cpu/shadows/light_reach.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

constexpr uint32_t kLeaf = 4;
constexpr std::size_t kRun = 64; ///< texels; in the map's order about 8 x 8 neighbours

/// Range with a margin for rounding errors; a light gives nothing beyond its range.
float reachOf(const PunctualLight& light)
{
    return 1.001f * light.range;
}

Bounds boundsOf(const PunctualLight& light)
{
    Bounds bounds;
    bounds.extend(light.position - reachOf(light));
    bounds.extend(light.position + reachOf(light));
    return bounds;
}

bool contains(const Bounds& bounds, vec3 point)
{
    return glm::all(glm::lessThanEqual(bounds.min, point)) && glm::all(glm::lessThanEqual(point, bounds.max));
}

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

bool reachesEverywhere(const PunctualLight& light)
{
    return light.type == shading::kLightDirectional || !(light.range > 0.0f);
}

LightReach::LightReach(std::vector<const PunctualLight*> lights) : lights_(std::move(lights))
{
    for (uint32_t i = 0; i < lights_.size(); ++i) (reachesEverywhere(*lights_[i]) ? everywhere_ : items_).push_back(i);
    if (!items_.empty()) build(0, uint32_t(items_.size()));
}

uint32_t LightReach::build(uint32_t first, uint32_t end)
{
    const auto node = uint32_t(nodes_.size());
    nodes_.emplace_back();
    Bounds bounds;
    Bounds centers;
    for (uint32_t i = first; i < end; ++i) {
        bounds.extend(boundsOf(*lights_[items_[i]]));
        centers.extend(lights_[items_[i]]->position);
    }
    nodes_[node] = {bounds, first, end - first};
    if (end - first <= kLeaf) return node;
    const vec3 size = centers.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t middle = (first + end) / 2;
    std::sort(items_.begin() + first, items_.begin() + end, [&](uint32_t a, uint32_t b) {
        const float pa = lights_[a]->position[axis];
        const float pb = lights_[b]->position[axis];
        return pa != pb ? pa < pb : a < b;
    });
    build(first, middle);
    const uint32_t right = build(middle, end);
    nodes_[node].first = right;
    nodes_[node].count = 0;
    return node;
}

const PunctualLight* LightReach::at(vec3 point) const
{
    auto best = uint32_t(lights_.size());
    const auto consider = [&](uint32_t number) {
        if (number < best && lights_[number]->reaches(point)) best = number;
    };
    for (const uint32_t number : everywhere_) consider(number);
    std::array<uint32_t, 64> stack;
    std::size_t depth = 0;
    if (!nodes_.empty()) stack[depth++] = 0;
    while (depth > 0) {
        const uint32_t index = stack[--depth];
        const Node& node = nodes_[index];
        if (!contains(node.bounds, point)) continue;
        for (uint32_t i = 0; i < node.count; ++i) consider(items_[node.first + i]);
        if (node.count > 0) continue;
        stack[depth++] = node.first;
        stack[depth++] = index + 1;
    }
    return best < lights_.size() ? lights_[best] : nullptr;
}

TexelRuns::TexelRuns(const BakeGeometry& geometry, const TexelMap& map, std::span<const uint32_t> texels)
    : bounds_((texels.size() + kRun - 1) / kRun), count_(texels.size())
{
    parallelFor(bounds_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t run = begin; run < end; ++run) {
            for (std::size_t i = run * kRun; i < std::min((run + 1) * kRun, count_); ++i) {
                const Texel& texel = map.texels[texels[i]];
                for (uint32_t f = 0; f < texel.fragmentCount; ++f)
                    extendByFragment(geometry, map.fragments[texel.firstFragment + f], bounds_[run]);
            }
        }
    });
}

std::vector<uint32_t> TexelRuns::reachedBy(std::span<const PunctualLight* const> lights) const
{
    std::vector<uint32_t> places;
    const auto reaches = [](const PunctualLight* light, const Bounds& bounds) {
        if (reachesEverywhere(*light)) return true;
        const vec3 nearest = glm::clamp(light->position, bounds.min, bounds.max);
        return glm::distance(nearest, light->position) <= reachOf(*light);
    };
    for (std::size_t run = 0; run < bounds_.size(); ++run) {
        const bool any = std::any_of(lights.begin(), lights.end(),
                                     [&](const PunctualLight* light) { return reaches(light, bounds_[run]); });
        if (!any) continue;
        for (std::size_t i = run * kRun; i < std::min((run + 1) * kRun, count_); ++i) places.push_back(uint32_t(i));
    }
    return places;
}

} // namespace halflight
