#include "transport/sample/light_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

constexpr uint32_t kLeaf = 4;

Bounds boundsOf(const PunctualLight& light)
{
    Bounds bounds;
    bounds.extend(light.position - reachOf(light));
    bounds.extend(light.position + reachOf(light));
    return bounds;
}

} // namespace

float reachOf(const PunctualLight& light)
{
    return 1.001f * light.range;
}

bool mayReach(const PunctualLight& light, const Bounds& box)
{
    if (reachesEverywhere(light)) return true;
    const vec3 nearest = glm::clamp(light.position, box.min, box.max);
    return glm::distance(nearest, light.position) <= reachOf(light);
}

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

std::vector<const PunctualLight*> LightReach::near(std::span<const Bounds> boxes) const
{
    std::vector<const PunctualLight*> found;
    each(boxes, [&](uint32_t number) {
        const PunctualLight* const light = lights_[number];
        if (std::any_of(boxes.begin(), boxes.end(),
                        [&](const Bounds& box) { return halflight::mayReach(*light, box); }))
            found.push_back(light);
    });
    return found;
}

bool LightReach::mayReach(const Bounds& box) const
{
    bool any = false;
    each(std::span(&box, 1), [&](uint32_t number) { any = any || halflight::mayReach(*lights_[number], box); });
    return any;
}

const PunctualLight* LightReach::at(vec3 point) const
{
    auto best = uint32_t(lights_.size());
    each(point, [&](uint32_t number) {
        if (number < best && lights_[number]->reaches(point)) best = number;
    });
    return best < lights_.size() ? lights_[best] : nullptr;
}

} // namespace halflight
