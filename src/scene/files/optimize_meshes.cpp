#include "scene/files/optimize_meshes.h"

#include "scene/document/decode/meshopt_encode.h"
#include "scene/document/references.h"
#include "scene/read/geometry/read_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <tuple>

namespace halflight {

namespace {

// Bits of mantissas. Three coordinates share an exponent: 14 bits are two millimetres on a mesh of 16 m.
constexpr int kPositionBits = 14;
constexpr int kCoordinateBits = 16; // of texture coordinates outside 0…1
constexpr int kDeltaBits = 14;      // of morph targets
constexpr int kRadianceBits = 10;
constexpr int kOcclusionBits = 10;
constexpr int kUnitBits = 8; // of normals and tangents

enum class AttributeKind { Position, Unit, Coordinates, Color, Delta, Radiance, Occlusion, Other };

AttributeKind kindOf(const std::string& semantic)
{
    if (semantic == "POSITION") return AttributeKind::Position;
    if (semantic == "NORMAL" || semantic == "TANGENT") return AttributeKind::Unit;
    if (semantic.starts_with("TEXCOORD_")) return AttributeKind::Coordinates;
    if (semantic.starts_with("COLOR_")) return AttributeKind::Color;
    return AttributeKind::Other;
}

class Optimizer {
public:
    Optimizer(DocumentPatcher& patcher, const SourceDocument& source) : patcher_(patcher), source_(source)
    {
        std::map<int, std::set<const Json*>> users;
        for (const Json& mesh : member(source.json, "meshes")) {
            for (const Json& primitive : mesh["primitives"]) {
                for (const int accessor : accessorsOf(primitive)) users[accessor].insert(&primitive);
            }
        }
        for (const auto& [accessor, primitives] : users) useCount_[accessor] = primitives.size();
    }

    Status run()
    {
        Json& meshes = patcher_.json["meshes"];
        for (std::size_t m = 0; m < meshes.size(); ++m) {
            for (std::size_t p = 0; p < meshes[m]["primitives"].size(); ++p) {
                if (Status s = primitive(meshes[m]["primitives"][p]); !s) return s;
            }
        }
        if (meshes.empty()) patcher_.json.erase("meshes");
        return probes();
    }

private:
    static std::set<int> accessorsOf(const Json& primitive)
    {
        std::set<int> accessors;
        for (const Json& accessor : primitive["attributes"]) accessors.insert(accessor.get<int>());
        for (const Json& target : member(primitive, "targets")) {
            for (const Json& accessor : target) accessors.insert(accessor.get<int>());
        }
        return accessors;
    }

    Status primitive(Json& json)
    {
        const std::set<int> accessors = accessorsOf(json);
        const bool isOwn = std::all_of(accessors.begin(), accessors.end(), [&](int a) { return useCount_[a] == 1; });
        if (!json["attributes"].contains("POSITION")) return {}; // nothing that shows: it stays as it is
        const Json& mode = member(json, "mode");
        const std::size_t vertexCount = elementCount(source_, attributeOf(json, "POSITION"));
        VertexOrder order;
        if (mode.is_null() || mode == gltf::kTriangles) {
            std::vector<uint32_t> indices;
            if (const Json& index = member(json, "indices"); !index.is_null()) {
                auto read = readIntegers(source_, index.get<int>());
                if (!read) return read.error();
                indices = std::move(*read);
            }
            if (std::any_of(indices.begin(), indices.end(), [&](uint32_t i) { return i >= vertexCount; }))
                return invalid("/meshes", "an index is beyond its vertices");
            const std::vector<uint32_t> triangles = trianglesOf(gltf::kTriangles, indices, vertexCount);
            if (triangles.empty()) return {}; // nothing that shows, here too
            order = orderForMeshopt(triangles, vertexCount, isOwn);
            json["indices"] = indexAccessor(order);
        }
        const std::size_t id = isOwn ? nextOrder_++ : 0;
        for (auto& [semantic, accessor] : json["attributes"].items()) {
            if (Status s = convert(accessor, kindOf(semantic), order, id); !s) return s;
        }
        if (json.contains("targets")) {
            for (Json& target : json["targets"]) {
                for (Json& accessor : target) {
                    if (Status s = convert(accessor, AttributeKind::Delta, order, id); !s) return s;
                }
            }
        }
        return {};
    }

