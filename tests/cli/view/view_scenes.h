#pragma once
// Scenes for tests of views, and where a view shows a point.

#include "halflight/scene/scene.h"

#include <cmath>

namespace halflight::cli {

// A box from -half to half; `inward` turns its faces to the inside, `open` leaves the +Z face out.
inline Mesh box(vec3 half, bool inward, bool open)
{
    MeshPart part;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            if (open && axis == 2 && side > 0.0f) continue;
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            const auto first = uint32_t(part.positions.size());
            for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
                vec3 p;
                p[axis] = side * half[axis];
                p[u] = corner.x * half[u];
                p[v] = corner.y * half[v];
                part.positions.push_back(p);
            }
            const bool flip = (side < 0.0f) != inward;
            const uvec3 order = flip ? uvec3(2, 1, 0) : uvec3(0, 1, 2);
            const uvec3 rest = flip ? uvec3(3, 2, 0) : uvec3(0, 2, 3);
            for (int i = 0; i < 3; ++i) part.indices.push_back(first + order[i]);
            for (int i = 0; i < 3; ++i) part.indices.push_back(first + rest[i]);
        }
    }
    Mesh mesh;
    mesh.parts = {part};
    return mesh;
}

inline Scene sceneWith(Mesh mesh, const mat4& worldFromObject = mat4(1.0f))
{
    Scene scene;
    scene.meshes.push_back(std::move(mesh));
    Object object;
    object.mesh = 0;
    object.worldFromObject = worldFromObject;
    scene.objects.push_back(object);
    return scene;
}

inline vec3 eyeOf(const Camera& camera)
{
    return vec3(camera.worldFromCamera[3]);
}
inline vec3 forwardOf(const Camera& camera)
{
    return -vec3(camera.worldFromCamera[2]);
}

// Picture coordinates in [-1, 1] when the point is in view.
inline vec2 project(const Camera& camera, vec3 point, float aspect)
{
    const vec3 p = vec3(glm::inverse(camera.worldFromCamera) * vec4(point, 1.0f));
    const float tangent = std::tan(0.5f * camera.verticalFovRadians);
    return vec2(p.x / (tangent * aspect), p.y / tangent) / -p.z;
}

inline Scene doubleSided(Scene scene)
{
    scene.materials.resize(1);
    scene.materials[0].doubleSided = true;
    for (Mesh& mesh : scene.meshes) {
        for (MeshPart& part : mesh.parts) part.material = 0;
    }
    return scene;
}

inline void add(Scene& scene, Mesh mesh, vec3 position)
{
    Object object;
    object.mesh = int(scene.meshes.size());
    object.worldFromObject[3] = vec4(position, 1.0f);
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
}

} // namespace halflight::cli
