#include "scene/document/types.h"

#include "scene/document/bake_ranges.h"
#include "scene/document/bake_types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string_view>

namespace halflight {

namespace {

// Arrays and objects that other rules lead through need no rule of their own: "a/*/b" says that a is an array and its
// items are objects, "a/{}/b" that a is an object with any names.
constexpr Rule kRules[] = {
    {"asset/version", Kind::Text},
    {"asset/minVersion", Kind::Text},
    {"asset/generator", Kind::Text},
    {"extensionsUsed/*", Kind::Text},
    {"extensionsRequired/*", Kind::Text},

    {"buffers/*/uri", Kind::Text},
    {"buffers/*/byteLength", Kind::Length},
    {"bufferViews/*/buffer", Kind::Index},
    {"bufferViews/*/byteOffset", Kind::Length},
    {"bufferViews/*/byteLength", Kind::Length},
    {"bufferViews/*/byteStride", Kind::Length},
    {"bufferViews/*/target", Kind::Index},
    {"accessors/*/bufferView", Kind::Index},
    {"accessors/*/byteOffset", Kind::Index},
    {"accessors/*/componentType", Kind::Index},
    {"accessors/*/count", Kind::Index},
    {"accessors/*/type", Kind::Text},
    {"accessors/*/normalized", Kind::Flag},
    {"accessors/*/min", Kind::Bounds},
    {"accessors/*/max", Kind::Bounds},
    {"accessors/*/sparse/count", Kind::Index},
    {"accessors/*/sparse/indices/bufferView", Kind::Index},
    {"accessors/*/sparse/indices/byteOffset", Kind::Index},
    {"accessors/*/sparse/indices/componentType", Kind::Index},
    {"accessors/*/sparse/values/bufferView", Kind::Index},
    {"accessors/*/sparse/values/byteOffset", Kind::Index},

    {"images/*/uri", Kind::Text},
    {"images/*/mimeType", Kind::Text},
    {"images/*/bufferView", Kind::Index},
    {"samplers/*/magFilter", Kind::Index},
    {"samplers/*/minFilter", Kind::Index},
    {"samplers/*/wrapS", Kind::Index},
    {"samplers/*/wrapT", Kind::Index},
    {"textures/*/source", Kind::Index},
    {"textures/*/sampler", Kind::Index},
    {"textures/*/extensions/EXT_texture_webp/source", Kind::Index},
    {"textures/*/extensions/KHR_texture_basisu/source", Kind::Index},
    {"textures/*/extensions/MOZ_texture_rgbe/source", Kind::Index},
    {"materials/*/alphaMode", Kind::Text},
    {"materials/*/alphaCutoff", Kind::Number},
    {"materials/*/doubleSided", Kind::Flag},
    {"materials/*/emissiveFactor", Kind::Numbers, 3},
    {"materials/*/emissiveTexture", Kind::Object},
    {"materials/*/normalTexture/scale", Kind::Number},
    {"materials/*/occlusionTexture/strength", Kind::Number},
    {"materials/*/pbrMetallicRoughness/baseColorFactor", Kind::Numbers, 4},
    {"materials/*/pbrMetallicRoughness/metallicFactor", Kind::Number},
    {"materials/*/pbrMetallicRoughness/roughnessFactor", Kind::Number},
    {"materials/*/extensions/KHR_materials_emissive_strength/emissiveStrength", Kind::Number},
    {"materials/*/extensions/KHR_materials_specular/specularFactor", Kind::Number},
    {"materials/*/extensions/KHR_materials_transmission/transmissionFactor", Kind::Number},
    {"materials/*/extensions/KHR_materials_volume/thicknessFactor", Kind::Number},
    {"materials/*/extensions/KHR_materials_volume/attenuationDistance", Kind::Number},
    {"materials/*/extensions/KHR_materials_volume/attenuationColor", Kind::Numbers, 3},
    {"materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", Kind::Numbers, 4},
    {"materials/*/extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", Kind::Numbers, 3},
    {"materials/*/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", Kind::Number},

    {"meshes/*/weights", Kind::Numbers},
    {"meshes/*/primitives/*/attributes/{}", Kind::Index},
    {"meshes/*/primitives/*/indices", Kind::Index},
    {"meshes/*/primitives/*/material", Kind::Index},
    {"meshes/*/primitives/*/mode", Kind::Index},
    {"meshes/*/primitives/*/targets/*/{}", Kind::Index},
    {"meshes/*/primitives/*/extensions/KHR_draco_mesh_compression/bufferView", Kind::Index},
    {"meshes/*/primitives/*/extensions/KHR_draco_mesh_compression/attributes/{}", Kind::Index},

    {"skins/*/joints/*", Kind::Index},
    {"skins/*/inverseBindMatrices", Kind::Index},
    {"skins/*/skeleton", Kind::Index},
    {"cameras/*/type", Kind::Text},
    {"cameras/*/perspective/aspectRatio", Kind::Number},
    {"cameras/*/perspective/yfov", Kind::Number},
    {"cameras/*/perspective/znear", Kind::Number},
    {"cameras/*/perspective/zfar", Kind::Number},
    {"cameras/*/orthographic/xmag", Kind::Number},
    {"cameras/*/orthographic/ymag", Kind::Number},
    {"cameras/*/orthographic/znear", Kind::Number},
    {"cameras/*/orthographic/zfar", Kind::Number},
    {"animations/*/samplers/*/input", Kind::Index},
    {"animations/*/samplers/*/output", Kind::Index},
    {"animations/*/samplers/*/interpolation", Kind::Text},
    {"animations/*/channels/*/sampler", Kind::Index},
    {"animations/*/channels/*/target/node", Kind::Index},
    {"animations/*/channels/*/target/path", Kind::Text},
    {"animations/*/channels/*/target/extensions/KHR_animation_pointer/pointer", Kind::Text},

    {"scene", Kind::Index},
    {"scenes/*/nodes/*", Kind::Index},
    {"nodes/*/mesh", Kind::Index},
    {"nodes/*/skin", Kind::Index},
    {"nodes/*/camera", Kind::Index},
    {"nodes/*/children/*", Kind::Index},
    {"nodes/*/matrix", Kind::Numbers, 16},
    {"nodes/*/translation", Kind::Numbers, 3},
    {"nodes/*/rotation", Kind::Numbers, 4},
    {"nodes/*/scale", Kind::Numbers, 3},
    {"nodes/*/weights", Kind::Numbers},
    {"nodes/*/extensions/KHR_lights_punctual/light", Kind::Index},
    {"nodes/*/extensions/EXT_lights_area/light", Kind::Index},
    {"nodes/*/extensions/KHR_node_visibility/visible", Kind::Flag},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/{}", Kind::Index},

    {"extensions/KHR_lights_punctual/lights/*/name", Kind::Text},
    {"extensions/KHR_lights_punctual/lights/*/type", Kind::Text},
    {"extensions/KHR_lights_punctual/lights/*/color", Kind::Numbers, 3},
    {"extensions/KHR_lights_punctual/lights/*/intensity", Kind::Number},
    {"extensions/KHR_lights_punctual/lights/*/range", Kind::Number},
    {"extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle", Kind::Number},
    {"extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle", Kind::Number},
    {"extensions/EXT_lights_area/lights/*/name", Kind::Text},
    {"extensions/EXT_lights_area/lights/*/type", Kind::Text},
    {"extensions/EXT_lights_area/lights/*/color", Kind::Numbers, 3},
    {"extensions/EXT_lights_area/lights/*/intensity", Kind::Number},
    {"extensions/EXT_lights_area/lights/*/size", Kind::Number},
    {"extensions/EXT_lights_area/lights/*/rect/aspect", Kind::Number},

};

// Members that glTF 2.0 requires, of those that no other check asks for.
constexpr std::pair<std::string_view, std::string_view> kRequired[] = {
    {"accessors/*", "type"},
    {"accessors/*", "componentType"},
    {"accessors/*", "count"},
    {"accessors/*/sparse", "count"},
    {"accessors/*/sparse", "indices"},
    {"accessors/*/sparse", "values"},
    {"accessors/*/sparse/indices", "bufferView"},
    {"accessors/*/sparse/indices", "componentType"},
    {"accessors/*/sparse/values", "bufferView"},
    {"animations/*/channels/*", "sampler"},
    {"animations/*/samplers/*", "input"},
    {"animations/*/samplers/*", "output"},
    {"buffers/*", "byteLength"},
    {"bufferViews/*", "buffer"},
    {"bufferViews/*", "byteLength"},
    {"cameras/*", "type"},
    {"cameras/*/perspective", "yfov"},
    {"cameras/*/perspective", "znear"},
    {"cameras/*/orthographic", "xmag"},
    {"cameras/*/orthographic", "ymag"},
    {"cameras/*/orthographic", "znear"},
    {"cameras/*/orthographic", "zfar"},
    {"extensions/KHR_lights_punctual/lights/*", "type"},
    {"meshes/*", "primitives"},
    {"meshes/*/primitives/*", "attributes"},
    {"skins/*", "joints"},
};

// Texture slots: each has the members of a textureInfo and of KHR_texture_transform.
constexpr std::string_view kTextureSlots[] = {
    "materials/*/normalTexture",
    "materials/*/occlusionTexture",
    "materials/*/emissiveTexture",
    "materials/*/pbrMetallicRoughness/baseColorTexture",
    "materials/*/pbrMetallicRoughness/metallicRoughnessTexture",
    "materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture",
    "materials/*/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture",
    "materials/*/extensions/MOZ_lightmap",
};
constexpr Rule kTextureRules[] = {
    {"index", Kind::Index},
    {"texCoord", Kind::Index},
    {"extensions/KHR_texture_transform/offset", Kind::Numbers, 2},
    {"extensions/KHR_texture_transform/scale", Kind::Numbers, 2},
    {"extensions/KHR_texture_transform/rotation", Kind::Number},
    {"extensions/KHR_texture_transform/texCoord", Kind::Index},
};

// Objects of these arrays may have a name.
constexpr std::string_view kNamed[] = {"buffers",    "bufferViews", "accessors", "images", "samplers",
                                       "textures",   "materials",   "meshes",    "skins",  "cameras",
                                       "animations", "scenes",      "nodes"};

// The rules as a tree. `items` stands for the items of an array or the members of an object, whatever their names.
struct Shape {
    Kind kind = Kind::Any;
    std::size_t count = 0;
    std::optional<Range> range; // of a number, or of each of an array's
    std::map<std::string, Shape, std::less<>> members;
    std::unique_ptr<Shape> items;
    std::vector<std::string> required;