    int indexAccessor(const VertexOrder& order)
    {
        const bool isShort = order.vertexCount <= 65535; // 65535 itself means "restart"
        NewView view;
        view.target = gltf::kIndices;
        const std::size_t bytes = isShort ? 2 : 4;
        view.bytes.resize(order.indices.size() * bytes);
        for (std::size_t i = 0; i < order.indices.size(); ++i)
            std::memcpy(&view.bytes[i * bytes], &order.indices[i], bytes);
        return patcher_.addAccessor({{"componentType", isShort ? gltf::kUnsignedShort : gltf::kUnsignedInt},
                                     {"count", order.indices.size()},
                                     {"type", "SCALAR"}},
                                    std::move(view));
    }

    // Replaces the accessor's index by that of a new one: once for each order of vertices.
    Status convert(Json& accessor, AttributeKind kind, const VertexOrder& order, std::size_t orderId)
    {
        const int index = accessor.get<int>();
        const auto key = std::tuple(index, kind, orderId);
        if (const auto it = converted_.find(key); it != converted_.end()) {
            accessor = it->second;
            return {};
        }
        const auto view = viewAccessor(source_, index);
        if (!view) return view.error();
        std::vector<std::size_t> sourceOf(order.remap.empty() ? view->count : order.vertexCount);
        for (std::size_t i = 0; i < view->count; ++i) {
            if (order.remap.empty()) {
                sourceOf[i] = i;
            } else if (order.remap[i] != ~0u) {
                sourceOf[order.remap[i]] = i;
            }
        }
        Json json = source_.json["accessors"][std::size_t(index)];
        for (const char* gone : {"bufferView", "byteOffset", "sparse", "min", "max"}) json.erase(gone);
        json["count"] = sourceOf.size();
        NewView bytes = view->componentType == gltf::kFloat && kind != AttributeKind::Other
                            ? fromFloats(*view, sourceOf, kind, json)
                            : asTheyAre(*view, sourceOf, json, kind);
        bytes.target = gltf::kVertices;
        converted_[key] = patcher_.addAccessor(std::move(json), std::move(bytes));
        accessor = converted_[key];
        return {};
    }

    static NewView asTheyAre(const AccessorView& view, const std::vector<std::size_t>& sourceOf, Json& json,
                             AttributeKind kind)
    {
        NewView out;
        const std::size_t stride = (view.bytesPerElement + 3) / 4 * 4;
        out.bytes.assign(sourceOf.size() * stride, std::byte(0));
        for (std::size_t i = 0; i < sourceOf.size(); ++i)
            std::memcpy(&out.bytes[i * stride], view.at(sourceOf[i]), view.bytesPerElement);
        if (stride != view.bytesPerElement) out.strideBytes = int(stride);
        if (kind == AttributeKind::Position) setBounds(view, sourceOf, json);
        return out;
    }

    /// Bounds of stored numbers, not of normalized ones.
    static void setBounds(const AccessorView& view, const std::vector<std::size_t>& sourceOf, Json& json)
    {
        AccessorView raw = view;
        raw.normalized = false;
        std::vector<float> values;
        for (const std::size_t i : sourceOf) {
            for (int c = 0; c < view.components; ++c) values.push_back(raw.number(i, c));
        }
        setBounds(values, view.components, json);
    }
    static void setBounds(const std::vector<float>& values, int components, Json& json)
    {
        json["min"] = Json::array();
        json["max"] = Json::array();
        for (std::size_t c = 0; c < std::size_t(components) && c < values.size(); ++c) {
            float low = values[c];
            float high = values[c];
            for (std::size_t i = c; i < values.size(); i += std::size_t(components)) {
                low = std::min(low, values[i]);
                high = std::max(high, values[i]);
            }
            json["min"].push_back(low);
            json["max"].push_back(high);
        }
    }

