#include "scene/read/geometry/read_mesh.h"
#include "scene/document/texture_coordinates.h"
#include "scene/format/material_sides.h"
#include "scene/model/geometry.h"
#include "scene/model/tangents.h"

#include "halflight/base/finite.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>

namespace halflight {

namespace {

// Adds the weighted morph targets to an attribute (glTF 2.0, section 3.7.2.2). Tangents' signs are not morphed.
template<typename Vec> Status morph(const SourceDocument& document, const Json& primitive,
                                    const std::vector<double>& weights, const char* attribute, std::vector<Vec>& values)
{
    if (values.empty()) return {};
    const Json& targets = member(primitive, "targets");
    for (std::size_t t = 0; t < targets.size() && t < weights.size(); ++t) {
        const int accessor = integerOf(targets[t], attribute);
        if (accessor < 0 || weights[t] == 0.0) continue;
        const auto offsets = readVectors<3>(document, accessor);
        if (!offsets) return offsets.error();
        for (std::size_t i = 0; i < values.size(); ++i) {
            for (int c = 0; c < 3; ++c) values[i][c] += float(weights[t]) * (*offsets)[i][c];
        }
    }
    return {};
}

// Attributes other than positions: one that this program cannot use is a warning, not an error.
class AttributeReader {
public:
    AttributeReader(const SourceDocument& document, const Json& primitive, std::string path,
                    std::vector<std::string>& warnings)
        : document_(document), primitive_(primitive), path_(std::move(path)), warnings_(warnings)
    {}

