#include "halflight/scene/scene.h"

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
    switch (type) {
    case LightType::Directional:
        return "directional";
    case LightType::Point:
        return "point";
    case LightType::Spot:
        return "spot";
    case LightType::Rectangle:
        return "rectangle";
    case LightType::Disk:
        return "disk";
    }
    return "?";
}

const char* nameOf(LightMode mode)
{
    switch (mode) {
    case LightMode::Realtime:
        return "realtime";
    case LightMode::Mixed:
        return "mixed";
    case LightMode::Baked:
        return "baked";
    }
    return "?";
}

const char* nameOf(MixedLightingMode mode)
{
    switch (mode) {
    case MixedLightingMode::BakedIndirect:
        return "baked-indirect";
    case MixedLightingMode::Shadowmask:
        return "shadowmask";
    case MixedLightingMode::Subtractive:
        return "subtractive";
    }
    return "?";
}

const char* nameOf(EmissionUnit unit)
{
    return unit == EmissionUnit::Blender ? "blender" : "nits";
}

bool movedSinceBake(const Light& light)
{
    if (!light.baking.isBaked || light.baking.bakeType == LightMode::Realtime) return false;
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
