#pragma once
// A scene of one static floor.

#include "halflight/scene/scene.h"

#include <utility>

namespace halflight::test {

/// A square about the origin, of the scene's material 0, named "floor".
inline void addFloor(Scene& scene, float halfMeters)
{
    const float h = halfMeters;
    MeshPart part;
    part.positions = {vec3(-h, 0, h), vec3(h, 0, h), vec3(h, 0, -h), vec3(-h, 0, -h)};
    part.normals.assign(4, vec3(0, 1, 0));
    part.uv[0] = {vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0)};
    part.indices = {0, 1, 2, 0, 2, 3};
    part.material = 0;
    scene.meshes.emplace_back().parts.push_back(std::move(part));
    Object& floor = scene.objects.emplace_back();
    floor.name = "floor";
    floor.mesh = 0;
}

} // namespace halflight::test
