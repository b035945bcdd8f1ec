// Who casts into a shadow map.
#include "render/frame/frame_internal.h"

#include <algorithm>

namespace halflight {

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
    // Boxes in axes of the light, which shines along -z: a caster's shadow keeps its x and y and goes down from its
    // top.
    const vec3 z = -direction;
    const vec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0), z));
    const mat4 lightFromWorld(glm::transpose(mat3(x, glm::cross(z, x), z)));
    std::vector<Bounds> shadows;
    for (const uint32_t caster : casters) {
        Bounds box = worldBounds(bounds[caster], lightFromWorld);
        if (box.empty()) continue;
        box.min = vec3(box.min.x - marginMeters, box.min.y - marginMeters, -kInfinity);
        box.max += marginMeters;
        shadows.push_back(box);
    }
    std::vector<uint8_t> receivers(bounds.size(), 0);
    for (std::size_t i = 0; i < bounds.size(); ++i) {
        if (bounds[i].empty() || distanceTo(bounds[i], cameraPosition) >= distanceMeters) continue;
        const Bounds box = worldBounds(bounds[i], lightFromWorld);
        receivers[i] = std::any_of(shadows.begin(), shadows.end(), [&](const Bounds& shadow) {
            return glm::all(glm::lessThanEqual(shadow.min, box.max)) &&
                   glm::all(glm::lessThanEqual(box.min, shadow.max));
        });
    }
    return receivers;
}

} // namespace halflight
