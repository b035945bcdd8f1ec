#include "scene/model/geometry.h"

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
    for (auto& set : part.uv) select(set);
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

} // namespace halflight
