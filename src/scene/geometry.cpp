#include "scene/geometry.h"

#include <cmath>

namespace halflight {

void selectVertices(MeshPart& part, const std::vector<uint32_t>& kept)
{
    const auto select = [&](auto& values) {
        if (values.empty()) return;
        std::remove_reference_t<decltype(values)> selected(kept.size());
        for (std::size_t i = 0; i < kept.size(); ++i) selected[i] = values[kept[i]];
        values = std::move(selected);
    };
    if (part.sourceVertex.empty()) {
        part.sourceVertex = kept;
    } else {
        select(part.sourceVertex);
    }
    select(part.positions);
    select(part.normals);
    select(part.tangents);
    select(part.uv[0]);
    select(part.uv[1]);
    select(part.colors);
    select(part.lightmapUv);
}

void makeFlatNormals(MeshPart& part)
{
    // Vertices that no two corners share stay as they are: a file that was split before is not split again.
    std::vector<bool> used(part.positions.size(), false);
    bool shared = false;
    for (const uint32_t v : part.indices) {
        shared = shared || used[v];
        used[v] = true;
    }
    if (shared) {
        selectVertices(part, part.indices);
        for (std::size_t i = 0; i < part.indices.size(); ++i) part.indices[i] = uint32_t(i);
    }
    part.normals.assign(part.positions.size(), vec3(0, 1, 0));
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        const uint32_t* v = &part.indices[i];
        const glm::dvec3 a(part.positions[v[0]]);
        const glm::dvec3 n = glm::cross(glm::dvec3(part.positions[v[1]]) - a, glm::dvec3(part.positions[v[2]]) - a);
        const double length = glm::length(n);
        if (!(length > 0.0)) continue;
        for (std::size_t k = 0; k < 3; ++k) part.normals[v[k]] = vec3(n / length);
    }
}

void makeTangents(MeshPart& part, const std::vector<vec2>& uv, const mat2& uvFromTexCoord)
{
    // Orientation of each triangle's texture; vertices that see both signs are doubled.
    const std::size_t triangleCount = part.indices.size() / 3;
    std::vector<int8_t> orientation(triangleCount, 0);
    std::vector<glm::dvec3> gradient(triangleCount, glm::dvec3(0.0));
    for (std::size_t t = 0; t < triangleCount; ++t) {
        const uint32_t* v = &part.indices[3 * t];
        const glm::dvec3 e1(part.positions[v[1]] - part.positions[v[0]]);
        const glm::dvec3 e2(part.positions[v[2]] - part.positions[v[0]]);
        const glm::dvec2 d1(uvFromTexCoord * (uv[v[1]] - uv[v[0]]));
        const glm::dvec2 d2(uvFromTexCoord * (uv[v[2]] - uv[v[0]]));
        const double determinant = d1.x * d2.y - d1.y * d2.x;
        const glm::dvec3 du = e1 * d2.y - e2 * d1.y; // direction of growing u, times the determinant
        const double length = glm::length(du);
        if (determinant == 0.0 || !(length > 0.0)) continue;
        orientation[t] = determinant > 0.0 ? 1 : -1;
        gradient[t] = du * (double(orientation[t]) / length);
    }
    std::vector<int8_t> sign(part.positions.size(), 0);
    std::vector<uint32_t> twin(part.positions.size(), ~0u);
    std::vector<uint32_t> kept(part.positions.size());
    for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = uint32_t(i);
    for (std::size_t i = 0; i < part.indices.size(); ++i) {
        const uint32_t v = part.indices[i];
        const int8_t o = orientation[i / 3];
        if (o == 0 || sign[v] == o) continue;
        if (sign[v] == 0) {
            sign[v] = o;
            continue;
        }
        if (twin[v] == ~0u) {
            twin[v] = uint32_t(kept.size());
            kept.push_back(v);
        }
        part.indices[i] = twin[v];
    }
    const std::size_t originalCount = part.positions.size();
    if (kept.size() != originalCount) {
        selectVertices(part, kept);
        sign.resize(kept.size());
        for (std::size_t i = originalCount; i < kept.size(); ++i) sign[i] = int8_t(-sign[kept[i]]);
    }

    std::vector<glm::dvec3> sum(part.positions.size(), glm::dvec3(0.0));
    for (std::size_t t = 0; t < triangleCount; ++t) {
        if (orientation[t] == 0) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const uint32_t v = part.indices[3 * t + k];
            const glm::dvec3 p(part.positions[v]);
            const glm::dvec3 a = glm::dvec3(part.positions[part.indices[3 * t + (k + 1) % 3]]) - p;
            const glm::dvec3 b = glm::dvec3(part.positions[part.indices[3 * t + (k + 2) % 3]]) - p;
            const glm::dvec3 n(part.normals[v]);
            const glm::dvec3 projected = gradient[t] - n * glm::dot(n, gradient[t]);
            const double length = glm::length(projected);
            if (length > 0.0) sum[v] += projected / length * std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
        }
    }
    part.tangents.resize(part.positions.size());
    for (std::size_t v = 0; v < part.tangents.size(); ++v) {
        const vec3 n = part.normals[v];
        const double length = glm::length(sum[v]);
        vec3 tangent;
        if (length > 1.0e-12) {
            tangent = vec3(sum[v] / length);
        } else { // no texture gradient here: any direction in the surface
            tangent = glm::normalize(glm::cross(n, std::abs(n.x) < 0.9f ? vec3(1, 0, 0) : vec3(0, 1, 0)));
        }
        part.tangents[v] = vec4(glm::normalize(tangent - n * glm::dot(n, tangent)), sign[v] < 0 ? -1.0f : 1.0f);
    }
}

} // namespace halflight
