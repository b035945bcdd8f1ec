// Every member of a document that is read, with values of wrong types: the file is refused with the member's path, or
// reads where glTF lets a reader ignore the member. Nothing throws, in reading nor in writing.

#include "fixtures.h"

#include <algorithm>
#include <functional>
#include <gmock/gmock.h>
#include <set>

namespace halflight::wrong_types_test {
namespace {

using namespace test;
using testing::HasSubstr;

void addMaterials(Json& json)
{
    json["images"] = {{{"uri", "t.png"}, {"name", "t"}}};
    json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9728}}};
    json["textures"] = {{{"source", 0}, {"sampler", 0}, {"name", "t"}}};
    const Json slot = {{"index", 0},
                       {"texCoord", 0},
                       {"extensions",
                        {{"KHR_texture_transform",
                          {{"offset", {0.5, 0.25}}, {"scale", {2.5, 3.5}}, {"rotation", 1.5}, {"texCoord", 0}}}}}};
    Json normal = slot;
    normal["scale"] = 0.5;
    Json occlusion = slot;
    occlusion["strength"] = 0.5;
    json["materials"] = {{{"name", "paint"},
                          {"alphaMode", "MASK"},
                          {"alphaCutoff", 0.25},
                          {"doubleSided", true},
                          {"emissiveFactor", {0.5, 0.25, 0.125}},
                          {"emissiveTexture", slot},
                          {"normalTexture", normal},
                          {"occlusionTexture", occlusion},
                          {"pbrMetallicRoughness",
                           {{"baseColorFactor", {0.5, 0.5, 0.5, 0.5}},
                            {"metallicFactor", 0.5},
                            {"roughnessFactor", 0.5},
                            {"baseColorTexture", slot},
                            {"metallicRoughnessTexture", slot}}},
                          {"extensions",
                           {{"KHR_materials_emissive_strength", {{"emissiveStrength", 2.5}}},
                            {"KHR_materials_specular", {{"specularFactor", 0.5}}},
                            {"KHR_materials_transmission", {{"transmissionFactor", 0.5}}},
                            {"KHR_materials_unlit", Json::object()}}}},
                         {{"extensions",
                           {{"KHR_materials_pbrSpecularGlossiness",
                             {{"diffuseFactor", {0.5, 0.5, 0.5, 0.5}},
                              {"specularFactor", {0.5, 0.5, 0.5}},
                              {"glossinessFactor", 0.5},
                              {"diffuseTexture", slot}}}}}}};
}

void addMeshes(GltfBuilder& file)
{
    Json& json = file.json;
    const int position = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
    json["accessors"][0]["min"] = {0.0, 0.0, 0.0};
    json["accessors"][0]["max"] = {1.0, 1.0, 0.5};
    json["bufferViews"][0]["target"] = 34962;
    const int sparse = file.add(
        {{"componentType", 5126},
         {"type", "VEC3"},
         {"count", 3},
         {"byteOffset", 0},
         {"normalized", false},
         {"sparse",
          {{"count", 1},
           {"indices",
            {{"bufferView", file.view(std::vector<uint8_t>{2})}, {"byteOffset", 0}, {"componentType", 5121}}},
           {"values", {{"bufferView", file.view(std::vector<float>{0.25f, 0.5f, 0.75f})}, {"byteOffset", 0}}}}}});
    json["accessors"][std::size_t(sparse)]["bufferView"] = file.view(std::vector<float>(9, 0.5f), 12);
    json["meshes"] = {{{"name", "m"},
                       {"weights", {0.5}},
                       {"primitives",
                        {{{"mode", 4},
                          {"material", 0},
                          {"indices", file.accessor<uint16_t>({0, 1, 2}, 5123, "SCALAR", 1)},
                          {"targets", {{{"POSITION", sparse}}}},
                          {"attributes",
                           {{"POSITION", position},
                            {"NORMAL", file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)},
                            {"TEXCOORD_0", file.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2)},
                            {"JOINTS_0", file.accessor<uint8_t>(std::vector<uint8_t>(12, 0), 5121, "VEC4", 4)},
                            {"WEIGHTS_0", file.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4)}}}}}}},
                      {{"primitives", {{{"attributes", {{"POSITION", position}}}, {"material", 1}}}}}};
    json["skins"] = {
        {{"joints", {0}},
         {"skeleton", 0},
         {"inverseBindMatrices", file.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "MAT4", 16)}}};
}

