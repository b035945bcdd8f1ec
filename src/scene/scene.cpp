#include "halflight/scene/scene.h"

namespace halflight {

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