    static NewView fromFloats(const AccessorView& view, const std::vector<std::size_t>& sourceOf, AttributeKind kind,
                              Json& json)
    {
        std::vector<float> values;
        values.reserve(sourceOf.size() * std::size_t(view.components));
        bool isFraction = true; // all in 0…1
        for (const std::size_t i : sourceOf) {
            for (int c = 0; c < view.components; ++c) {
                values.push_back(view.number(i, c));
                isFraction = isFraction && values.back() >= 0.0f && values.back() <= 1.0f;
            }
        }
        if (kind == AttributeKind::Unit && (view.components == 3 || view.components == 4))
            return unitVectors(values, view.components, json);
        if (kind == AttributeKind::Coordinates && isFraction)
            return fractions<uint16_t>(values, gltf::kUnsignedShort, json);
        if (kind == AttributeKind::Color && isFraction && view.components == 4)
            return fractions<uint8_t>(values, gltf::kUnsignedByte, json);
        int bits = kDeltaBits;
        if (kind == AttributeKind::Position) bits = kPositionBits;
        if (kind == AttributeKind::Coordinates || kind == AttributeKind::Color) bits = kCoordinateBits;
        if (kind == AttributeKind::Radiance) bits = kRadianceBits;
        if (kind == AttributeKind::Occlusion) bits = kOcclusionBits;
        json[kMeshoptPlan] = {{"filter", "EXPONENTIAL"}, {"bits", bits}};
        roundToExponential(values, view.components, bits);
        if (kind == AttributeKind::Position || kind == AttributeKind::Delta) setBounds(values, view.components, json);
        return NewView{bytesOf(values)};
    }

    template<typename Integer> static NewView fractions(const std::vector<float>& values, int componentType, Json& json)
    {
        std::vector<Integer> stored(values.size());
        const auto most = float(std::numeric_limits<Integer>::max());
        std::transform(values.begin(), values.end(), stored.begin(),
                       [&](float value) { return Integer(std::lround(value * most)); });
        json["componentType"] = componentType;
        json["normalized"] = true;
        return NewView{bytesOf(stored)};
    }

    /// Four floats each, which the filter makes four bytes of.
    static NewView unitVectors(const std::vector<float>& values, int components, Json& json)
    {
        const auto n = std::size_t(components);
        std::vector<float> padded;
        for (std::size_t i = 0; i + n <= values.size(); i += n) {
            padded.insert(padded.end(), values.begin() + std::ptrdiff_t(i), values.begin() + std::ptrdiff_t(i + n));
            if (n == 3) padded.push_back(0.0f);
        }
        json["componentType"] = gltf::kByte;
        json["normalized"] = true;
        json[kMeshoptPlan] = {{"filter", "OCTAHEDRAL"}, {"bits", kUnitBits}};
        return NewView{bytesOf(padded)};
    }

    // Positions of probes stay as they are: their tetrahedra must not turn inside out.
    Status probes()
    {
        if (extensionOf(patcher_.json, "HALFLIGHT_mixed_lighting").is_null()) return {};
        Json& root = patcher_.json["extensions"]["HALFLIGHT_mixed_lighting"];
        if (!root.contains("probes")) return {};
        root["probes"].erase("neighbors"); // they follow from the tetrahedra
        if (Status s = convert(root["probes"]["radiance"], AttributeKind::Radiance, {}, 0); !s) return s;
        for (const char* name : kOcclusionAccessors) {
            if (!root["probes"].contains(name)) continue;
            if (Status s = convert(root["probes"][name], AttributeKind::Occlusion, {}, 0); !s) return s;
        }
        return {};
    }

    DocumentPatcher& patcher_;
    const SourceDocument& source_;
    std::map<int, std::size_t> useCount_; ///< primitives, by accessor
    std::map<std::tuple<int, AttributeKind, std::size_t>, int> converted_;
    std::size_t nextOrder_ = 1;
};

// Sets of texture coordinates have no gaps: the lightmap's stands in for missing ones, as the bake has it.
void fillTextureSets(DocumentPatcher& patcher)
{
    for (Json& mesh : patcher.json["meshes"]) {
        for (Json& primitive : mesh["primitives"]) {
            Json& attributes = primitive["attributes"];
            for (int n = 16; n > 0; --n) {
                const Json set = member(attributes, ("TEXCOORD_" + std::to_string(n)).c_str());
                const std::string below = "TEXCOORD_" + std::to_string(n - 1);
                if (!set.is_null() && !attributes.contains(below)) attributes[below] = set;
            }
        }
    }
}

} // namespace

Status optimizeMeshes(DocumentPatcher& patcher, const SourceDocument& source)
{
    if (!patcher.json.contains("meshes")) return {};
    fillTextureSets(patcher);
    return Optimizer(patcher, source).run();
}

} // namespace halflight
