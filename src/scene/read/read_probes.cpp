#include "scene/read/read_probes.h"

#include "scene/document/references.h"
#include "scene/format/bake_members.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace halflight {

namespace {

// Elements of a VEC4 accessor of unsigned integers, flat.
Result<std::vector<uint32_t>> readQuadruples(const SourceDocument& document, const Json& json, const char* key,
                                             std::size_t count, const std::string& path)
{
    const auto index = accessorIndex(document, json, key, count, path);
    if (!index) return index.error();
    const auto view = viewAccessor(document, *index);
    if (!view) return view.error();
    if (view->components != 4 || view->componentType != gltf::kUnsignedInt)
        return invalid(path, std::string(key) + " is not VEC4 of unsigned int");
    std::vector<uint32_t> values;
    values.reserve(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 4; ++c) values.push_back(view->integer(i, c));
    }
    return values;
}

// Whether a neighbour names the cell back, across a face of the same three vertices.
bool meet(const std::vector<Tetrahedron>& cells, uint32_t cell, std::size_t face)
{
    const Tetrahedron& a = cells[cell];
    if (a.neighbor[face] == cell) return false;
    const Tetrahedron& b = cells[a.neighbor[face]];
    const auto back = std::find(b.neighbor.begin(), b.neighbor.end(), cell);
    if (back == b.neighbor.end()) return false;
    for (std::size_t i = 0; i < 4; ++i) {
        if (i == face) continue;
        const auto same = std::find(b.vertex.begin(), b.vertex.end(), a.vertex[i]);
        if (same == b.vertex.end() || same - b.vertex.begin() == back - b.neighbor.begin()) return false;
    }
    return true;
}

// Tetrahedra of the same three vertices are neighbours across that face.
void findNeighbors(std::vector<Tetrahedron>& cells)
{
    struct Face {
        std::array<uint32_t, 3> vertices{};
        uint32_t cell = 0;
        uint32_t face = 0;
    };
    std::vector<Face> faces;
    for (uint32_t i = 0; i < cells.size(); ++i) {
        cells[i].neighbor.fill(kOutside);
        for (uint32_t k = 0; k < 4; ++k) {
            const auto& v = cells[i].vertex;
            Face face{{v[(k + 1) % 4], v[(k + 2) % 4], v[(k + 3) % 4]}, i, k};
            std::sort(face.vertices.begin(), face.vertices.end());
            faces.push_back(face);
        }
    }
    std::sort(faces.begin(), faces.end(),
              [](const Face& a, const Face& b) { return std::tie(a.vertices, a.cell) < std::tie(b.vertices, b.cell); });
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        if (faces[i].vertices != faces[i + 1].vertices) continue;
        cells[faces[i].cell].neighbor[faces[i].face] = faces[i + 1].cell;
        cells[faces[i + 1].cell].neighbor[faces[i + 1].face] = faces[i].cell;
    }
}