    template<int N> std::vector<glm::vec<N, float>> read(const std::string& name)
    {
        const int accessor = attributeOf(primitive_, name);
        if (accessor < 0) return {};
        auto values = readVectors<N>(document_, accessor);
        if (values) return std::move(*values);
        warnings_.push_back(path_ + ": " + name + " is left out (" + values.error().message + ")");
        return {};
    }

private:
    const SourceDocument& document_;
    const Json& primitive_;
    std::string path_;
    std::vector<std::string>& warnings_;
};

// Unit normals; a zero one is replaced by the normal of a triangle that uses the vertex.
std::size_t normalizeNormals(MeshPart& part)
{
    std::size_t repaired = 0;
    std::vector<bool> bad(part.normals.size(), false);
    for (std::size_t i = 0; i < part.normals.size(); ++i) {
        const float length = glm::length(part.normals[i]);
        if (length > 1.0e-12f && std::isfinite(length)) {
            part.normals[i] /= length;
        } else {
            part.normals[i] = vec3(0, 1, 0);
            bad[i] = true;
            ++repaired;
        }
    }
    for (std::size_t i = 0; repaired > 0 && i + 2 < part.indices.size(); i += 3) {
        const uint32_t* v = &part.indices[i];
        const vec3 n =
            glm::cross(part.positions[v[1]] - part.positions[v[0]], part.positions[v[2]] - part.positions[v[0]]);
        const float length = glm::length(n);
        for (std::size_t k = 0; k < 3 && length > 0.0f; ++k) {
            if (bad[v[k]]) part.normals[v[k]] = n / length;
            bad[v[k]] = false;
        }
    }
    return repaired;
}

// uv' = offset + R * (scale * uv): the linear part.
mat2 linearPart(const TextureRef& ref)
{
    const float c = math::cos(ref.rotationRadians);
    const float s = math::sin(ref.rotationRadians);
    return mat2(vec2(c, -s) * ref.scale.x, vec2(s, c) * ref.scale.y); // columns
}

Result<std::vector<vec3>> readPositions(const SourceDocument& document, const Json& primitive, int accessor,
                                        const std::vector<double>& weights, const std::string& path)
{
    auto positions = readVectors<3>(document, accessor);
    if (!positions) return positions;
    if (Status s = morph(document, primitive, weights, "POSITION", *positions); !s) return s.error();
    for (std::size_t i = 0; i < positions->size(); ++i) {
        if (!isFinite((*positions)[i]))
            return invalid(path, "position " + std::to_string(i) + " is not a finite number");
    }
    return positions;
}

Result<std::vector<uint32_t>> readIndices(const SourceDocument& document, int accessor, std::size_t vertexCount,
                                          const std::string& path)
{
    auto indices = readIntegers(document, accessor);
    if (!indices) return indices;
    for (const uint32_t index : *indices) {
        if (index >= vertexCount) {
            return invalid(path, "index " + std::to_string(index) + " is beyond the " + std::to_string(vertexCount) +
                                     " vertices");
        }
    }
    return indices;
}

std::vector<vec4> readColors(const SourceDocument& document, const Json& primitive, AttributeReader& attributes)
{
    const int accessor = attributeOf(primitive, "COLOR_0");
    if (accessor < 0) return {};
    if (stringOf(element(document.json, "accessors", accessor), "type") != "VEC3") return attributes.read<4>("COLOR_0");
    std::vector<vec4> colors;
    for (const vec3& c : attributes.read<3>("COLOR_0")) colors.emplace_back(c, 1.0f);
    return colors;
}

/// Sets of texture coordinates that the material reads, and those that a lightmap may.
void readTexCoords(const Material* material, AttributeReader& attributes, MeshPart& part)
{
    std::array<bool, kTexCoordSets> reads{true, true}; // the second may be a lightmap's layout
    if (material != nullptr) {
        for (const TextureRef* ref : material->textureRefs()) {
            if (*ref) reads[std::size_t(ref->texCoord)] = true;
        }
    }
    for (std::size_t n = 0; n < reads.size(); ++n) {
        if (reads[n]) part.uv[n] = attributes.read<2>("TEXCOORD_" + std::to_string(n));
    }
}

/// Of unit length, with signs of 1; none where one of them has no direction.
void normalizeTangents(std::vector<vec4>& tangents)
{
    for (vec4& tangent : tangents) {
        const float length = glm::length(vec3(tangent));
        if (!(length > 1.0e-12f)) {
            tangents.clear();
            return;
        }
        tangent = vec4(vec3(tangent) / length, tangent.w < 0.0f ? -1.0f : 1.0f);
    }
}

Result<std::optional<MeshPart>> readPart(const SourceDocument& document, int meshIndex, int primitiveIndex,
                                         const std::vector<double>& weights, const std::vector<Material>& materials,
                                         MeshRead& read)
{
    const Json& primitive = primitiveOf(document, meshIndex, primitiveIndex);
    const std::string path = pathOf("meshes", std::size_t(meshIndex)) + "/primitives/" + std::to_string(primitiveIndex);
    const int mode = integerOf(primitive, "mode", gltf::kTriangles);
    const auto warn = [&](const std::string& what) { read.warnings.push_back(path + ": " + what); };
    const auto skip = [&](const std::string& reason) {
        warn("skipped, " + reason);
        return std::optional<MeshPart>();
    };
    if (mode < gltf::kTriangles) return skip(mode == gltf::kPoints ? "points are not lit" : "lines are not lit");
    const int position = attributeOf(primitive, "POSITION");
    if (position < 0) return skip("it has no positions");

    MeshPart part;
    part.sourcePrimitive = primitiveIndex;
    part.material = integerOf(primitive, "material");
    part.side = markedSide(element(document.json, "materials", part.material));
    auto positions = readPositions(document, primitive, position, weights, path);
    if (!positions) return positions.error();
    part.positions = std::move(*positions);
    std::vector<uint32_t> indices;
    const int indexAccessor = integerOf(primitive, "indices");
    if (indexAccessor >= 0) {
        auto values = readIndices(document, indexAccessor, part.positions.size(), path);
        if (!values) return values.error();
        indices = std::move(*values);
    }
    const std::size_t listLength = indexAccessor >= 0 ? indices.size() : part.positions.size();
    if (mode == gltf::kTriangles && listLength % 3 != 0) warn("the last triangle is incomplete and left out");
    part.indices = trianglesOf(mode, indices, part.positions.size());
    if (part.indices.empty()) return skip("it has no triangle");

    const Material* material = part.material >= 0 ? &materials[std::size_t(part.material)] : nullptr;
    AttributeReader attributes(document, primitive, path, read.warnings);
    part.normals = attributes.read<3>("NORMAL");
    if (Status s = morph(document, primitive, weights, "NORMAL", part.normals); !s) return s.error();
    readTexCoords(material, attributes, part);
    part.colors = readColors(document, primitive, attributes);

    const TextureRef normalTexture = material != nullptr ? material->normalTexture : TextureRef();
    const std::vector<vec2>& tangentUv = part.uv[std::size_t(normalTexture.texCoord)];
    const bool needsTangents = bool(normalTexture) && !tangentUv.empty();
    if (part.normals.empty()) { // glTF ignores tangents then
        makeFlatNormals(part);
        ++read.flatParts;
    } else {
        if (const std::size_t repaired = normalizeNormals(part); repaired > 0)
            warn(std::to_string(repaired) + " normals of length 0 are replaced");
        if (needsTangents) part.tangents = attributes.read<4>("TANGENT");
        if (Status s = morph(document, primitive, weights, "TANGENT", part.tangents); !s) return s.error();
        normalizeTangents(part.tangents);
    }
    if (needsTangents && part.tangents.empty()) {
        makeTangents(part, std::vector<vec2>(tangentUv), linearPart(normalTexture));
        ++read.tangentParts;
    }
    return std::optional<MeshPart>(std::move(part));
}

} // namespace

std::vector<uint32_t> trianglesOf(int mode, const std::vector<uint32_t>& indices, std::size_t vertexCount)
{
    const std::size_t count = indices.empty() ? vertexCount : indices.size();
    const auto at = [&](std::size_t i) { return indices.empty() ? uint32_t(i) : indices[i]; };
    std::vector<uint32_t> triangles;
    if (mode == gltf::kTriangles) {
        triangles.resize(count / 3 * 3);
        for (std::size_t i = 0; i < triangles.size(); ++i) triangles[i] = at(i);
        return triangles;
    }
    // glTF 2.0, section 3.7.2.1: strips turn every other triangle round; fans share the first vertex.
    for (std::size_t i = 0; i + 2 < count; ++i) {
        if (mode == gltf::kTriangleStrip) {
            triangles.insert(triangles.end(), {at(i), at(i + 1 + i % 2), at(i + 2 - i % 2)});
        } else {
            triangles.insert(triangles.end(), {at(i + 1), at(i + 2), at(0)});
        }
    }
    return triangles;
}

Result<MeshRead> readMesh(const SourceDocument& document, int index, const std::vector<double>& weights,
                          const std::vector<Material>& materials)
{
    MeshRead read;
    const Json& source = element(document.json, "meshes", index);
    read.mesh.name = stringOf(source, "name");
    read.mesh.sourceMesh = index;
    for (std::size_t p = 0; p < source["primitives"].size(); ++p) {
        auto part = readPart(document, index, int(p), weights, materials, read);
        if (!part) return part.error();
        if (*part) read.mesh.parts.push_back(std::move(**part));
    }
    if (const auto it = document.stretchedLayouts.find(index); it != document.stretchedLayouts.end()) {
        for (MeshPart& part : read.mesh.parts) {
            if (readsTexCoord(element(document.json, "materials", part.material), 1)) continue;
            for (vec2& uv : part.uv[1]) uv *= it->second;
        }
    }
    // A back half without its front half is a surface of its own.
    const bool hasFront = std::any_of(read.mesh.parts.begin(), read.mesh.parts.end(),
                                      [](const MeshPart& part) { return part.side == SurfaceSide::Front; });
    for (MeshPart& part : read.mesh.parts)
        if (!hasFront) part.side = SurfaceSide::Both;
    // One slot for the whole mesh, since a node names one.
    int texCoord = 1;
    const auto taken = [&](int n) {
        return std::any_of(read.mesh.parts.begin(), read.mesh.parts.end(), [&](const MeshPart& part) {
            return readsTexCoord(element(document.json, "materials", part.material), n);
        });
    };
    while (taken(texCoord)) ++texCoord;
    for (MeshPart& part : read.mesh.parts) part.lightmapTexCoord = texCoord;
    return read;
}

} // namespace halflight
