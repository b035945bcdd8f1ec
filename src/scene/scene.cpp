#include "halflight/scene/scene.h"

namespace halflight {

const char* nameOf(LightType type)
{
    switch (type) {
    case LightType::Directional:
        return "directional";
    case LightType::Point:
        return "point";
    case LightType::Spot:
        return "spot";
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

} // namespace halflight