    Shape& at(std::string_view path)
    {
        Shape* shape = this;
        while (!path.empty()) {
            const std::size_t slash = path.find('/');
            const std::string_view step = path.substr(0, slash);
            path = slash == std::string_view::npos ? std::string_view() : path.substr(slash + 1);
            const bool anyItem = step == "*" || step == "{}";
            shape->kind = step == "*" ? Kind::Array : Kind::Object;
            if (anyItem && !shape->items) shape->items = std::make_unique<Shape>();
            shape = anyItem ? shape->items.get() : &shape->members.try_emplace(std::string(step)).first->second;
        }
        return *shape;
    }

    void add(std::string_view path, Kind leaf, std::size_t leafCount)
    {
        Shape& shape = at(path);
        if (shape.members.empty() && !shape.items) {
            shape.kind = leaf;
            shape.count = leafCount;
        }
    }
};

Shape makeShape()
{
    Shape shape;
    for (const Rule& rule : kRules) shape.add(rule.path, rule.kind, rule.count);
    for (const Rule& rule : kBakeRules) shape.add(rule.path, rule.kind, rule.count);
    for (const Range& range : kBakeRanges) shape.at(range.path).range = range;
    for (const std::string_view slot : kTextureSlots) {
        for (const Rule& rule : kTextureRules)
            shape.add(std::string(slot) + "/" + std::string(rule.path), rule.kind, rule.count);
    }
    for (const auto& [owner, key] : kRequired) shape.at(owner).required.emplace_back(key);
    for (const std::string_view array : kNamed) shape.add(std::string(array) + "/*/name", Kind::Text, 0);
    return shape;
}

bool isIndex(const Json& value)
{
    return value.is_number_unsigned() && value.get<uint64_t>() <= 0x7fffffffu;
}

bool fitsFloat(const Json& value)
{
    return value.is_number() && std::abs(value.get<double>()) <= double(std::numeric_limits<float>::max());
}

template<typename Test> bool isArrayOf(const Json& value, std::size_t count, const Test& isGood)
{
    return value.is_array() && (count == 0 || value.size() == count) && std::all_of(value.begin(), value.end(), isGood);
}

// What the value should be, or nothing where it is that.
std::string expectation(const Json& value, const Shape& shape)
{
    switch (shape.kind) {
    case Kind::Any:
        return {};
    case Kind::Object:
        return value.is_object() ? "" : "an object";
    case Kind::Array:
        return value.is_array() ? "" : "an array";
    case Kind::Text:
        return value.is_string() ? "" : "a string";
    case Kind::Flag:
        return value.is_boolean() ? "" : "true or false";
    case Kind::Number:
        return fitsFloat(value) ? "" : "a number that fits a float";
    case Kind::Index:
        return isIndex(value) ? "" : "an unsigned integer below 2^31";
    case Kind::Length:
        return value.is_number_unsigned() && value.get<uint64_t>() <= 0xffffffffu ? ""
                                                                                  : "an unsigned integer below 2^32";
    case Kind::Signed:
        return value.is_number_integer() ? "" : "an integer";
    case Kind::Indices:
        return isArrayOf(value, shape.count, isIndex)
                   ? ""
                   : "an array of " + std::to_string(shape.count) + " unsigned integers";
    case Kind::Numbers: {
        const std::string length = shape.count == 0 ? "" : std::to_string(shape.count) + " ";
        return isArrayOf(value, shape.count, fitsFloat) ? "" : "an array of " + length + "numbers that fit floats";
    }
    case Kind::Bounds:
        return isArrayOf(value, 0, [](const Json& v) { return v.is_number() || v.is_null(); }) ? ""
                                                                                               : "an array of numbers";
    }
    return {};
}

// JSON text of a value, short enough for a sentence.
std::string shown(const Json& value)
{
    if (value.is_object()) return "an object";
    if (value.is_array()) return value.empty() ? "an empty array" : "an array";
    std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    constexpr std::size_t kShown = 40;
    if (text.size() <= kShown) return text;
    text.resize(kShown);
    text += "...";
    return text;
}

struct Mismatch {
    std::string path;
    std::string message;
};

Mismatch mismatchOf(const Json& value, const std::string& wanted)
{
    std::string message = "is ";
    message += shown(value);
    message += ", not ";
    message += wanted;
    return {{}, std::move(message)};
}

// Of a number, or of an array's.
std::optional<Mismatch> findOutside(const Json& value, const Range& range)
{
    if (value.is_number()) {
        if (isWithin(value.get<double>(), range)) return std::nullopt;
        return mismatchOf(value, "a number " + textOf(range));
    }
    for (std::size_t i = 0; i < value.size(); ++i) {
        if (isWithin(value[i].get<double>(), range)) continue;
        Mismatch mismatch = mismatchOf(value[i], "a number " + textOf(range));
        mismatch.path = '/' + std::to_string(i);
        return mismatch;
    }
    return std::nullopt;
}

std::optional<Mismatch> find(const Json& value, const Shape& shape)
{
    if (const std::string wanted = expectation(value, shape); !wanted.empty()) return mismatchOf(value, wanted);
    if (shape.range) {
        if (auto mismatch = findOutside(value, *shape.range)) return mismatch;
    }
    const auto within = [](const std::string& step, std::optional<Mismatch> mismatch) {
        if (mismatch) mismatch->path = '/' + step + mismatch->path;
        return mismatch;
    };
    static const Shape anyObject = [] {
        Shape object;
        object.kind = Kind::Object;
        return object;
    }();
    for (const std::string& key : shape.required) {
        if (!value.contains(key)) return Mismatch{{}, "has no " + key};
    }
    if (value.is_object()) {
        for (const auto& [key, child] : value.items()) {
            const auto known = shape.members.find(key);
            const Shape* next = known != shape.members.end() ? &known->second : shape.items.get();
            const bool isExtensions = key == "extensions" && shape.kind == Kind::Object;
            if (next == nullptr && isExtensions) next = &anyObject;
            if (next == nullptr) continue;
            if (auto mismatch = within(key, find(child, *next))) return mismatch;
            if (!isExtensions) continue;
            for (const auto& [name, extension] : child.items()) {
                if (auto mismatch = within(key, within(name, find(extension, anyObject)))) return mismatch;
            }
        }
    } else if (value.is_array() && shape.items) {
        for (std::size_t i = 0; i < value.size(); ++i) {
            if (auto mismatch = within(std::to_string(i), find(value[i], *shape.items))) return mismatch;
        }
    }
    return std::nullopt;
}

} // namespace

std::string textOf(const Range& range)
{
    std::array<char, 80> text{};
    if (range.above)
        std::snprintf(text.data(), text.size(), "above %.8g and at most %.8g", range.least, range.most);
    else
        std::snprintf(text.data(), text.size(), "from %.8g to %.8g", range.least, range.most);
    return text.data();
}

Status checkTypes(const Json& document)
{
    static const Shape shape = makeShape();
    if (auto mismatch = find(document, shape)) return invalid(mismatch->path, mismatch->message);
    return {};
}

} // namespace halflight