void addNodes(GltfBuilder& file)
{
    Json& json = file.json;
    json["cameras"] = {
        {{"type", "perspective"},
         {"name", "c"},
         {"perspective", {{"yfov", 0.5}, {"znear", 0.5}, {"zfar", 10.5}, {"aspectRatio", 1.5}}}},
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 1.5}, {"ymag", 1.5}, {"znear", 0.5}, {"zfar", 10.5}}}}};
    json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"},
         {"name", "lamp"},
         {"intensity", 5.5},
         {"range", 3.5},
         {"color", {0.5, 0.5, 0.25}},
         {"spot", {{"innerConeAngle", 0.125}, {"outerConeAngle", 0.5}}},
         {"extras", {{"halflight_mode", "mixed"}, {"note", 1}}}}};
    json["nodes"] = {
        {{"name", "joint"},
         {"translation", {0.5, 0.5, 0.5}},
         {"rotation", {0.0, 0.0, 0.0, 1.0}},
         {"scale", {1.5, 1.5, 1.5}},
         {"children", {4}},
         {"camera", 0}},
        {{"mesh", 0}, {"name", "skinned"}, {"skin", 0}, {"weights", {0.25}}},
        {{"mesh", 1},
         {"name", "still"},
         {"matrix", {1.5, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, 1}},
         {"extras", {{"halflight_static", true}, {"halflight_lightmap_scale", 1.5}, {"note", {{"a", 1}}}}},
         {"extensions", {{"KHR_node_visibility", {{"visible", true}}}, {"ACME_rocket", {{"stages", {3}}}}}}},
        {{"mesh", 1},
         {"extensions",
          {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", file.floats({0, 0, 1}, "VEC3", 3)}}}}}}}},
        {{"camera", 1}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}};
    json["scenes"] = {{{"name", "s"}, {"nodes", {0, 1, 2, 3}}, {"extras", {{"halflight_sky", {0.5, 0.5, 0.5}}}}}};
}

void addAnimation(GltfBuilder& file)
{
    file.json["animations"] = {
        {{"name", "a"},
         {"samplers",
          {{{"input", file.floats({0, 1}, "SCALAR", 1)},
            {"output", file.floats({0, 0, 0, 1, 0, 0}, "VEC3", 3)},
            {"interpolation", "LINEAR"}}}},
         {"channels",
          {{{"sampler", 0}, {"target", {{"node", 3}, {"path", "translation"}}}},
           {{"sampler", 0},
            {"target",
             {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", "/nodes/3/scale"}}}}}}}}}}}};
}

/// A file that has each member which the reader knows; fractions where a number need not be whole.
GltfBuilder richFile(const TemporaryFolder& folder)
{
    GltfBuilder file;
    EXPECT_TRUE(writePng(folder / "t.png", ImageRgba8(2, 2, u8vec4(200, 100, 50, 255))));
    file.json["asset"]["generator"] = "test";
    file.json["extensionsUsed"] = {"KHR_lights_punctual", "EXT_mesh_gpu_instancing", "KHR_animation_pointer"};
    file.json["extensionsRequired"] = {"KHR_lights_punctual"};
    addMaterials(file.json);
    addMeshes(file);
    addNodes(file);
    addAnimation(file);
    return file;
}

/// All members and items of a document as JSON pointers, one for each pattern of names, the first.
std::vector<std::string> members(const Json& document)
{
    std::set<std::string> seen;
    std::vector<std::string> pointers;
    const std::function<void(const Json&, const std::string&, const std::string&)> visit =
        [&](const Json& value, const std::string& pointer, const std::string& pattern) {
            if (!pointer.empty() && !seen.insert(pattern + (value.is_object() ? "{}" : "")).second) return;
            if (!pointer.empty()) pointers.push_back(pointer);
            for (const auto& item : value.items()) {
                if (!value.is_structured()) break;
                // Nodes and materials are each of a kind of their own; items of other arrays are alike.
                const bool kinds = pattern == "/nodes" || pattern == "/materials" || pattern == "/cameras";
                visit(item.value(), pointer + "/" + item.key(),
                      pattern + "/" + (value.is_array() && !kinds ? "*" : item.key()));
            }
        };
    visit(document, "", "");
    return pointers;
}

/// Members that a reader of glTF may ignore, whatever they hold, and two that have more than one form.
bool mayBeIgnored(const std::string& pointer)
{
    const std::size_t extras = pointer.find("/extras/");
    return (extras != std::string::npos && pointer.find("halflight_", extras) == std::string::npos) ||
           pointer.find("/ACME_rocket/") != std::string::npos || pointer.ends_with("/extras") ||
           pointer.ends_with("/halflight_sky") || pointer.ends_with("/halflight_baked") ||
           pointer.ends_with("/occlusionMaskChannel") || // take other numbers too
           pointer.find("KHR_materials_unlit/") != std::string::npos || pointer.find("/min") != std::string::npos ||
           pointer.find("/max") != std::string::npos; // bounds of accessors: exporters write null for NaN
}

const std::vector<Json>& wrongValues()
{
    static const std::vector<Json> values = {nullptr,
                                             true,
                                             -1,
                                             1.5,
                                             1e300,
                                             "x",
                                             "",
                                             Json::array(),
                                             Json::array({nullptr}),
                                             Json::object(),
                                             {{"a", 1}},
                                             18446744073709551615u,
                                             Json::array({Json::array({1})})};
    return values;
}

/// Whether glTF can take the value for another of the same member: a number for a number that need not be whole, a
/// string for a string, an object for an object.
bool sameType(const Json& was, const Json& value)
{
    if (was.is_number_float()) return value.is_number();
    if (was.is_number_unsigned()) return value.is_number_unsigned();
    if (was.is_array() && value.is_array()) return was.empty() || value.empty();
    return was.type() == value.type();
}

/// `only`: members whose pointer has this in it.
void sweep(const Json& document, const std::string& only, const TemporaryFolder& folder,
           const std::function<void(const Json&)>& write, const std::filesystem::path& path)
{
    int refused = 0;
    int loaded = 0;
    for (const std::string& pointer : members(document)) {
        if (pointer.find(only) == std::string::npos) continue;
        for (const Json& value : wrongValues()) {
            Json changed = document;
            const Json was = changed[Json::json_pointer(pointer)];
            changed[Json::json_pointer(pointer)] = value;
            write(changed);
            const std::string what = pointer + " = " + value.dump();
            Result<BakedScene> read = Error{ErrorCode::FileInvalid, "", ""};
            ASSERT_NO_THROW(read = readBakedScene(path)) << what;
            if (!read) {
                ++refused;
                EXPECT_FALSE(read.error().message.empty()) << what;
                EXPECT_THAT(read.error().message, testing::Not(HasSubstr("json.exception"))) << what;
                EXPECT_FALSE(read.error().object.empty()) << what << ": " << read.error().message;
                continue;
            }
            ++loaded;
            EXPECT_TRUE(sameType(was, value) || mayBeIgnored(pointer)) << what << " (was " << was.dump() << ") is read";
            Status written;
            ASSERT_NO_THROW(written = writeBakedScene(folder / "written.glb", pretendToBake(read->scene))) << what;
            if (!written) EXPECT_FALSE(written.error().message.empty()) << what;
        }
    }
    EXPECT_GT(refused, 20);
    EXPECT_GT(loaded, 3);
}

TEST(WrongTypes, InAPlainFileAreRefusedWithTheirPath)
{
    const TemporaryFolder folder;
    GltfBuilder file = richFile(folder);
    const auto path = file.write(folder);
    const auto read = readBakedScene(path);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->scene.objects.size(), 3u);
    ASSERT_EQ(read->scene.cameras.size(), 2u);
    std::ifstream stream(path);
    sweep(
        Json::parse(stream), "", folder, [&](const Json& json) { writeText(path, json.dump()); }, path);
}

TEST(WrongTypes, NumbersAndReferencesBeyondTheFileAreRefusedWithTheirPath)
{
    const TemporaryFolder folder;
    const GltfBuilder file = richFile(folder);
    struct Case {
        const char* pointer;
        Json value; // null: the member goes
        const char* sentence;
    };
    const Case cases[] = {
        {"/bufferViews/0/buffer", 1, "/bufferViews/0: refers to buffer 1 of 1"},
        {"/bufferViews/0/byteOffset", 4294967295u, "/bufferViews/0: reaches past the end of buffer 0"},
        {"/bufferViews/0/byteLength", 4294967296u, "/bufferViews/0/byteLength: is 4294967296, not an unsigned integer"},
        {"/bufferViews/0/byteStride", 6, "/bufferViews/0: byteStride is 6, not a multiple of 4 up to 252"},
        {"/bufferViews/0/byteStride", 256, "/bufferViews/0: byteStride is 256, not a multiple of 4"},
        {"/bufferViews/0/byteStride", 8, "/accessors/0: elements are longer than the stride"},
        {"/accessors/0/bufferView", 99, "/accessors/0: refers to buffer view 99 of "},
        {"/accessors/0/byteOffset", 2147483647, "/accessors/0: reads past the end of its buffer view"},
        {"/accessors/0/count", 2147483647, "/accessors/0: reads past the end of its buffer view"},
        {"/accessors/0/count", nullptr, "/accessors/0: has no count"},
        {"/accessors/0/componentType", 5124, "/accessors/0: has an unknown type or component type"},
        {"/accessors/0/componentType", 5131, "/accessors/0: has an unknown type or component type"},
        {"/accessors/0/type", "VEC5", "/accessors/0: has an unknown type or component type"},
        {"/accessors/1/sparse/count", 4, "/accessors/1: sparse count is out of range"},
        {"/accessors/1/sparse/indices", nullptr, "/accessors/1/sparse: has no indices"},
        {"/accessors/1/sparse/indices/componentType", 5126, "/accessors/1: sparse indices are not unsigned integers"},
        {"/accessors/1/sparse/indices/byteOffset", 1, "/accessors/1: sparse data reads past the end"},
        {"/accessors/1/sparse/values/bufferView", 99, "/accessors/1: refers to buffer view 99 of "},
        {"/accessors/2/bufferView", nullptr, "/meshes/0/primitives/0: indices are an accessor without a buffer view"},
        {"/meshes/0/primitives/0/indices", 99, "/meshes/0/primitives/0: refers to accessor 99 of "},
        {"/meshes/0/primitives/0/material", 2, "/meshes/0/primitives/0: refers to material 2 of 2"},
        {"/meshes/0/primitives/0/mode", 7, "/meshes/0/primitives/0: mode is not one of 0 to 6"},
        {"/textures/0/source", 1, "/textures/0: refers to image 1 of 1"},
        {"/textures/0/sampler", 1, "/textures/0: refers to sampler 1 of 1"},
        {"/skins/0/joints/0", 99, "/skins/0: refers to node 99, which does not exist"},
        {"/skins/0/inverseBindMatrices", 99, "/skins/0: inverseBindMatrices refers to an accessor"},
        {"/nodes/1/skin", 1, "/nodes/1: refers to skin 1 of 1"},
        {"/scenes/0/nodes/0", 99, "/scenes/0: refers to node 99 of "},
        {"/scene", 1, "/scene: refers to scene 1 of 1"},
        {"/extensions/KHR_lights_punctual/lights/0/spot", nullptr, "/lights/0: is a spot light and has no spot"},
    };
    for (const Case& c : cases) {
        GltfBuilder changed = file;
        const Json::json_pointer pointer(c.pointer);
        changed.json[pointer] = c.value;
        if (c.value.is_null()) changed.json[pointer.parent_pointer()].erase(pointer.back());
        const auto scene = readScene(changed.write(folder));
        EXPECT_THAT(scene ? "loaded" : scene.error().text(), HasSubstr(c.sentence)) << c.pointer;
    }
}

TEST(WrongTypes, InABakedFileAreRefusedWithTheirPath)
{
    const TemporaryFolder folder;
    GltfBuilder file = richFile(folder);
    auto scene = readScene(file.write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    scene->probePositions = {{1, 2, 3}};
    scene->objects[1].probeLighting = ProbeLighting::Volume;
    scene->objects[1].probeResolution = {3, 4, 5};
    scene->objects[1].lightmapScale = 2.5f;
    const auto path = folder / "baked.glb";
    const Status written = writeBakedScene(path, pretendToBake(*scene));
    ASSERT_TRUE(written) << written.error().text();
    ASSERT_TRUE(readBakedScene(path));
    std::vector<char> binary;
    Json document = jsonOfGlb(path, &binary);
    const auto pad = [](std::string text) {
        while (text.size() % 4 != 0) text += ' ';
        return text;
    };
    const auto u32 = [](std::size_t n) {
        std::string text;
        for (int i = 0; i < 4; ++i) text += char(n >> (8 * i) & 0xff);
        return text;
    };
    const auto write = [&](const Json& json) {
        const std::string text = pad(json.dump());
        writeText(path, "glTF" + u32(2) + u32(28 + text.size() + binary.size()) + u32(text.size()) + "JSON" + text +
                            u32(binary.size()) + std::string("BIN\0", 4) + std::string(binary.begin(), binary.end()));
    };
    for (const char* only : {"/HALFLIGHT_", "/attributes"}) sweep(document, only, folder, write, path);
}

} // namespace
} // namespace halflight::wrong_types_test