Status readTetrahedra(const SourceDocument& document, const Json& json, ProbeSet& set)
{
    const std::string path = kBakePath + "/probes";
    const Json& reference = member(json, "tetrahedra");
    if (reference.is_null()) return {};
    if (!isIndexInto(document.json, "accessors", reference))
        return invalid(path, "tetrahedra refers to an accessor that does not exist");
    const std::size_t count = elementCount(document, reference.get<int>());
    const auto vertices = readQuadruples(document, json, "tetrahedra", count, path);
    if (!vertices) return vertices.error();
    set.tetrahedra.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        std::copy_n(vertices->begin() + std::ptrdiff_t(4 * i), 4, set.tetrahedra[i].vertex.begin());
    if (member(json, "neighbors").is_null()) {
        findNeighbors(set.tetrahedra);
    } else {
        const auto neighbors = readQuadruples(document, json, "neighbors", count, path);
        if (!neighbors) return neighbors.error();
        for (std::size_t i = 0; i < count; ++i)
            std::copy_n(neighbors->begin() + std::ptrdiff_t(4 * i), 4, set.tetrahedra[i].neighbor.begin());
    }
    for (uint32_t i = 0; i < count; ++i) {
        for (const uint32_t vertex : set.tetrahedra[i].vertex) {
            if (vertex >= set.probes.size() || !set.probes[vertex].valid)
                return invalid(path, "tetrahedron " + std::to_string(i) + " has a vertex that is no valid probe");
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        const Tetrahedron& cell = set.tetrahedra[i];
        for (std::size_t k = 0; k < 4; ++k) {
            if (cell.neighbor[k] == kOutside) continue;
            if (cell.neighbor[k] >= count || !meet(set.tetrahedra, i, k))
                return invalid(path, "tetrahedron " + std::to_string(i) + " has a neighbour that is not beside it");
        }
    }
    return {};
}

// The maps that a file may hold of how far its probes see.
Status readSight(const SourceDocument& document, const Json& json, ProbeSight& sight, std::size_t probeCount)
{
    const std::string path = kBakePath + "/probes";
    const Json& reference = member(json, "sight");
    if (reference.is_null()) return {};
    const auto ranges = accessorIndex(document, json, "sightRanges", probeCount, path);
    if (!ranges) return ranges.error();
    const auto numbers = viewAccessor(document, *ranges);
    if (!numbers) return numbers.error();
    if (!isIndexInto(document.json, "accessors", reference))
        return invalid(path, "sight refers to an accessor that does not exist");
    const auto corners = viewAccessor(document, reference.get<int>());
    if (!corners) return corners.error();
    if (corners->components != 2 || corners->componentType != gltf::kUnsignedShort)
        return invalid(path, "sight is not VEC2 of unsigned short");
    std::size_t maps = 0;
    for (std::size_t i = 0; i < probeCount; ++i) {
        const auto range = float(numbers->number(i, 0));
        if (!(range >= 0.0f && range < kInfinity)) return invalid(path, "a sightRange is no length");
        sight.rangeMeters.push_back(range);
        maps += range > 0.0f ? 1 : 0;
    }
    sight.size = maps > 0 ? int(std::lround(std::sqrt(double(corners->count) / double(maps)))) : 0;
    if (sight.size < 3 || sight.size % 2 == 0 ||
        maps * std::size_t(sight.size) * std::size_t(sight.size) != corners->count)
        return invalid(path, "sight does not hold a square map for each sightRange above 0");
    for (std::size_t i = 0; i < corners->count; ++i)
        sight.corners.push_back({uint16_t(corners->integer(i, 0)), uint16_t(corners->integer(i, 1))});
    return {};
}

// Attenuation by mask layer; of further layers where the file has them.
Status readOcclusion(const SourceDocument& document, const Json& json, const std::string& path,
                     std::vector<Probe>& probes)
{
    for (std::size_t layer = 0; layer < std::size(kOcclusionAccessors); ++layer) {
        const char* name = kOcclusionAccessors[layer];
        if (layer > 0 && !json.contains(name)) continue;
        const auto index = accessorIndex(document, json, name, probes.size(), path);
        if (!index) return index.error();
        const auto values = readVectors<4>(document, *index);
        if (!values) return values.error();
        for (std::size_t i = 0; i < probes.size(); ++i) probes[i].occlusion.layers[layer] = (*values)[i];
    }
    return {};
}

} // namespace

Status readProbes(const SourceDocument& document, const Json& json, const glm::dvec3& shift, ProbeSet& set)
{
    if (json.is_null()) return {};
    const std::string path = kBakePath + "/probes";
    const Json& count = member(json, "count");
    if (!count.is_number_unsigned() || count.get<uint64_t>() > (1u << 28))
        return invalid(path, "count is not a number of probes");
    const auto n = count.get<std::size_t>();
    const auto positions = accessorIndex(document, json, "positions", n, path);
    const auto radiance = accessorIndex(document, json, "radiance", 9 * n, path);
    const auto valid = accessorIndex(document, json, "valid", n, path);
    for (const auto* index : {&positions, &radiance, &valid}) {
        if (!*index) return index->error();
    }
    const auto p = readVectors<3>(document, *positions);
    const auto r = readVectors<3>(document, *radiance);
    const auto v = readIntegers(document, *valid);
    if (!p) return p.error();
    if (!r) return r.error();
    if (!v) return v.error();
    set.probes.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        Probe& probe = set.probes[i];
        probe.position = vec3(glm::dvec3((*p)[i]) + shift);
        for (std::size_t k = 0; k < 9; ++k) probe.radiance[k] = (*r)[9 * i + k];
        probe.valid = (*v)[i] != 0;
    }
    if (Status s = readOcclusion(document, json, path, set.probes); !s) return s;
    if (Status s = readTetrahedra(document, json, set); !s) return s;
    if (Status s = readSight(document, json, set.sight, n); !s) return s;
    const Json& grid = member(json, "grid");
    if (grid.is_null()) return {};
    if (!readVector(member(grid, "origin"), set.origin) || !readVector(member(grid, "spacing"), set.spacingMeters) ||
        !readVector(member(grid, "size"), set.size)) {
        return invalid(path + "/grid", "origin, spacing and size are not three numbers each");
    }
    set.origin = vec3(glm::dvec3(set.origin) + shift);
    if (set.size.x < 1 || set.size.y < 1 || set.size.z < 1 || glm::any(glm::greaterThan(set.size, ivec3(1 << 20))) ||
        uint64_t(set.size.x) * uint64_t(set.size.y) * uint64_t(set.size.z) != n) {
        return invalid(path + "/grid", "its size does not multiply to the number of probes");
    }
    return {};
}

} // namespace halflight
