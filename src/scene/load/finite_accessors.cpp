#include "scene/load/finite_accessors.h"

#include "scene/document/references.h"

#include <cmath>
#include <cstring>
#include <map>

namespace halflight {

namespace {

constexpr const char* kTangent = "TANGENT";

float floatAt(const std::byte* p)
{
    float value = 0.0f;
    std::memcpy(&value, p, sizeof value);
    return value;
}

std::optional<std::size_t> firstNotFinite(const AccessorView& view)
{
    for (std::size_t i = 0; i < view.count; ++i) {
        for (std::size_t offset = 0; offset < view.bytesPerElement; offset += sizeof(float)) {
            if (!std::isfinite(floatAt(view.at(i) + offset))) return i;
        }
    }
    return std::nullopt;
}

/// Accessors that are tangents of vertices or of morph targets and nothing else.
std::map<int, bool> onlyTangents(const SourceDocument& document)
{
    std::map<int, int> uses;
    auto& json = const_cast<Json&>(document.json); // the visitor below only reads
    visitAccessors(json, [&](Json& index) {
        if (index.is_number_unsigned()) ++uses[index.get<int>()];
    });
    for (const tinygltf::Mesh& mesh : document.model.meshes) {
        for (const tinygltf::Primitive& primitive : mesh.primitives) {
            if (const auto it = primitive.attributes.find(kTangent); it != primitive.attributes.end())
                --uses[it->second];
            for (const auto& target : primitive.targets) {
                if (const auto it = target.find(kTangent); it != target.end()) --uses[it->second];
            }
        }
    }
    std::map<int, bool> only;
    for (const auto& [accessor, others] : uses) only[accessor] = others == 0;
    return only;
}

/// Zeroes in place of what is not finite: the accessor stays in the file, though nothing reads it.
void clear(SourceDocument& document, int index)
{
    tinygltf::Model& model = document.model;
    const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
    const std::size_t bytes = elementBytes(accessor.componentType, accessor.type);
    const auto clearIn = [&](int bufferView, std::size_t offset, std::size_t stride, std::size_t count) {
        const tinygltf::BufferView& view = model.bufferViews[std::size_t(bufferView)];
        unsigned char* first = model.buffers[std::size_t(view.buffer)].data.data() + view.byteOffset + offset;
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t at = 0; at < bytes; at += sizeof(float)) {
                unsigned char* value = first + i * stride + at;
                if (!std::isfinite(floatAt(reinterpret_cast<const std::byte*>(value))))
                    std::memset(value, 0, sizeof(float));
            }
        }
    };
    if (accessor.bufferView >= 0) {
        const std::size_t stride = model.bufferViews[std::size_t(accessor.bufferView)].byteStride;
        clearIn(accessor.bufferView, accessor.byteOffset, stride != 0 ? stride : bytes, accessor.count);
    }
    if (accessor.sparse.isSparse)
        clearIn(accessor.sparse.values.bufferView, std::size_t(accessor.sparse.values.byteOffset), bytes,
                std::size_t(accessor.sparse.count));
}

/// Takes the tangents of vertices and of morph targets out of a primitive.
void dropTangents(Json& json, tinygltf::Primitive& primitive)
{
    primitive.attributes.erase(kTangent);
    json["attributes"].erase(kTangent);
    for (auto& target : primitive.targets) target.erase(kTangent);
    if (!json.contains("targets")) return;
    for (Json& target : json["targets"]) target.erase(kTangent);
}

void dropTangents(SourceDocument& document, const std::map<int, std::size_t>& bad)
{
    for (std::size_t m = 0; m < document.model.meshes.size(); ++m) {
        auto& primitives = document.model.meshes[m].primitives;
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            auto found = bad.end();
            const auto look = [&](const std::map<std::string, int>& attributes) {
                const auto it = attributes.find(kTangent);
                if (it != attributes.end() && bad.contains(it->second)) found = bad.find(it->second);
            };
            look(primitives[p].attributes);
            for (const auto& target : primitives[p].targets) look(target);
            if (found == bad.end()) continue;
            document.warnings.push_back(pathOf("meshes", m) + "/primitives/" + std::to_string(p) +
                                        ": its tangents are left out and made anew (element " +
                                        std::to_string(found->second) + " of accessor " + std::to_string(found->first) +
                                        " is not finite)");
            dropTangents(document.json["meshes"][m]["primitives"][p], primitives[p]);
        }
    }
    for (const auto& [accessor, element] : bad) clear(document, accessor);
}

} // namespace

Status checkFiniteAccessors(SourceDocument& document)
{
    const std::map<int, bool> tangents = onlyTangents(document);
    std::map<int, std::size_t> bad; // first bad element by accessor
    for (std::size_t i = 0; i < document.model.accessors.size(); ++i) {
        if (document.model.accessors[i].componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) continue;
        const auto view = viewAccessor(document, int(i));
        if (!view) return view.error();
        const std::optional<std::size_t> element = firstNotFinite(*view);
        if (!element) continue;
        const auto only = tangents.find(int(i));
        if (only == tangents.end() || !only->second)
            return invalid(pathOf("accessors", i),
                           "element " + std::to_string(*element) + " holds a number that is not finite");
        bad[int(i)] = *element;
    }
    dropTangents(document, bad);
    return {};
}

} // namespace halflight
