#include "bake/geometry/shared_meshes.h"

#include "bake/geometry/flatten.h"

#include <cmath>

namespace halflight {
namespace {

/// Triangles that sharing a mesh leaves out, at least: some 300 bytes each, so 10 MB.
constexpr std::size_t kFewestSaved = 32768;
/// Volume of the unit cube in the world over that of a cube with its longest edge, at least.
constexpr float kFlattest = 1.0e-4f;

bool isFlat(const mat3& linear)
{
    const float longest = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
    return !(std::abs(glm::determinant(linear)) >= kFlattest * longest * longest * longest);
}

} // namespace

vec3 middleOf(const Mesh& mesh)
{
    Bounds bounds;
    for (const MeshPart& part : mesh.parts) {
        for (const vec3 position : part.positions) bounds.extend(position);
    }
    return bounds.empty() ? vec3(0.0f) : 0.5f * (bounds.min + bounds.max);
}

mat3 worldFromNormal(const mat3& linear)
{
    // Normals transform by the inverse transpose. The cofactor matrix is equal up to scale, and also exists for
    // transforms that flatten the object.
    const mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                        glm::cross(linear[0], linear[1]));
    return glm::determinant(linear) < 0.0f ? -cofactor : cofactor;
}

std::vector<std::optional<BakeGeometry::Instance>> shareMeshes(const Scene& scene, int pageSize, GeometryFilter filter)
{
    std::vector<std::optional<BakeGeometry::Instance>> instances(scene.objects.size());
    const auto canShare = [&](const Object& object) {
        return (filter == GeometryFilter::All || object.isStatic) && !isFlat(mat3(object.worldFromObject));
    };
    std::vector<std::size_t> users(scene.meshes.size(), 0);
    for (const Object& object : scene.objects) users[std::size_t(object.mesh)] += canShare(object) ? 1 : 0;
    std::vector<uint8_t> shared(scene.meshes.size(), 0);
    std::vector<vec3> middles(scene.meshes.size());
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        if (users[m] < 2 || (users[m] - 1) * scene.meshes[m].triangleCount() < kFewestSaved) continue;
        shared[m] = 1;
        middles[m] = middleOf(scene.meshes[m]);
    }
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        const auto mesh = std::size_t(object.mesh);
        if (shared[mesh] == 0 || !canShare(object)) continue;
        BakeGeometry::Instance& instance = instances[o].emplace();
        instance.linear = mat3(object.worldFromObject);
        instance.origin = vec3(glm::dmat4(object.worldFromObject) * glm::dvec4(middles[mesh], 1.0));
        instance.worldFromNormal = worldFromNormal(instance.linear);
        instance.mirrored = glm::determinant(instance.linear) < 0.0f;
        instance.texelScale = object.lightmap.scale * float(pageSize);
        instance.texelOffset = object.lightmap.offset * float(pageSize);
    }
    return instances;
}

} // namespace halflight
