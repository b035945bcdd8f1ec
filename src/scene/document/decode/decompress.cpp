#include "scene/document/decode/decompress.h"

#include "halflight/base/encoded_image.h"
#include "halflight/scene/compression.h"
#include "scene/document/decode/draco_mesh.h"
#include "scene/document/decode/meshopt_view.h"
#include "scene/document/fallback_buffers.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

namespace halflight {

namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

// A non-negative integer member; `fallback` where it is absent.
Result<uint64_t> integerMember(const Json& object, const char* key, const std::string& path,
                               std::optional<uint64_t> fallback = {})
{
    const Json& value = member(object, key);
    if (value.is_null() && fallback) return *fallback;
    constexpr uint64_t kMost = 0xffffffff;
    if (!value.is_number_unsigned() || value.get<uint64_t>() > kMost)
        return invalid(path, std::string(key) + (value.is_null() ? " is missing" : " is not an unsigned integer"));
    return value.get<uint64_t>();
}

void eraseExtension(Json& object, const char* name)
{
    if (!extensionOf(object, name).is_null()) object["extensions"].erase(name);
    if (const Json& rest = member(object, "extensions"); rest.is_object() && rest.empty()) object.erase("extensions");
}

int typeComponents(const Json& accessor)
{
    const Json& type = member(accessor, "type");
    for (int n = 1; n <= 4; ++n) {
        if (type == (n == 1 ? std::string("SCALAR") : "VEC" + std::to_string(n))) return n;
    }
    return 0;
}

// min and max of decoded values, which differ from the encoder's input by quantization.
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
    for (int c = 0; c < typeComponents(accessor); ++c) {
        float least = view.number(0, c);
        float most = least;
        for (std::size_t i = 1; i < view.count; ++i) {
            least = std::min(least, view.number(i, c));
            most = std::max(most, view.number(i, c));
        }
        if (view.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
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

class Decompressor {
public:
    Decompressor(Json& json, std::vector<tinygltf::Buffer>& buffers) : json_(json), buffers_(buffers)
    {
        constexpr uint64_t kFree = uint64_t(1) << 28;
        constexpr uint64_t kMost = uint64_t(1) << 32; // a GLB can hold no more
        constexpr uint64_t kRatio = 256;              // the best that flat meshes reach is some 100:1
        uint64_t source = 0;
        for (const tinygltf::Buffer& buffer : buffers) source += buffer.data.size();
        left_ = std::min(kMost, kFree + kRatio * source);
    }

    Status run()
    {
        for (std::size_t i = 0; i < member(json_, "bufferViews").size(); ++i) {
            for (const char* name : kMeshoptExtensions) {
                if (extensionOf(json_["bufferViews"][i], name).is_null()) continue;
                const std::string path = pathOf("bufferViews", i) + "/extensions/" + name;
                if (Status s = meshoptView(json_["bufferViews"][i], name, path); !s) return s;
            }
        }
        if (Status s = eachPrimitive(); !s) return s;
        if (!decoded_.empty()) {
            tinygltf::Buffer buffer;
            buffer.data = std::move(decoded_);
            json_["buffers"].push_back({{"byteLength", buffer.data.size()}});
            buffers_.push_back(std::move(buffer));
        }
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) eraseNames(list);
        return dropUnusedBuffers();
    }

private:
    Status eachPrimitive()
    {
        const Json& meshes = member(json_, "meshes");
        for (std::size_t m = 0; m < meshes.size(); ++m) {
            const Json& primitives = member(meshes[m], "primitives");
            for (std::size_t p = 0; primitives.is_array() && p < primitives.size(); ++p) {
                if (extensionOf(primitives[p], kDraco).is_null()) continue;
                const std::string path = pathOf("meshes", m) + "/primitives/" + std::to_string(p);
                if (Status s = dracoPrimitive(json_["meshes"][m]["primitives"][p], path); !s) return s;
            }
        }
        return {};
    }

    // The bytes that an extension's buffer, byteOffset and byteLength name.
    Result<std::span<const std::byte>> bytesOf(const Json& range, const std::string& path)
    {
        const auto buffer = integerMember(range, "buffer", path);
        if (!buffer) return buffer.error();
        const auto offset = integerMember(range, "byteOffset", path, 0);
        if (!offset) return offset.error();
        const auto length = integerMember(range, "byteLength", path);
        if (!length) return length.error();
        if (*buffer >= buffers_.size()) return invalid(path, "refers to a buffer that does not exist");
        const auto& data = buffers_[std::size_t(*buffer)].data;
        if (*length == 0 || *offset + *length > data.size())
            return invalid(path, "reaches past the end of buffer " + std::to_string(*buffer));
        return std::as_bytes(std::span(data)).subspan(std::size_t(*offset), std::size_t(*length));
    }

    // Places decoded bytes in the new buffer and returns the new view's place there.
    std::size_t append(const std::vector<std::byte>& bytes)
    {
        constexpr std::size_t kAlignment = 16;
        decoded_.resize((decoded_.size() + kAlignment - 1) / kAlignment * kAlignment);
        const std::size_t offset = decoded_.size();
        const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
        decoded_.insert(decoded_.end(), first, first + bytes.size());
        left_ -= std::min<uint64_t>(left_, bytes.size() + kAlignment);
        return offset;
    }

    Status meshoptView(Json& view, const char* name, const std::string& path)
    {
        const Json extension = view["extensions"][name];
        if (!MeshoptView::isSupported()) { // the fallback's data serves, if there is any
            if (isFallbackBuffer(element(json_, "buffers", view["buffer"].get<int>())))
                return Error{ErrorCode::Unsupported, std::string("is compressed") + conversionHint(name), path};
            eraseExtension(view, name);
            return {};
        }
        const auto bytes = bytesOf(extension, path);
        if (!bytes) return bytes.error();
        const auto stride = integerMember(extension, "byteStride", path);
        if (!stride) return stride.error();
        const auto count = integerMember(extension, "count", path);
        if (!count) return count.error();
        MeshoptView encoded;
        encoded.count = *count;
        encoded.strideBytes = *stride;
        const Json& mode = member(extension, "mode");
        const Json& filter = member(extension, "filter");
        if (mode == "TRIANGLES") {
            encoded.mode = MeshoptView::Mode::Triangles;
        } else if (mode == "INDICES") {
            encoded.mode = MeshoptView::Mode::Indices;
        } else if (mode != "ATTRIBUTES") {
            return invalid(path, "mode is not ATTRIBUTES, TRIANGLES or INDICES");
        }
        if (filter == "OCTAHEDRAL") {
            encoded.filter = MeshoptView::Filter::Octahedral;
        } else if (filter == "QUATERNION") {
            encoded.filter = MeshoptView::Filter::Quaternion;
        } else if (filter == "EXPONENTIAL") {
            encoded.filter = MeshoptView::Filter::Exponential;
        } else if (!filter.is_null() && filter != "NONE") {
            return Error{ErrorCode::Unsupported, "its filter is not one this build's meshoptimizer decodes", path};
        }
        if (Status s = encoded.check(bytes->size()); !s) return at(path, s.error());
        if (encoded.decodedBytes() > left_) return tooMuch(path);
        const auto decoded = encoded.decode(*bytes);
        if (!decoded) {
            const bool newer = decoded.error().code == ErrorCode::Unsupported;
            return at(path, {decoded.error().code, decoded.error().message + (newer ? conversionHint(name) : "")});
        }
        view["buffer"] = newBuffer_;
        view["byteOffset"] = append(*decoded);
        view["byteLength"] = decoded->size();
        eraseExtension(view, name);
        return {};
    }

    Result<const DracoMesh*> dracoMesh(uint64_t viewIndex, const std::string& path)
    {
        const auto it = meshes_.find(viewIndex);
        if (it != meshes_.end()) return &it->second;
        const Json& views = member(json_, "bufferViews");
        if (viewIndex >= views.size()) return invalid(path, "refers to a buffer view that does not exist");
        const Json& view = views[std::size_t(viewIndex)];
        if (view["buffer"] == newBuffer_) return invalid(path, "its buffer view is compressed twice");
        const auto bytes = bytesOf(view, pathOf("bufferViews", std::size_t(viewIndex)));
        if (!bytes) return bytes.error();
        auto mesh = DracoMesh::decode(*bytes, left_);
        if (!mesh) return at(path, mesh.error());
        return &meshes_.emplace(viewIndex, std::move(*mesh)).first->second;
    }

    Status dracoPrimitive(Json& primitive, const std::string& primitivePath)
    {
        const std::string path = primitivePath + "/extensions/" + kDraco;
        const Json extension = primitive["extensions"][kDraco];
        const auto view = integerMember(extension, "bufferView", path);
        if (!view) return view.error();
        const Json& ids = member(extension, "attributes");
        if (!ids.is_object()) return invalid(path, "has no attributes");
        if (!DracoMesh::isSupported()) return {}; // not required, or it had been refused: accessors hold the data
        const auto mesh = dracoMesh(*view, path);
        if (!mesh) return mesh.error();
        for (const auto& [name, id] : ids.items()) {
            Json& attributes = primitive["attributes"];
            if (member(attributes, name.c_str()).is_null()) continue; // nothing reads it
            if (!id.is_number_unsigned()) return invalid(path, name + " is not an unsigned integer");
            const auto accessor =
                dracoAttribute(**mesh, *view, id.get<uint64_t>(), attributes[name], path + "/attributes/" + name);
            if (!accessor) return accessor.error();
            attributes[name] = *accessor;
        }
        if (Status s = dracoIndices(**mesh, *view, primitive, path); !s) return s;
        eraseExtension(primitive, kDraco);
        return {};
    }

    // The accessor that holds the decoded attribute: the one that the primitive names where it has no data yet, else a
    // new one.
    Result<std::size_t> dracoAttribute(const DracoMesh& mesh, uint64_t view, uint64_t id, const Json& reference,
                                       const std::string& path)
    {
        const auto index = accessorIndex(reference, path);
        if (!index) return index.error();
        const auto key = std::make_tuple(view, id, *index);
        if (const auto it = placed_.find(key); it != placed_.end()) return it->second;
        Json accessor = json_["accessors"][*index];
        const int components = typeComponents(accessor);
        const std::size_t bytes =
            std::size_t(componentBytes(accessor["componentType"].get<int>())) * std::size_t(components);
        if (bytes == 0) return invalid(pathOf("accessors", *index), "is of a type that Draco data cannot have");
        if (accessor["count"] != mesh.pointCount()) {
            return invalid(path, "the Draco data has " + std::to_string(mesh.pointCount()) +
                                     " points, its accessor another count");
        }
        const std::size_t stride = (bytes + 3) / 4 * 4; // vertex attributes are aligned to 4 bytes
        if (mesh.pointCount() * stride > left_) return tooMuch(path);
        const auto values = mesh.attribute(id, accessor["componentType"].get<int>(), components, stride);
        if (!values) return at(path, values.error());
        if (!values->empty()) updateBounds(accessor, *values, stride);
        const std::size_t placed =
            place(*index, accessor, *values, TINYGLTF_TARGET_ARRAY_BUFFER, stride == bytes ? 0 : stride);
        placed_[key] = placed;
        return placed;
    }

    Status dracoIndices(const DracoMesh& mesh, uint64_t view, Json& primitive, const std::string& path)
    {
        const std::size_t count = mesh.indices().size();
        const Json& mode = member(primitive, "mode");
        std::size_t index = member(json_, "accessors").size();
        Json accessor = {{"componentType", TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT}, {"count", count}, {"type", "SCALAR"}};
        if (mode.is_null() || mode == TINYGLTF_MODE_TRIANGLES) {
            if (const Json& reference = member(primitive, "indices"); !reference.is_null()) {
                const auto named = accessorIndex(reference, path);
                if (!named) return named.error();
                index = *named;
                if (json_["accessors"][index]["count"] != count) {
                    return invalid(path, "the Draco data has " + std::to_string(count) +
                                             " indices, their accessor another count");
                }
                accessor = json_["accessors"][index];
            }
        } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) { // Draco data is a list of triangles in any case
            primitive["mode"] = TINYGLTF_MODE_TRIANGLES;
        } else {
            return invalid(path, "Draco data is of triangles, its primitive is not");
        }
        const auto key = std::make_tuple(view, kIndices, index);
        if (const auto it = placed_.find(key); it != placed_.end()) {
            primitive["indices"] = it->second;
            return {};
        }
        if (count * sizeof(uint32_t) > left_) return tooMuch(path);
        if (count == 0) return invalid(path, "the Draco data has no triangle");
        accessor["componentType"] = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        const auto bytes = std::as_bytes(std::span(mesh.indices()));
        accessor.erase("min");
        accessor.erase("max");
        placed_[key] = place(index, accessor, {bytes.begin(), bytes.end()}, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, 0);
        primitive["indices"] = placed_[key];
        return {};
    }

    Result<std::size_t> accessorIndex(const Json& reference, const std::string& path)
    {
        if (!reference.is_number_unsigned() && !(reference.is_number_integer() && reference.get<int64_t>() >= 0))
            return invalid(path, "its accessor is not an unsigned integer");
        if (reference.get<uint64_t>() >= member(json_, "accessors").size())
            return invalid(path, "refers to an accessor that does not exist");
        return reference.get<std::size_t>();
    }

    // Gives `accessor` the decoded bytes. It replaces accessor `index` if that exists and has no data.
    std::size_t place(std::size_t index, Json accessor, const std::vector<std::byte>& bytes, int target,
                      std::size_t byteStride)
    {
        Json view = {
            {"buffer", newBuffer_}, {"byteOffset", append(bytes)}, {"byteLength", bytes.size()}, {"target", target}};
        if (byteStride != 0) view["byteStride"] = byteStride;
        Json& accessors = json_["accessors"];
        Json& views = json_["bufferViews"];
        const bool isFree = index < accessors.size() && !accessors[index].contains("bufferView") &&
                            !accessors[index].contains("sparse");
        for (const char* key : {"byteOffset", "sparse"}) accessor.erase(key);
        accessor["bufferView"] = views.size();
        views.push_back(std::move(view));
        if (isFree) {
            accessors[index] = std::move(accessor);
            return index;
        }
        accessors.push_back(std::move(accessor));
        return accessors.size() - 1;
    }

    void eraseNames(const char* list)
    {
        Json& names = json_[list];
        Json kept = Json::array();
        for (const Json& name : names) {
            const bool decoded = (name == kDraco && DracoMesh::isSupported()) || name == kMeshoptExtensions[0] ||
                                 name == kMeshoptExtensions[1];
            if (!decoded) kept.push_back(name);
        }
        names = std::move(kept);
        if (names.empty()) json_.erase(list);
    }

    // Compressed data and fallback buffers.
    Status dropUnusedBuffers()
    {
        std::set<uint64_t> used;
        Json& views = json_["bufferViews"];
        for (std::size_t i = 0; i < views.size(); ++i) {
            const auto buffer = views[i]["buffer"].get<uint64_t>();
            if (isFallbackBuffer(json_["buffers"][buffer]))
                return invalid(pathOf("bufferViews", i), "refers to a buffer without data, and is not compressed");
            used.insert(buffer);
        }
        std::map<uint64_t, std::size_t> place;
        Json kept = Json::array();
        std::vector<tinygltf::Buffer> keptBuffers;
        for (const uint64_t buffer : used) {
            place[buffer] = keptBuffers.size();
            kept.push_back(json_["buffers"][buffer]);
            keptBuffers.push_back(std::move(buffers_[std::size_t(buffer)]));
        }
        for (Json& view : views) view["buffer"] = place[view["buffer"].get<uint64_t>()];
        json_["buffers"] = std::move(kept);
        buffers_ = std::move(keptBuffers);
        if (json_["bufferViews"].empty()) json_.erase("bufferViews");
        if (json_["buffers"].empty()) json_.erase("buffers");
        return {};
    }

    static Error at(const std::string& path, const Error& error) { return {error.code, error.message, path}; }
    static Error tooMuch(const std::string& path)
    {
        return invalid(path, "compressed data takes more memory than a file of this size may ask for");
    }

    static constexpr uint64_t kIndices = ~uint64_t(0); // in place of an attribute's id

    Json& json_;
    std::vector<tinygltf::Buffer>& buffers_;
    const std::size_t newBuffer_ = buffers_.size();
    std::vector<unsigned char> decoded_;
    uint64_t left_ = 0;
    std::map<uint64_t, DracoMesh> meshes_;
    std::map<std::tuple<uint64_t, uint64_t, std::size_t>, std::size_t> placed_; ///< view, attribute, accessor
};

} // namespace

