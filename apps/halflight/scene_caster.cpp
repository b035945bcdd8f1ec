#include "scene_caster.h"

#include "halflight/render/frame.h"

#include <cmath>
#include <limits>

namespace halflight::cli {

SceneCaster::SceneCaster(const Scene& scene) : scene_(scene)
{
    std::vector<std::vector<Bounds>> meshBounds;
    for (const Mesh& mesh : scene.meshes) {
        std::vector<Bounds>& parts = meshBounds.emplace_back();
        for (const MeshPart& part : mesh.parts) {
            Bounds& bounds = parts.emplace_back();
            for (const vec3 position : part.positions) bounds.extend(position);
        }
    }
    for (const Object& object : scene.objects) {
        if (object.mesh < 0) continue;
        const float determinant = glm::determinant(mat3(object.worldFromObject));
        if (!(std::abs(determinant) > std::numeric_limits<float>::min())) continue;
        const Mesh& mesh = scene.meshes[std::size_t(object.mesh)];
        for (std::size_t i = 0; i < mesh.parts.size(); ++i) {
            const Material& material = materialOf(scene, mesh.parts[i]);
            if (material.isBlended() && material.coverage(material.baseColor.w, 0.0f, 1.0f) < 0.5f) continue;
            items_.push_back(
                {&mesh.parts[i], meshBounds[std::size_t(object.mesh)][i], glm::inverse(object.worldFromObject)});
        }
    }
}

SceneHit SceneCaster::cast(vec3 origin, vec3 direction) const
{
    SceneHit hit;
    for (const Item& item : items_) {
        // The direction is not normalized in object space, so that distances stay those of the world.
        const vec3 o = vec3(item.objectFromWorld * vec4(origin, 1.0f));
        const vec3 d = mat3(item.objectFromWorld) * direction;
        if (rayReaches(item.bounds, o, d, hit.distance)) castAtPart(item, o, d, hit);
    }
    return hit;
}

// Möller and Trumbore 1997, "Fast, Minimum Storage Ray-Triangle Intersection".
void SceneCaster::castAtPart(const Item& item, vec3 o, vec3 d, SceneHit& hit) const
{
    const MeshPart& part = *item.part;
    const bool doubleSided = materialOf(scene_, part).doubleSided;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        const vec3 a = part.positions[part.indices[i]];
        const vec3 ab = part.positions[part.indices[i + 1]] - a;
        const vec3 ac = part.positions[part.indices[i + 2]] - a;
        const vec3 p = glm::cross(d, ac);
        const float determinant = glm::dot(ab, p);
        if (determinant == 0.0f) continue;
        const vec3 ao = o - a;
        const float u = glm::dot(ao, p) / determinant;
        if (!(u >= 0.0f && u <= 1.0f)) continue;
        const vec3 q = glm::cross(ao, ab);
        const float v = glm::dot(d, q) / determinant;
        if (!(v >= 0.0f && u + v <= 1.0f)) continue;
        const float t = glm::dot(ac, q) / determinant;
        // Seen from object space the front is counter-clockwise, mirrored or not (glTF 2.0, section 3.7.4).
        if (t > 0.0f && t < hit.distance) hit = {t, doubleSided || determinant > 0.0f, doubleSided};
    }
}

} // namespace halflight::cli
