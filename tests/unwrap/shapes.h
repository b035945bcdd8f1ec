#pragma once
// Meshes with known answers.

#include "halflight/scene/scene.h"

#include <functional>
#include <string>

namespace halflight::shapes {

/// A grid of n × m quads over (s, t) in [0,1]². Vertices are shared within the grid.
Mesh grid(int n, int m, const std::function<vec3(float s, float t)>& surface);
Mesh plane(float width = 1.0f, float depth = 1.0f, int n = 1);
/// 24 vertices, hard edges.
Mesh box(vec3 size = vec3(1.0f));
/// Side of `sides` facets, and two caps that are fans.
Mesh cylinder(float radius, float height, int sides);
Mesh sphere(float radius, int rings, int segments);
/// Appends b's parts to a.
Mesh together(Mesh a, const Mesh& b);

/// One object of the mesh, static.
Scene scene(Mesh mesh, const mat4& worldFromObject = mat4(1.0f));
/// Adds an object.
void add(Scene& scene, int mesh, const mat4& worldFromObject);

} // namespace halflight::shapes