bool readsCompression(std::string_view extension)
{
    if (extension == kDraco) return DracoMesh::isSupported();
    if (extension == kMeshoptExtensions[0] || extension == kMeshoptExtensions[1]) return MeshoptView::isSupported();
    return extension == "EXT_texture_webp" && decodesWebp();
}

std::vector<std::string> readableCompression()
{
    std::vector<std::string> names;
    for (const char* name : {kDraco, kMeshoptExtensions[0], kMeshoptExtensions[1], "EXT_texture_webp"}) {
        if (readsCompression(name)) names.emplace_back(name);
    }
    return names;
}

std::string conversionHint(std::string_view extension)
{
    // Tried with gltf-transform 4.5 and gltfpack 1.3; "copy" decompresses, "ktxdecompress" calls KTX-Software's `ktx`.
    static const std::map<std::string_view, std::string> kCommands = {
        {kDraco, "npx @gltf-transform/cli copy IN.glb OUT.glb"},
        {kMeshoptExtensions[0], "npx @gltf-transform/cli copy IN.glb OUT.glb"},
        {kMeshoptExtensions[1], "npx gltfpack -i IN.glb -o OUT.glb -noq -kn -km -ke"},
        {"EXT_texture_webp", "npx @gltf-transform/cli png IN.glb OUT.glb"},
        {"EXT_texture_avif", "npx @gltf-transform/cli png IN.glb OUT.glb"},
        {"KHR_texture_basisu", "npx @gltf-transform/cli ktxdecompress IN.glb OUT.glb"}};
    const auto it = kCommands.find(extension);
    return it == kCommands.end() ? "" : "; `" + it->second + "` makes a file without it";
}

Status decompress(Json& json, std::vector<tinygltf::Buffer>& buffers)
{
    const auto hasCompression = [&] {
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
            for (const Json& name : member(json, list)) {
                if (name == kDraco || name == kMeshoptExtensions[0] || name == kMeshoptExtensions[1]) return true;
            }
        }
        for (const Json& view : member(json, "bufferViews")) {
            for (const char* name : kMeshoptExtensions) {
                if (!extensionOf(view, name).is_null()) return true;
            }
        }
        for (const Json& mesh : member(json, "meshes")) {
            for (const Json& primitive : member(mesh, "primitives")) {
                if (!extensionOf(primitive, kDraco).is_null()) return true;
            }
        }
        return false;
    };
    return hasCompression() ? Decompressor(json, buffers).run() : Status();
}

} // namespace halflight
