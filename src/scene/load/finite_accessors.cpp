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

/// Calls visit(index) on the accessors of tangents of a primitive's vertices and of its morph targets.
void visitTangents(Json& primitive, FunctionRef<void(Json&)> visit)
{
    const auto visitMember = [&](Json& attributes) {
        if (Json* index = find(attributes, kTangent)) visit(*index);
    };
    visitMember(primitive["attributes"]);
    each(find(primitive, "targets"), visitMember);
}

/// Accessors that are tangents of vertices or of morph targets and nothing else.
std::map<int, bool> onlyTangents(const SourceDocument& document)
{
    std::map<int, int> uses;
    auto& json = const_cast<Json&>(document.json); // the visitor below only reads
    visitAccessors(json, [&](Json& index) {
        if (index.is_number_unsigned()) ++uses[index.get<int>()];
    });
    eachPrimitive(json,
                  [&](Json& primitive) { visitTangents(primitive, [&](Json& index) { --uses[index.get<int>()]; }); });
    std::map<int, bool> only;
    for (const auto& [accessor, others] : uses) only[accessor] = others == 0;
    return only;
}

/// Zeroes in place of what is not finite: the accessor stays in the file, though nothing reads it.
void clear(SourceDocument& document, int index)
{
    const Json& accessor = element(document.json, "accessors", index);
    const std::size_t bytes = elementSize(accessor).bytes;
    const auto clearIn = [&](const Json& part, std::size_t count, bool isStrided) {
        const Json& view = element(document.json, "bufferViews", integerOf(part, "bufferView"));
        std::byte* first = document.buffers[std::size_t(integerOf(view, "buffer"))].data() +
                           bytesIn(view, "byteOffset") + bytesIn(part, "byteOffset");
        const std::size_t stride = isStrided ? strideIn(view, bytes) : bytes;
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t at = 0; at < bytes; at += sizeof(float)) {
                std::byte* value = first + i * stride + at;
                if (!std::isfinite(floatAt(value))) std::memset(value, 0, sizeof(float));
            }
        }
    };
    if (accessor.contains("bufferView")) clearIn(accessor, bytesIn(accessor, "count"), true);
    if (const Json& sparse = member(accessor, "sparse"); !sparse.is_null())
        clearIn(sparse["values"], bytesIn(sparse, "count"), false);
}

void dropTangents(SourceDocument& document, const std::map<int, std::size_t>& bad)
{
    Json* const meshes = find(document.json, "meshes");
    for (std::size_t m = 0; meshes != nullptr && m < meshes->size(); ++m) {
        Json& primitives = (*meshes)[m]["primitives"];
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            auto found = bad.end();
            visitTangents(primitives[p], [&](Json& index) {
                if (const auto it = bad.find(index.get<int>()); it != bad.end()) found = it;
            });
            if (found == bad.end()) continue;
            document.warnings.push_back(pathOf("meshes", m) + "/primitives/" + std::to_string(p) +
                                        ": its tangents are left out and made anew (element " +
                                        std::to_string(found->second) + " of accessor " + std::to_string(found->first) +
                                        " is not finite)");
            primitives[p]["attributes"].erase(kTangent);
            each(find(primitives[p], "targets"), [](Json& target) { target.erase(kTangent); });
        }
    }
    for (const auto& [accessor, element] : bad) clear(document, accessor);
}

} // namespace

Status checkFiniteAccessors(SourceDocument& document)
{
    const std::map<int, bool> tangents = onlyTangents(document);
    std::map<int, std::size_t> bad; // first bad element by accessor
    const Json& accessors = member(document.json, "accessors");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
        if (integerOf(accessors[i], "componentType") != gltf::kFloat) continue;
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
