// The extensions of written files follow docs/schemas. The checker below knows the words those schemas use and fails on
// any other, so that none is silently ignored.

#include "fixtures.h"
#include "scene/document/bake_ranges.h"

#include <algorithm>
#include <map>
#include <set>

namespace halflight::schema_test {
namespace {

using namespace test;
const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

class Schema {
public:
    explicit Schema(const std::string& extension)
    {
        std::ifstream stream(std::string(HALFLIGHT_SOURCE_DIR) + "/docs/schemas/" + extension + ".schema.json");
        root_ = Json::parse(stream);
    }
    /// What breaks the schema, or an empty text.
    [[nodiscard]] std::string check(const Json& value) const { return check(root_, value, ""); }

private:
    static bool hasType(const Json& value, const std::string& type)
    {
        if (type == "object") return value.is_object();
        if (type == "array") return value.is_array();
        if (type == "string") return value.is_string();
        if (type == "boolean") return value.is_boolean();
        if (type == "number") return value.is_number();
        if (type == "integer") return value.is_number_integer();
        ADD_FAILURE() << "unknown type " << type;
        return false;
    }

    std::string check(const Json& schema, const Json& value, const std::string& path) const
    {
        static const std::set<std::string> kWords = {"$schema",
                                                     "title",
                                                     "description",
                                                     "$defs",
                                                     "$ref",
                                                     "type",
                                                     "enum",
                                                     "minimum",
                                                     "maximum",
                                                     "minItems",
                                                     "maxItems",
                                                     "items",
                                                     "properties",
                                                     "required",
                                                     "additionalProperties",
                                                     "oneOf",
                                                     "exclusiveMinimum"};
        for (const auto& item : schema.items()) {
            if (kWords.count(item.key()) == 0) ADD_FAILURE() << "the checker does not know " << item.key();
        }
        if (schema.contains("$ref")) {
            const std::string error =
                check(root_["$defs"].at(schema["$ref"].get<std::string>().substr(8)), value, path);
            if (!error.empty()) return error;
        }
        if (schema.contains("oneOf")) {
            int matches = 0;
            for (const Json& option : schema["oneOf"]) matches += check(option, value, path).empty();
            if (matches != 1) return path + ": matches " + std::to_string(matches) + " of oneOf";
        }
        if (schema.contains("type") && !hasType(value, schema["type"]))
            return path + ": is not of type " + schema["type"].get<std::string>();
        if (schema.contains("enum") &&
            std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
            return path + ": is not in enum";
        if (schema.contains("minimum") && value < schema["minimum"]) return path + ": is below minimum";
        if (schema.contains("exclusiveMinimum") && value <= schema["exclusiveMinimum"])
            return path + ": is not above exclusiveMinimum";
        if (schema.contains("maximum") && value > schema["maximum"]) return path + ": is above maximum";
        if (schema.contains("minItems") && value.size() < schema["minItems"].get<std::size_t>())
            return path + ": has too few items";
        if (schema.contains("maxItems") && value.size() > schema["maxItems"].get<std::size_t>())
            return path + ": has too many items";
        if (schema.contains("items")) {
            for (std::size_t i = 0; i < value.size(); ++i) {
                const std::string error = check(schema["items"], value[i], path + "/" + std::to_string(i));
                if (!error.empty()) return error;
            }
        }
        if (schema.contains("required")) {
            for (const Json& name : schema["required"]) {
                if (!value.contains(name.get<std::string>())) return path + ": lacks " + name.get<std::string>();
            }
        }
        if (schema.contains("properties")) {
            for (const auto& [name, member] : value.items()) {
                if (schema["properties"].contains(name)) {
                    const std::string error = check(schema["properties"][name], member, path + "/" + name);
                    if (!error.empty()) return error;
                } else if (schema.value("additionalProperties", true) == false) {
                    return path + ": has the unknown property " + name;
                }
            }
        }
        return "";
    }

    Json root_;
};

// The numbers of a schema by their paths in a document, "a/*/b"; of an array of numbers, its items'.
void findNumbers(const Json& root, Json schema, const std::string& path, std::map<std::string, Json>& numbers)
{
    if (schema.contains("$ref")) schema.update(root["$defs"].at(schema["$ref"].get<std::string>().substr(8)));
    for (const Json& option : schema.value("oneOf", Json::array())) findNumbers(root, option, path, numbers);
    const Json properties = schema.value("properties", Json::object());
    for (const auto& [name, member] : properties.items()) findNumbers(root, member, path + "/" + name, numbers);
    const std::string type = schema.value("type", "");
    if (type == "array") {
        const std::string items = schema["items"].value("type", "");
        const bool isPlain = items == "number" || items == "integer";
        findNumbers(root, schema["items"], isPlain ? path : path + "/*", numbers);
    }
    if (type == "number" || type == "integer") numbers[path.substr(1)] = schema;
}

// One table says what the reader takes and what the web plug-in will; the schemas say the same.
TEST(Schemas, RangesAreThoseOfTheReader)
{
    std::map<std::string, Range> ranges;
    for (const Range& range : kBakeRanges) ranges.emplace(range.path, range);
    std::size_t compared = 0;
    for (const auto& [name, place] : {std::pair("HALFLIGHT_mixed_lighting", "extensions/HALFLIGHT_mixed_lighting"),
                                      std::pair("HALFLIGHT_node", "nodes/*/extensions/HALFLIGHT_node"),
                                      std::pair("HALFLIGHT_light", "nodes/*/extensions/HALFLIGHT_light"),
                                      std::pair("HALFLIGHT_material", "materials/*/extensions/HALFLIGHT_material")}) {
        std::ifstream stream(std::string(HALFLIGHT_SOURCE_DIR) + "/docs/schemas/" + name + ".schema.json");
        const Json root = Json::parse(stream);
        std::map<std::string, Json> numbers;
        findNumbers(root, root, "", numbers);
        for (const auto& [path, schema] : numbers) {
            const auto range = ranges.find(std::string(place) + "/" + path);
            if (range == ranges.end()) { // indices and counts, which the document itself limits
                EXPECT_EQ(schema["type"], "integer") << path << " has no range";
                continue;
            }
            ++compared;
            const char* least = range->second.above ? "exclusiveMinimum" : "minimum";
            ASSERT_TRUE(schema.contains(least) && schema.contains("maximum")) << path;
            EXPECT_EQ(schema[least].get<double>(), range->second.least) << path;
            EXPECT_EQ(schema["maximum"].get<double>(), range->second.most) << path;
            ranges.erase(range);
        }
    }
    EXPECT_GT(compared, 50u);
    for (const auto& [path, range] : ranges) ADD_FAILURE() << path << " is in no schema";
}

void checkFile(const std::filesystem::path& path, std::size_t& nodes, std::size_t& lights)
{
    const Json json = jsonOfGlb(path);
    ASSERT_TRUE(json.contains("extensions"));
    EXPECT_EQ(Schema("HALFLIGHT_mixed_lighting").check(json["extensions"].at("HALFLIGHT_mixed_lighting")), "") << path;
    const Schema nodeSchema("HALFLIGHT_node");
    const Schema lightSchema("HALFLIGHT_light");
    const Schema materialSchema("HALFLIGHT_material");
    const Schema textureSchema("HALFLIGHT_texture_ktx2");
    for (const Json& texture : json.value("textures", Json::array())) {
        const Json extensions = texture.value("extensions", Json::object());
        if (extensions.contains("HALFLIGHT_texture_ktx2"))
            EXPECT_EQ(textureSchema.check(extensions["HALFLIGHT_texture_ktx2"]), "") << path;
    }
    for (const Json& material : json.value("materials", Json::array())) {
        const Json extensions = material.value("extensions", Json::object());
        if (extensions.contains("HALFLIGHT_material"))
            EXPECT_EQ(materialSchema.check(extensions["HALFLIGHT_material"]), "") << extensions.dump();
    }
    for (const Json& node : json["nodes"]) {
        if (!node.contains("extensions")) continue;
        const Json& extensions = node["extensions"];
        if (extensions.contains("HALFLIGHT_node")) {
            EXPECT_EQ(nodeSchema.check(extensions["HALFLIGHT_node"]), "") << extensions.dump();
            ++nodes;
        }
        if (extensions.contains("HALFLIGHT_light")) {
            EXPECT_EQ(lightSchema.check(extensions["HALFLIGHT_light"]), "") << extensions.dump();
            ++lights;
        }
    }
    // Used, not required: any glTF viewer opens the file.
    const auto used = json["extensionsUsed"].get<std::set<std::string>>();
    EXPECT_TRUE(used.count("HALFLIGHT_mixed_lighting") == 1);
    for (const Json& name : json.value("extensionsRequired", Json::array())) {
        EXPECT_EQ(name.get<std::string>().find("HALFLIGHT"), std::string::npos);
        EXPECT_EQ(name.get<std::string>().find("MOZ"), std::string::npos);
    }
}

TEST(Schemas, WrittenFilesFollowThem)
{
    const TemporaryFolder folder;
    std::size_t nodes = 0;
    std::size_t lights = 0;
    ASSERT_TRUE(writeBakedScene(folder / "engine.glb", pretendToBake(engineScene(), false)));
    checkFile(folder / "engine.glb", nodes, lights);
    EXPECT_EQ(nodes, 3u);
    EXPECT_EQ(lights, 5u);
    for (const char* name : {"grey_white_room.glb", "grass_field_instanced.glb", "lights_all_types_playcanvas.glb"}) {
        if (!std::filesystem::exists(kScenes / name)) continue;
        auto scene = readScene(kScenes / name, {.decodeTextures = false});
        ASSERT_TRUE(scene) << scene.error().text();
        ASSERT_TRUE(writeBakedScene(folder / name, pretendToBake(std::move(*scene))));
        checkFile(folder / name, nodes, lights);
    }
}

TEST(Schemas, RefuseWhatIsWrong)
{
    const Json good = {{"mode", "mixed"},
                       {"shadowStrength", 1.0},
                       {"indirectMultiplier", 1.0},
                       {"castShadows", true},
                       {"radius", 0.0}};
    const Schema light("HALFLIGHT_light");
    EXPECT_EQ(light.check(good), "");
    Json bad = good;
    bad["mode"] = "half-baked";
    EXPECT_NE(light.check(bad), "");
    bad = good;
    bad["shadowStrength"] = 1.5;
    EXPECT_NE(light.check(bad), "");
    bad = good;
    bad.erase("radius");
    EXPECT_NE(light.check(bad), "");
    bad = good;
    bad["extra"] = 1;
    EXPECT_NE(light.check(bad), "");
    const Schema node("HALFLIGHT_node");
    EXPECT_NE(
        node.check({{"static", true}, {"castShadows", true}, {"receiveShadows", true}, {"lightmap", {{"page", 0}}}}),
        "");
    const Json lit = {{"static", false}, {"castShadows", true}, {"receiveShadows", true}, {"probes", "volume"}};
    EXPECT_EQ(node.check(lit), "");
    for (const Json& wrong : {Json(4), Json({1, 2}), Json({1, 2, 65}), Json({0, 2, 3})}) {
        bad = lit;
        bad["probeResolution"] = wrong;
        EXPECT_NE(node.check(bad), "") << wrong.dump();
    }
}

// The engine's scene, written and read back: the same scene.
TEST(EngineScene, ComesBackFromTheFile)
{
    const TemporaryFolder folder;
    const BakedScene baked = pretendToBake(engineScene(), false);
    ASSERT_TRUE(writeBakedScene(folder / "engine.glb", baked));
    const auto read = readBakedScene(folder / "engine.glb");
    ASSERT_TRUE(read) << read.error().text();
    const Scene& a = baked.scene;
    const Scene& b = read->scene;
    ASSERT_EQ(b.objects.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(a.objects[i].name, b.objects[i].name);
        EXPECT_EQ(a.objects[i].worldFromObject, b.objects[i].worldFromObject);
        EXPECT_EQ(a.objects[i].isStatic, b.objects[i].isStatic);
        EXPECT_EQ(a.objects[i].castShadows, b.objects[i].castShadows);
        EXPECT_EQ(a.objects[i].lightmapScale, b.objects[i].lightmapScale);
        EXPECT_EQ(int(a.objects[i].probeLighting), int(b.objects[i].probeLighting));
        EXPECT_EQ(a.objects[i].probeResolution, b.objects[i].probeResolution);
        expectSameTexels(a, a.objects[i], b, b.objects[i]);
    }
    EXPECT_EQ(b.meshes.size(), 1u); // three nodes, three lightmap materials, one mesh
    ASSERT_EQ(b.meshes[0].parts.size(), 2u);
    EXPECT_EQ(a.meshes[0].parts[0].positions, b.meshes[0].parts[0].positions);
    EXPECT_EQ(a.meshes[0].parts[0].uv[0], b.meshes[0].parts[0].uv[0]);
    EXPECT_TRUE(b.meshes[0].parts[1].uv[0].empty());
    ASSERT_EQ(b.materials.size(), 1u);
    EXPECT_EQ(a.materials[0].baseColor, b.materials[0].baseColor);
    EXPECT_EQ(a.materials[0].emissiveNits, b.materials[0].emissiveNits);
    EXPECT_EQ(a.materials[0].baseColorTexture.scale, b.materials[0].baseColorTexture.scale);
    EXPECT_EQ(int(b.materials[0].alphaMode), int(Material::AlphaMode::Mask));
    ASSERT_EQ(b.textures.size(), 1u);
    EXPECT_EQ(a.textures[0].pixels.texels(), b.textures[0].pixels.texels());
    EXPECT_EQ(int(b.textures[0].wrapU), int(Texture::Wrap::ClampToEdge));
    ASSERT_EQ(b.lights.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(a.lights[i].type, b.lights[i].type);
        EXPECT_EQ(a.lights[i].area(), b.lights[i].area());
        EXPECT_EQ(a.lights[i].name, b.lights[i].name);
        EXPECT_EQ(a.lights[i].intensity, b.lights[i].intensity);
        EXPECT_EQ(a.lights[i].position(), b.lights[i].position());
        EXPECT_EQ(a.lights[i].baking.occlusionMaskChannel, b.lights[i].baking.occlusionMaskChannel);
    }
    ASSERT_EQ(b.cameras.size(), 1u);
    EXPECT_EQ(a.cameras[0].worldFromCamera, b.cameras[0].worldFromCamera);
    EXPECT_EQ(a.sky.zenith, b.sky.zenith);
    EXPECT_EQ(a.probePositions, b.probePositions);
    EXPECT_EQ(read->lightmaps[1].texels(), baked.lightmaps[1].texels());
}

} // namespace
} // namespace halflight::schema_test
