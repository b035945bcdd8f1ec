#include "scene/document/decode/meshopt_encode.h"
#include "scene/document/fallback_buffers.h"
#include "scene/document/references.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <string_view>

#if HALFLIGHT_MESHOPT
#include <meshoptimizer.h>
#endif

namespace halflight {

#if HALFLIGHT_MESHOPT

namespace {

constexpr const char* kWrittenExtension = kMeshoptExtensions[0];

void encodeExponential(std::vector<float>& values, int components, int bits)
{
    const std::size_t count = values.size() / std::size_t(components);
    std::vector<float> encoded(values.size());
#if MESHOPTIMIZER_VERSION >= 190
    meshopt_encodeFilterExp(encoded.data(), count, std::size_t(components) * 4, bits, values.data(),
                            meshopt_EncodeExpSharedVector);
#else
    meshopt_encodeFilterExp(encoded.data(), count, std::size_t(components) * 4, bits, values.data());
#endif
    values = std::move(encoded);
}

// What a buffer view holds, as far as the encoders are concerned.
struct ViewUse {
    std::size_t accessors = 0;
    std::size_t accessor = 0; // the only one
    bool isIndices = false;
    bool isOther = false; // an image, or sparse values
};

std::vector<ViewUse> usesOfViews(Json& json)
{
    std::vector<ViewUse> uses(json.value("bufferViews", Json::array()).size());
    const auto mark = [&](const Json& holder) {
        const Json& view = member(holder, "bufferView");
        if (view.is_number_integer()) uses[view.get<std::size_t>()].isOther = true;
    };
    const Json& accessors = member(json, "accessors");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
        const Json& sparse = member(accessors[i], "sparse");
        mark(member(sparse, "indices"));
        mark(member(sparse, "values"));
        if (const Json& view = member(accessors[i], "bufferView"); view.is_number_integer()) {
            ViewUse& use = uses[view.get<std::size_t>()];
            ++use.accessors;
            use.accessor = i;
            use.isOther = use.isOther || !sparse.is_null();
        }
    }
    for (const Json& image : member(json, "images")) mark(image);
    for (const Json& mesh : member(json, "meshes")) {
        for (const Json& primitive : member(mesh, "primitives")) {
            const Json& indices = member(primitive, "indices");
            if (!indices.is_number_integer()) continue;
            const Json& view = member(accessors[indices.get<std::size_t>()], "bufferView");
            if (!view.is_number_integer()) continue;
            ViewUse& use = uses[view.get<std::size_t>()];
            use.isIndices = true;
            const Json& mode = member(primitive, "mode");
            const bool isTriangles = mode.is_null() || mode == gltf::kTriangles;
            const std::size_t count = bytesIn(accessors[indices.get<std::size_t>()], "count");
            use.isOther = use.isOther || !isTriangles || count % 3 != 0; // meshopt knows whole triangles alone
        }
    }
    return uses;
}

struct Encoded {
    std::vector<unsigned char> bytes; // empty: not worth it
    std::size_t count = 0;
    std::size_t stride = 0;
    const char* mode = "ATTRIBUTES";
    const char* filter = "NONE";
};

Encoded encodeTriangles(const std::byte* data, std::size_t count, std::size_t stride)
{
    Encoded encoded;
    encoded.count = count;
    encoded.stride = stride;
    encoded.mode = "TRIANGLES";
    std::vector<unsigned> indices(count);
    unsigned most = 0;
    for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(&indices[i], data + i * stride, stride); // little-endian, upper bytes zero
        most = std::max(most, indices[i]);
    }
    meshopt_encodeIndexVersion(1);
    encoded.bytes.resize(meshopt_encodeIndexBufferBound(count, most + 1));
    encoded.bytes.resize(meshopt_encodeIndexBuffer(encoded.bytes.data(), encoded.bytes.size(), indices.data(), count));
    return encoded;
}

Encoded encodeVertices(const void* data, std::size_t count, std::size_t stride)
{
    Encoded encoded;
    encoded.count = count;
    encoded.stride = stride;
    meshopt_encodeVertexVersion(0);
    encoded.bytes.resize(meshopt_encodeVertexBufferBound(count, stride));
    encoded.bytes.resize(meshopt_encodeVertexBuffer(encoded.bytes.data(), encoded.bytes.size(), data, count, stride));
    return encoded;
}

