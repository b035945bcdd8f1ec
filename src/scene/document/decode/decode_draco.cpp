#include "scene/document/decode/decode_draco.h"

#include "scene/document/decode/compression.h"
#include "scene/document/erase_extension.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr uint64_t kIndices = ~uint64_t(0); // in place of an attribute's id

/// min and max of decoded values, which differ from the encoder's input by quantization.
void updateBounds(Json& accessor, const std::vector<std::byte>& bytes, std::size_t strideBytes)
{
    if (!accessor.contains("min") && !accessor.contains("max")) return;
    AccessorView view;
    view.data = bytes.data();
    view.strideBytes = strideBytes;
    view.count = bytes.size() / strideBytes;
    view.componentType = accessor["componentType"].get<int>();
    Json low = Json::array();
    Json high = Json::array();
    for (int c = 0; c < elementSize(accessor).components; ++c) {
        float least = view.number(0, c);
        float most = least;
        for (std::size_t i = 1; i < view.count; ++i) {
            least = std::min(least, view.number(i, c));
            most = std::max(most, view.number(i, c));
        }
        if (view.componentType == gltf::kFloat) {
            low.push_back(least);
            high.push_back(most);
        } else {
            low.push_back(int64_t(least));
            high.push_back(int64_t(most));
        }
    }
    accessor["min"] = std::move(low);
    accessor["max"] = std::move(high);
}

} // namespace

Result<const DracoMesh*> DracoDecoder::meshOf(uint64_t viewIndex, const std::string& path)
{
    const auto it = meshes_.find(viewIndex);
    if (it != meshes_.end()) return &it->second;
    const Json& views = member(buffer_.json(), "bufferViews");
    if (viewIndex >= views.size()) return invalid(path, "refers to a buffer view that does not exist");
    const Json& view = views[std::size_t(viewIndex)];
    if (view["buffer"] == buffer_.index()) return invalid(path, "its buffer view is compressed twice");
    const auto bytes = buffer_.bytesOf(view, pathOf("bufferViews", std::size_t(viewIndex)));
    if (!bytes) return bytes.error();
    auto mesh = DracoMesh::decode(*bytes, buffer_.left());
    if (!mesh) return Error{mesh.error().code, mesh.error().message, path};
    return &meshes_.emplace(viewIndex, std::move(*mesh)).first->second;
}

Status DracoDecoder::decode(Json& primitive, const std::string& primitivePath)
{
    const std::string path = primitivePath + "/extensions/" + kDracoExtension;
    const Json extension = primitive["extensions"][kDracoExtension];
    const auto view = integerMember(extension, "bufferView", path);
    if (!view) return view.error();
    const Json& ids = member(extension, "attributes");
    if (!ids.is_object()) return invalid(path, "has no attributes");
    if (!DracoMesh::isSupported()) return {}; // not required, or it had been refused: accessors hold the data
    const auto mesh = meshOf(*view, path);
    if (!mesh) return mesh.error();
    for (const auto& [name, id] : ids.items()) {
        Json& attributes = primitive["attributes"];
        if (member(attributes, name.c_str()).is_null()) continue; // nothing reads it
        if (!id.is_number_unsigned()) return invalid(path, name + " is not an unsigned integer");
        const auto accessor =
            attribute(**mesh, *view, id.get<uint64_t>(), attributes[name], path + "/attributes/" + name);
        if (!accessor) return accessor.error();
        attributes[name] = *accessor;
    }
    if (Status s = indices(**mesh, *view, primitive, path); !s) return s;
    eraseExtension(primitive, kDracoExtension);
    return {};
}

Result<std::size_t> DracoDecoder::attribute(const DracoMesh& mesh, uint64_t view, uint64_t id, const Json& reference,
                                            const std::string& path)
{
    if (!isIndexInto(buffer_.json(), "accessors", reference))
        return invalid(path, "refers to an accessor that does not exist");
    const auto index = reference.get<std::size_t>();
    const auto key = std::make_tuple(view, id, index);
    if (const auto it = placed_.find(key); it != placed_.end()) return it->second;
    Json accessor = buffer_.json()["accessors"][index];
    const auto [components, bytes] = elementSize(accessor);
    if (bytes == 0 || stringOf(accessor, "type").starts_with("MAT"))
        return invalid(pathOf("accessors", index), "is of a type that Draco data cannot have");
    if (accessor["count"] != mesh.pointCount()) {
        return invalid(path, "the Draco data has " + std::to_string(mesh.pointCount()) +
                                 " points, its accessor another count");
    }
    const std::size_t stride = (bytes + 3) / 4 * 4; // vertex attributes are aligned to 4 bytes
    if (Status s = buffer_.hasRoomFor(mesh.pointCount() * stride, path); !s) return s.error();
    const auto values = mesh.attribute(id, accessor["componentType"].get<int>(), components, stride);
    if (!values) return Error{values.error().code, values.error().message, path};
    if (!values->empty()) updateBounds(accessor, *values, stride);
    const std::size_t placed = buffer_.place(index, accessor, *values, gltf::kVertices, stride == bytes ? 0 : stride);
    placed_[key] = placed;
    return placed;
}

Status DracoDecoder::indices(const DracoMesh& mesh, uint64_t view, Json& primitive, const std::string& path)
{
    const std::size_t count = mesh.indices().size();
    const Json& mode = member(primitive, "mode");
    std::size_t index = member(buffer_.json(), "accessors").size();
    Json accessor = {{"componentType", gltf::kUnsignedInt}, {"count", count}, {"type", "SCALAR"}};
    if (mode.is_null() || mode == gltf::kTriangles) {
        if (const Json& reference = member(primitive, "indices"); !reference.is_null()) {
            if (!isIndexInto(buffer_.json(), "accessors", reference))
                return invalid(path, "refers to an accessor that does not exist");
            index = reference.get<std::size_t>();
            if (buffer_.json()["accessors"][index]["count"] != count) {
                return invalid(path, "the Draco data has " + std::to_string(count) +
                                         " indices, their accessor another count");
            }
            accessor = buffer_.json()["accessors"][index];
        }
    } else if (mode == gltf::kTriangleStrip) { // Draco data is a list of triangles in any case
        primitive["mode"] = gltf::kTriangles;
    } else {
        return invalid(path, "Draco data is of triangles, its primitive is not");
    }
    const auto key = std::make_tuple(view, kIndices, index);
    if (const auto it = placed_.find(key); it != placed_.end()) {
        primitive["indices"] = it->second;
        return {};
    }
    if (Status s = buffer_.hasRoomFor(count * sizeof(uint32_t), path); !s) return s;
    if (count == 0) return invalid(path, "the Draco data has no triangle");
    accessor["componentType"] = gltf::kUnsignedInt;
    const auto bytes = std::as_bytes(std::span(mesh.indices()));
    accessor.erase("min");
    accessor.erase("max");
    placed_[key] = buffer_.place(index, accessor, {bytes.begin(), bytes.end()}, gltf::kIndices, 0);
    primitive["indices"] = placed_[key];
    return {};
}

} // namespace halflight
