// Who casts into a shadow map.
#include "render/frame/frame_internal.h"

#include <algorithm>

namespace halflight {

namespace {

/// Where the centre of `moving` is when it touches `box` or comes closer than the margin: their Minkowski sum, grown.
Bounds sumOf(const Bounds& box, const Bounds& moving, float margin)
{
    const vec3 half = 0.5f * (moving.max - moving.min) + margin;
    return {box.min - half, box.max + half};
}

/// Slabs: Kay and Kajiya 1986, "Ray Tracing Complex Scenes".
bool rayMeets(vec3 origin, vec3 direction, const Bounds& box)
{
    float enter = 0.0f;
    float leave = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0.0f) {
            if (origin[axis] < box.min[axis] || origin[axis] > box.max[axis]) return false;
            continue;
        }
        const float a = (box.min[axis] - origin[axis]) / direction[axis];
        const float b = (box.max[axis] - origin[axis]) / direction[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

} // namespace

std::vector<uint32_t> castersOfTile(const Scene& scene, std::span<const Bounds> bounds, const LightVolume& volume,
                                    bool staticCasters, const mat4& clipFromWorld)
{
    const Planes planes = planesOf(clipFromWorld);
    std::vector<uint32_t> casters;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (!throwsShadows(scene, object) || (object.isStatic && !staticCasters)) continue;
        if (meets(volume, bounds[i]) && meets(planes, bounds[i])) casters.push_back(uint32_t(i));
    }
    return casters;
}

std::vector<uint8_t> directionalShadowReceivers(std::span<const Bounds> bounds, std::span<const uint32_t> casters,
                                                vec3 direction, float marginMeters, vec3 cameraPosition,
                                                float distanceMeters)
{
    std::vector<uint8_t> receivers(bounds.size(), 0);
    for (std::size_t i = 0; i < bounds.size(); ++i) {
        if (bounds[i].empty() || distanceTo(bounds[i], cameraPosition) >= distanceMeters) continue;
        receivers[i] = std::any_of(casters.begin(), casters.end(), [&](uint32_t caster) {
            return rayMeets(bounds[caster].center(), direction, sumOf(bounds[i], bounds[caster], marginMeters));
        });
    }
    return receivers;
}

} // namespace halflight
