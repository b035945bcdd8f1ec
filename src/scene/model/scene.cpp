#include "halflight/scene/turning_lights.h"

#include <algorithm>

namespace halflight {

std::size_t Mesh::triangleCount() const
{
    std::size_t count = 0;
    for (const MeshPart& part : parts) count += part.triangleCount();
    return count;
}

const char* nameOf(LightType type)
{
    constexpr const char* kNames[] = {"directional", "point", "spot", "rectangle", "disk"};
    return kNames[int(type)];
}

const char* nameOf(LightMode mode)
{
    constexpr const char* kNames[] = {"realtime", "mixed", "baked"};
    return kNames[int(mode)];
}

const char* nameOf(MixedLightingMode mode)
{
    constexpr const char* kNames[] = {"baked-indirect", "shadowmask", "subtractive"};
    return kNames[int(mode)];
}

const char* nameOf(EmissionUnit unit)
{
    return unit == EmissionUnit::Blender ? "blender" : "nits";
}

bool movedSinceBake(const Light& light)
{
    if (!light.baking.isBaked || light.baking.bakeType == LightMode::Realtime || turns(light)) return false;
    constexpr float kTolerance = 1.0e-3f; // metres, and radians of the axis
    const bool positionMatters = light.type != LightType::Directional;
    const bool axisMatters = light.type != LightType::Point;
    const vec3 bakedPosition = vec3(light.baking.worldFromLight[3]);
    const vec3 bakedAxis = -glm::normalize(vec3(light.baking.worldFromLight[2]));
    // A rectangle that is turned by half a turn about its axis is the same.
    const vec3 across =
        glm::cross(glm::normalize(vec3(light.worldFromLight[0])), glm::normalize(vec3(light.baking.worldFromLight[0])));
    if (light.type == LightType::Rectangle && glm::length(across) > kTolerance) return true;
    return (positionMatters && glm::distance(light.position(), bakedPosition) > kTolerance) ||
           (axisMatters && glm::distance(light.direction(), bakedAxis) > kTolerance);
}

Bounds Scene::bounds(bool staticOnly) const
{
    Bounds result;
    for (const Object& object : objects) {
        if (object.mesh < 0 || (staticOnly && !object.isStatic)) continue;
        for (const MeshPart& part : meshes[std::size_t(object.mesh)].parts) {
            for (const vec3& p : part.positions) result.extend(vec3(object.worldFromObject * vec4(p, 1.0f)));
        }
    }
    return result;
}

const Material& defaultMaterial()
{
    static const Material material;
    return material;
}

const Material& materialOf(const Scene& scene, const MeshPart& part)
{
    return part.material >= 0 ? scene.materials[std::size_t(part.material)] : defaultMaterial();
}

bool isDoubleSided(const Scene& scene, const MeshPart& part)
{
    return part.side == SurfaceSide::Both && materialOf(scene, part).doubleSided;
}

bool throwsShadows(const Scene& scene, const Object& object)
{
    if (!object.castShadows || object.mesh < 0) return false;
    const std::vector<MeshPart>& parts = scene.meshes[std::size_t(object.mesh)].parts;
    return std::any_of(parts.begin(), parts.end(),
                       [&](const MeshPart& part) { return materialOf(scene, part).castShadows; });
}

} // namespace halflight