// Normals and tangents: four floats each become four bytes.
Encoded encodeOctahedral(const std::byte* data, std::size_t count, int bits)
{
    std::vector<float> unit(count * 4);
    std::memcpy(unit.data(), data, unit.size() * sizeof(float));
    std::vector<unsigned char> filtered(count * 4);
    meshopt_encodeFilterOct(filtered.data(), count, 4, bits, unit.data());
    Encoded encoded = encodeVertices(filtered.data(), count, 4);
    encoded.filter = "OCTAHEDRAL";
    return encoded;
}

// What may be one buffer view: elements of one size, to be encoded in one way.
struct Stream {
    bool isIndices = false;
    bool isVertices = false; // glTF wants a stride for vertex attributes, and none for animations
    std::size_t stride = 0;  // of the data that is at hand
    int target = 0;
    std::string filter;
    int bits = 0;
    auto operator<=>(const Stream&) const = default;
};

Stream streamOf(const Json& accessor, const Json& view, const ViewUse& use)
{
    Stream stream;
    const auto count = accessor["count"].get<std::size_t>();
    const auto bytes = view["byteLength"].get<std::size_t>();
    if (bytes % count != 0) return stream;
    stream.stride = bytes / count;
    stream.isIndices = use.isIndices;
    stream.target = view.value("target", 0);
    stream.isVertices = stream.target == gltf::kVertices || view.contains("byteStride");
    const Json& plan = member(accessor, kMeshoptPlan);
    if (plan.is_object()) {
        stream.filter = plan["filter"].get<std::string>();
        stream.bits = plan["bits"].get<int>();
    }
    return stream;
}

bool isEncodable(const Stream& stream)
{
    if (stream.isIndices) return stream.stride == 2 || stream.stride == 4;
    return stream.stride != 0 && stream.stride % 4 == 0 && stream.stride <= 256;
}

Encoded encodeStream(const Stream& stream, const std::vector<std::byte>& data)
{
    const std::size_t count = data.size() / stream.stride;
    if (stream.isIndices) return encodeTriangles(data.data(), count, stream.stride);
    if (stream.filter == "OCTAHEDRAL") return encodeOctahedral(data.data(), count, stream.bits);
    if (stream.filter.empty()) return encodeVertices(data.data(), count, stream.stride);
    std::vector<float> values(data.size() / sizeof(float));
    std::memcpy(values.data(), data.data(), data.size());
    encodeExponential(values, int(stream.stride / sizeof(float)), stream.bits);
    Encoded encoded = encodeVertices(values.data(), count, stream.stride);
    encoded.filter = "EXPONENTIAL";
    return encoded;
}

// The document's buffer views anew: compressed streams first, then what stays.
class ViewWriter {
public:
    explicit ViewWriter(FinishedDocument& document) : document_(document) {}

    void add(const Stream& stream, const std::vector<std::size_t>& accessors)
    {
        std::vector<std::byte> data;
        for (const std::size_t a : accessors) {
            const Json& view = source(a);
            const std::byte* first = document_.binary.data() + view.value("byteOffset", std::size_t(0));
            data.insert(data.end(), first, first + view["byteLength"].get<std::size_t>());
        }
        const Encoded encoded = encodeStream(stream, data);
        std::size_t offset = 0;
        for (const std::size_t a : accessors) {
            Json& accessor = document_.json["accessors"][a];
            placed_.emplace_back(a, views_.size());
            if (offset > 0) accessor["byteOffset"] = offset;
            offset += accessor["count"].get<std::size_t>() * encoded.stride;
            accessor.erase(kMeshoptPlan);
        }
        Json view = {{"buffer", 1}, {"byteOffset", fallback_}, {"byteLength", encoded.count * encoded.stride}};
        if (stream.isVertices) view["byteStride"] = encoded.stride;
        if (stream.target != 0) view["target"] = stream.target;
        align();
        Json& extension = view["extensions"][kWrittenExtension];
        extension = {{"buffer", 0},
                     {"byteOffset", binary_.size()},
                     {"byteLength", encoded.bytes.size()},
                     {"byteStride", encoded.stride},
                     {"count", encoded.count},
                     {"mode", encoded.mode}};
        if (std::string_view(encoded.filter) != "NONE") extension["filter"] = encoded.filter;
        const auto* bytes = reinterpret_cast<const std::byte*>(encoded.bytes.data());
        binary_.insert(binary_.end(), bytes, bytes + encoded.bytes.size());
        fallback_ += (encoded.count * encoded.stride + 15) / 16 * 16;
        views_.push_back(std::move(view));
    }

