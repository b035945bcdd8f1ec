#include "bake/stages.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace halflight {

vec3 BakeGeometry::geometricNormal(uint32_t triangle) const
{
    const uvec3 t = triangles[triangle];
    const vec3 n = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
    const float length = glm::length(n);
    return length > 0.0f ? n / length : vec3(0.0f);
}

float BakeGeometry::texelMeters(uint32_t triangle) const
{
    const uvec3 t = triangles[triangle];
    const vec2 a = lightmapTexel[t.y] - lightmapTexel[t.x];
    const vec2 b = lightmapTexel[t.z] - lightmapTexel[t.x];
    const float texels = std::abs(cross2(a, b));
    const float meters2 = glm::length(glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]));
    constexpr float kLeast = 1.0e-12f; // slivers' widths stay numbers
    return texels > 0.0f ? std::sqrt(meters2 / std::max(texels, kLeast)) : 0.0f;
}

BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter)
{
    // Sizes first, so that every part knows its ranges and all parts can be filled at once.
    BakeGeometry g;
    uint32_t triangleCount = 0;
    uint32_t vertexCount = 0;
    bool anyColor = false;
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (filter == GeometryFilter::Static && !object.isStatic) continue;
        const Mesh& mesh = scene.meshes[std::size_t(object.mesh)];
        for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
            const MeshPart& part = mesh.parts[p];
            BakeGeometry::Part out;
            out.object = int(o);
            out.mesh = object.mesh;
            out.part = int(p);
            out.material = part.material;
            out.firstTriangle = triangleCount;
            out.triangleCount = uint32_t(part.indices.size() / 3);
            out.firstVertex = vertexCount;
            out.vertexCount = uint32_t(part.positions.size());
            out.castShadows = object.castShadows && materialOf(scene, part).castShadows;
            out.page = part.lightmapUv.empty() ? -1 : object.lightmap.page;
            triangleCount += out.triangleCount;
            vertexCount += out.vertexCount;
            anyColor = anyColor || !part.colors.empty();
            g.parts.push_back(out);
        }
    }
    g.triangles.resize(triangleCount);
    g.partOfTriangle.resize(triangleCount);
    g.positions.resize(vertexCount);
    g.normals.resize(vertexCount);
    for (auto& uv : g.uv) uv.resize(vertexCount, vec2(0.0f));
    g.lightmapTexel.resize(vertexCount, vec2(0.0f));
    if (anyColor) g.colors.resize(vertexCount, vec4(1.0f));

    parallelFor(g.parts.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const BakeGeometry::Part& out = g.parts[i];
            const Object& object = scene.objects[std::size_t(out.object)];
            const MeshPart& part = scene.meshes[std::size_t(out.mesh)].parts[std::size_t(out.part)];
            const mat3 linear(object.worldFromObject);
            const bool mirrored = glm::determinant(linear) < 0.0f;
            // Normals follow the inverse transpose; the cofactor matrix is the same up to scale and exists when the
            // transform flattens the object.
            const mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                glm::cross(linear[0], linear[1]));
            const mat3 worldFromNormal = mirrored ? -cofactor : cofactor;
            for (uint32_t v = 0; v < out.vertexCount; ++v) {
                const uint32_t w = out.firstVertex + v;
                g.positions[w] = vec3(object.worldFromObject * vec4(part.positions[v], 1.0f));
                const vec3 n = worldFromNormal * (part.normals.empty() ? vec3(0, 1, 0) : part.normals[v]);
                const float length = glm::length(n);
                g.normals[w] = length > 0.0f ? n / length : vec3(0.0f, 1.0f, 0.0f);
                for (int c = 0; c < 2; ++c) {
                    if (!part.uv[std::size_t(c)].empty()) g.uv[c][w] = part.uv[std::size_t(c)][v];
                }
                if (!part.colors.empty()) g.colors[w] = part.colors[v];
                if (out.page >= 0) {
                    g.lightmapTexel[w] =
                        (object.lightmap.scale * part.lightmapUv[v] + object.lightmap.offset) * float(pageSize);
                }
            }
            for (uint32_t t = 0; t < out.triangleCount; ++t) {
                uvec3 triangle(part.indices[3 * t], part.indices[3 * t + 1], part.indices[3 * t + 2]);
                if (mirrored) std::swap(triangle.y, triangle.z);
                g.triangles[out.firstTriangle + t] = triangle + uvec3(out.firstVertex);
                g.partOfTriangle[out.firstTriangle + t] = uint32_t(i);
            }
        }
    });
    findSolids(scene, g);
    return g;
}

TriangleFrame::TriangleFrame(const BakeGeometry& geometry, uint32_t triangle)
    : triangle_(triangle), geometricNormal_(geometry.geometricNormal(triangle))
{
    const uvec3 t = geometry.triangles[triangle];
    for (int i = 0; i < 3; ++i) {
        positions_[i] = geometry.positions[t[i]];
        normals_[i] = geometry.normals[t[i]];
    }
    flat_ = normals_[0] == normals_[1] && normals_[0] == normals_[2];
    if (flat_) normals_[0] = shadingNormal(normals_[0]);
}

void TriangleFrame::put(vec2 barycentric, SurfacePoint& p) const
{
    const float w = 1.0f - barycentric.x - barycentric.y;
    p.triangle = triangle_;
    p.barycentric = barycentric;
    p.position = w * positions_[0] + barycentric.x * positions_[1] + barycentric.y * positions_[2];
    p.geometricNormal = geometricNormal_;
    p.normal = flat_ ? normals_[0]
                     : shadingNormal(w * normals_[0] + barycentric.x * normals_[1] + barycentric.y * normals_[2]);
}

/// Smooth normals that lean behind the triangle (or files whose normals contradict the winding) would put the whole
/// hemisphere inside the surface; the triangle's own normal is the safe choice there.
vec3 TriangleFrame::shadingNormal(vec3 sum) const
{
    const float length = glm::length(sum);
    const vec3 normal = length > 0.0f ? sum / length : geometricNormal_;
    return glm::dot(normal, geometricNormal_) > 0.0f ? normal : geometricNormal_;
}

SurfacePoint surfacePoint(const BakeGeometry& geometry, uint32_t triangle, vec2 barycentric)
{
    SurfacePoint point;
    TriangleFrame(geometry, triangle).put(barycentric, point);
    return point;
}

} // namespace halflight
