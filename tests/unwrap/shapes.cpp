#include "shapes.h"

#include <cmath>

namespace halflight::shapes {
namespace {

/// Smooth normals, weighted by area.
void computeNormals(MeshPart& part)
{
    part.normals.assign(part.positions.size(), vec3(0.0f));
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        const vec3 a = part.positions[part.indices[i]], b = part.positions[part.indices[i + 1]];
        const vec3 normal = glm::cross(b - a, part.positions[part.indices[i + 2]] - a);
        for (std::size_t k = 0; k < 3; ++k) part.normals[part.indices[i + k]] += normal;
    }
    for (vec3& n : part.normals) n = glm::length(n) > 0.0f ? glm::normalize(n) : vec3(0.0f, 1.0f, 0.0f);
}

} // namespace

Mesh grid(int n, int m, const std::function<vec3(float, float)>& surface)
{
    MeshPart part;
    for (int j = 0; j <= m; ++j) {
        for (int i = 0; i <= n; ++i) part.positions.push_back(surface(float(i) / float(n), float(j) / float(m)));
    }
    for (int j = 0; j < m; ++j) {
        for (int i = 0; i < n; ++i) {
            const auto a = uint32_t(j * (n + 1) + i), b = a + 1, c = a + uint32_t(n) + 1, d = c + 1;
            for (const uint32_t v : {a, b, d, a, d, c}) part.indices.push_back(v);
        }
    }
    computeNormals(part);
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    return mesh;
}

Mesh plane(float width, float depth, int n)
{
    return grid(n, n, [&](float s, float t) { return vec3((s - 0.5f) * width, 0.0f, (0.5f - t) * depth); });
}

Mesh box(vec3 size)
{
    MeshPart part;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-0.5f, 0.5f}) {
            const auto first = uint32_t(part.positions.size());
            vec3 n(0.0f), u(0.0f), v(0.0f);
            n[axis] = side;
            u[(axis + 1) % 3] = 0.5f;
            v[(axis + 2) % 3] = side > 0.0f ? 0.5f : -0.5f;
            for (const vec3 corner : {n - u - v, n + u - v, n + u + v, n - u + v}) {
                part.positions.push_back(corner * size);
                part.normals.push_back(glm::normalize(n));
            }
            for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + i);
        }
    }
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    return mesh;
}

Mesh cylinder(float radius, float height, int sides)
{
    const auto rim = [&](float s, float y) {
        const float angle = -2.0f * kPi * s;
        const bool closing = s == 1.0f; // exactly where it began
        return vec3(closing ? radius : radius * std::cos(angle), y, closing ? 0.0f : radius * std::sin(angle));
    };
    Mesh mesh = grid(sides, 1, [&](float s, float t) { return rim(s, t * height); });
    for (const float y : {0.0f, height}) {
        MeshPart cap;
        cap.positions.push_back({0.0f, y, 0.0f});
        for (int i = 0; i < sides; ++i) cap.positions.push_back(rim(float(i) / float(sides), y));
        for (int i = 0; i < sides; ++i) {
            const auto a = uint32_t(1 + i), b = uint32_t(1 + (i + 1) % sides);
            for (const uint32_t v : {0u, y > 0.0f ? a : b, y > 0.0f ? b : a}) cap.indices.push_back(v);
        }
        computeNormals(cap);
        mesh.parts.push_back(std::move(cap));
    }
    return mesh;
}

Mesh sphere(float radius, int rings, int segments)
{
    return grid(segments, rings, [&](float s, float t) {
        const float phi = s == 1.0f ? 0.0f : -2.0f * kPi * s, theta = kPi * t;
        const float sine = t == 0.0f || t == 1.0f ? 0.0f : std::sin(theta);
        return radius * vec3(sine * std::cos(phi), -std::cos(theta), sine * std::sin(phi));
    });
}

Mesh together(Mesh a, const Mesh& b)
{
    a.parts.insert(a.parts.end(), b.parts.begin(), b.parts.end());
    return a;
}

Scene scene(Mesh mesh, const mat4& worldFromObject)
{
    Scene scene;
    mesh.sourceMesh = 0;
    scene.meshes.push_back(std::move(mesh));
    add(scene, 0, worldFromObject);
    return scene;
}

void add(Scene& scene, int mesh, const mat4& worldFromObject)
{
    Object object;
    object.name = "object " + std::to_string(scene.objects.size());
    object.mesh = mesh;
    object.worldFromObject = worldFromObject;
    scene.objects.push_back(object);
}

} // namespace halflight::shapes