    /// Takes over views that stay; `gone` are those whose accessors have a new one.
    void finish(const std::set<std::size_t>& gone)
    {
        Json& json = document_.json;
        std::map<std::size_t, std::size_t> place;
        for (std::size_t v = 0; v < json["bufferViews"].size(); ++v) {
            if (gone.contains(v)) continue;
            Json view = json["bufferViews"][v];
            const std::byte* data = document_.binary.data() + view.value("byteOffset", std::size_t(0));
            align();
            view["byteOffset"] = binary_.size();
            binary_.insert(binary_.end(), data, data + view["byteLength"].get<std::size_t>());
            place[v] = views_.size();
            views_.push_back(std::move(view));
        }
        for (const auto& [accessor, view] : placed_) json["accessors"][accessor].erase("bufferView");
        visitViews(json, [&](Json& index) { index = place.at(index.get<std::size_t>()); });
        for (const auto& [accessor, view] : placed_) json["accessors"][accessor]["bufferView"] = view;
        json["bufferViews"] = std::move(views_);
        document_.binary = std::move(binary_);
        json["buffers"] = Json::array({{{"byteLength", document_.binary.size()}}});
        if (fallback_ == 0) return;
        json["buffers"].push_back(
            {{"byteLength", fallback_}, {"extensions", {{kWrittenExtension, {{"fallback", true}}}}}});
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) json[list].push_back(kWrittenExtension);
    }

private:
    const Json& source(std::size_t accessor)
    {
        return document_.json["bufferViews"][document_.json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    }
    void align() { binary_.resize((binary_.size() + 15) / 16 * 16); }

    FinishedDocument& document_;
    std::vector<std::byte> binary_;
    std::vector<Json> views_;
    std::vector<std::pair<std::size_t, std::size_t>> placed_; // accessor, view
    std::size_t fallback_ = 0;
};

} // namespace

bool encodesMeshopt()
{
    return true;
}

VertexOrder orderForMeshopt(std::vector<uint32_t> indices, std::size_t vertexCount, bool moveVertices)
{
    VertexOrder order;
    order.vertexCount = vertexCount;
    order.indices.resize(indices.size());
    meshopt_optimizeVertexCache(order.indices.data(), indices.data(), indices.size(), vertexCount);
    if (!moveVertices) return order;
    order.remap.resize(vertexCount);
    order.vertexCount =
        meshopt_optimizeVertexFetchRemap(order.remap.data(), order.indices.data(), order.indices.size(), vertexCount);
    for (uint32_t& index : order.indices) index = order.remap[index];
    return order;
}

void roundToExponential(std::vector<float>& values, int components, int bits)
{
    encodeExponential(values, components, bits);
    meshopt_decodeFilterExp(values.data(), values.size() / std::size_t(components), std::size_t(components) * 4);
}

void compressDocument(FinishedDocument& document)
{
    Json& json = document.json;
    if (!json.contains("bufferViews")) return;
    const std::vector<ViewUse> uses = usesOfViews(json);
    std::map<Stream, std::vector<std::size_t>> streams;
    std::set<std::size_t> gone;
    for (std::size_t v = 0; v < uses.size(); ++v) {
        if (uses[v].accessors != 1 || uses[v].isOther) continue;
        const Json& accessor = json["accessors"][uses[v].accessor];
        const Stream stream = streamOf(accessor, json["bufferViews"][v], uses[v]);
        if (accessor.value("byteOffset", std::size_t(0)) != 0 || !isEncodable(stream)) continue;
        streams[stream].push_back(uses[v].accessor);
        gone.insert(v);
    }
    ViewWriter writer(document);
    for (const auto& [stream, accessors] : streams) writer.add(stream, accessors);
    writer.finish(gone);
}

#else // without the library

bool encodesMeshopt()
{
    return false;
}

VertexOrder orderForMeshopt(std::vector<uint32_t> indices, std::size_t vertexCount, bool)
{
    return {std::move(indices), {}, vertexCount};
}

void roundToExponential(std::vector<float>&, int, int) {}

void compressDocument(FinishedDocument&) {}

#endif

} // namespace halflight
