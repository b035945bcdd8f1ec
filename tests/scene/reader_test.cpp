// The reader on files built here, where every number is known.

#include "fixtures.h"

#include <functional>
#include <gmock/gmock.h>

namespace halflight::reader_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;

Scene readOrDie(const std::filesystem::path& path, const std::filesystem::path& settings = {})
{
    auto scene = readScene(path, {.settingsFile = settings});
    EXPECT_TRUE(scene) << scene.error().text();
    return scene ? std::move(*scene) : Scene();
}

const MeshPart& onlyPart(const Scene& scene)
{
    return scene.meshes.at(0).parts.at(0);
}

TEST(ReaderGeometry, NonIndexedTriangleGetsFlatNormalAndSky)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    const Scene scene = readOrDie(file.write(folder));
    EXPECT_EQ(onlyPart(scene).indices, (std::vector<uint32_t>{0, 1, 2}));
    for (const vec3& n : onlyPart(scene).normals) EXPECT_EQ(n, vec3(0, 0, 1));
    EXPECT_EQ(scene.sky.zenith, vec3(1.0f));
    EXPECT_EQ(scene.sky.ground, vec3(0.5f));
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("white sky")));
    EXPECT_EQ(scene.objects.at(0).name, "triangle");
}

TEST(ReaderGeometry, StripAlternatesAndFanShares)
{
    const TemporaryFolder folder;
    for (const int mode : {5, 6}) {
        GltfBuilder file;
        file.json["meshes"] = {
            {{"primitives",
              {{{"mode", mode},
                {"attributes", {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3", 3)}}},
                {"indices", file.accessor<uint8_t>({0, 1, 2, 3, 4}, 5121, "SCALAR", 1)}}}}}};
        file.json["nodes"] = {{{"mesh", 0}}};
        const Scene scene = readOrDie(file.write(folder));
        const MeshPart& part = onlyPart(scene);
        std::vector<uint32_t> source;
        for (const uint32_t i : part.indices) source.push_back(part.sourceVertex.empty() ? i : part.sourceVertex[i]);
        if (mode == 5) {
            EXPECT_EQ(source, (std::vector<uint32_t>{0, 1, 2, 1, 3, 2, 2, 3, 4}));
            for (const vec3& n : part.normals)
                EXPECT_EQ(n, vec3(0, 0, 1)); // the strip's winding is the same everywhere
        } else {
            EXPECT_EQ(source, (std::vector<uint32_t>{1, 2, 0, 2, 3, 0, 3, 4, 0}));
        }
    }
}

TEST(ReaderGeometry, QuantizedNormalizedInterleavedAndSparse)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    file.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    // Interleaved: position int16 x3 + pad, normal int8 x3 + pad, uv uint16 x2 normalized: 16 bytes a vertex.
    struct Vertex {
        int16_t p[4];
        int8_t n[4];
        uint16_t uv[2];
    };
    const std::vector<Vertex> vertices = {{{-10, 0, 0, 0}, {0, 0, 127, 0}, {0, 65535}},
                                          {{20, 0, 0, 0}, {0, 0, 127, 0}, {65535, 0}},
                                          {{0, 30, 0, 0}, {0, -128, 0, 0}, {32768, 13107}}};
    const int view = file.view(vertices, 16);
    const int position = file.add({{"bufferView", view}, {"componentType", 5122}, {"type", "VEC3"}, {"count", 3}});
    const int normal = file.add({{"bufferView", view},
                                 {"byteOffset", 8},
                                 {"componentType", 5120},
                                 {"normalized", true},
                                 {"type", "VEC3"},
                                 {"count", 3}});
    const int uv = file.add({{"bufferView", view},
                             {"byteOffset", 12},
                             {"componentType", 5123},
                             {"normalized", true},
                             {"type", "VEC2"},
                             {"count", 3}});
    // Colours: no buffer view, element 2 set by a sparse entry.
    const int sparseIndex = file.view(std::vector<uint8_t>{2});
    const int sparseValue = file.view(std::vector<float>{0.25f, 0.5f, 0.75f});
    const int color = file.add({{"componentType", 5126},
                                {"type", "VEC3"},
                                {"count", 3},
                                {"sparse",
                                 {{"count", 1},
                                  {"indices", {{"bufferView", sparseIndex}, {"componentType", 5121}}},
                                  {"values", {{"bufferView", sparseValue}}}}}});
    file.json["meshes"] = {
        {{"primitives",
          {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}, {"COLOR_0", color}}}}}}}};
    file.json["nodes"] = {{{"mesh", 0}, {"scale", {0.5, 0.5, 0.5}}}};
    const Scene scene = readOrDie(file.write(folder));
    const MeshPart& part = onlyPart(scene);
    EXPECT_EQ(part.positions, (std::vector<vec3>{{-10, 0, 0}, {20, 0, 0}, {0, 30, 0}}));
    EXPECT_EQ(part.normals[0], vec3(0, 0, 1));
    EXPECT_EQ(part.normals[2], vec3(0, -1, 0)); // -128 is -1 as well
    EXPECT_EQ(part.uv[0][0], vec2(0, 1));
    EXPECT_FLOAT_EQ(part.uv[0][2].x, 32768.0f / 65535.0f);
    EXPECT_FLOAT_EQ(part.uv[0][2].y, 0.2f);
    EXPECT_EQ(part.colors[0], vec4(0, 0, 0, 1));
    EXPECT_EQ(part.colors[2], vec4(0.25f, 0.5f, 0.75f, 1.0f));
    EXPECT_EQ(scene.bounds().max, vec3(10, 15, 0));
}

TEST(ReaderGeometry, TangentsFollowTextureAndMirroredSeamsSplit)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    // Two triangles that share an edge; u grows along +x in the first and along -x in the second.
    const int position = file.floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0}, "VEC3", 3);
    const int normal = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
    const int uv = file.floats({0, 1, 1, 1, 1, 0, 0, 1}, "VEC2", 2);
    const int indices = file.accessor<uint16_t>({0, 1, 2, 1, 3, 2}, 5123, "SCALAR", 1);
    ImageRgba8 pixel(1, 1, u8vec4(128, 128, 255, 255));
    ASSERT_TRUE(writePng(folder / "n.png", pixel));
    file.json["images"] = {{{"uri", "n.png"}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["materials"] = {{{"normalTexture", {{"index", 0}, {"scale", 0.5}}}}};
    file.json["meshes"] = {{{"primitives",
                             {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}},
                               {"indices", indices},
                               {"material", 0}}}}}};
    file.json["nodes"] = {{{"mesh", 0}}};
    const Scene scene = readOrDie(file.write(folder));
    const MeshPart& part = onlyPart(scene);
    ASSERT_EQ(part.positions.size(), 6u); // vertices 1 and 2 doubled
    ASSERT_EQ(part.sourceVertex.size(), 6u);
    for (int corner = 0; corner < 6; ++corner) {
        const vec4 t = part.tangents[part.indices[std::size_t(corner)]];
        // v grows downwards and a normal map's green upwards: w = 1 unmirrored
        EXPECT_EQ(t, corner < 3 ? vec4(1, 0, 0, 1) : vec4(-1, 0, 0, -1)) << corner;
    }
    EXPECT_EQ(scene.materials[0].normalScale, 0.5f);
    EXPECT_EQ(scene.textures.at(0).pixels(0, 0), u8vec4(128, 128, 255, 255));
}

TEST(ReaderGeometry, InstancingMakesOneObjectEach)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    file.json["nodes"][0]["translation"] = {10, 0, 0};
    const float h = std::sqrt(0.5f);
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", file.floats({0, 1, 0, 0, 2, 0}, "VEC3", 3)},
        {"ROTATION", file.floats({0, 0, 0, 1, 0, 0, h, h}, "VEC4", 4)},
        {"SCALE", file.floats({1, 1, 1, 2, 2, 2}, "VEC3", 3)}};
    const Scene scene = readOrDie(file.write(folder));
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.objects[1].sourceInstance, 1);
    EXPECT_EQ(vec3(scene.objects[0].worldFromObject * vec4(1, 0, 0, 1)), vec3(11, 1, 0));
    const vec3 p(scene.objects[1].worldFromObject * vec4(1, 0, 0, 1)); // turned 90 degrees about z, scaled by 2
    EXPECT_LT(glm::distance(p, vec3(10, 4, 0)), 1.0e-5f);
}

TEST(ReaderNodes, NegativeScaleKeepsItsSignAndLightsStayRigid)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"},
         {"intensity", 5},
         {"range", 3},
         {"color", {1, 0.5, 0.25}},
         {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.4}}}}};
    file.json["nodes"][0]["scale"] = {-2, 3, 4};
    file.json["nodes"][0]["children"] = {1};
    file.json["nodes"].push_back(
        {{"name", "lamp"}, {"translation", {1, 0, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    const Scene scene = readOrDie(file.write(folder));
    EXPECT_FLOAT_EQ(glm::determinant(mat3(scene.objects[0].worldFromObject)), -24.0f);
    const Light& light = scene.lights.at(0);
    EXPECT_EQ(light.name, "lamp");
    EXPECT_EQ(light.position(), vec3(-2, 0, 0));
    EXPECT_EQ(light.direction(), vec3(0, 0, -1));
    EXPECT_FLOAT_EQ(glm::determinant(mat3(light.worldFromLight)), 1.0f);
    EXPECT_EQ(light.color, vec3(1, 0.5f, 0.25f));
    EXPECT_FLOAT_EQ(light.outerConeRadians, 0.4f);
    EXPECT_EQ(int(light.mode), int(LightMode::Mixed));
    EXPECT_TRUE(scene.sky.black()); // a file with a light gets no sky of ours
}

TEST(ReaderNodes, AnimatedSkinnedAndHidden)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["scenes"] = {{{"nodes", {0, 2, 3, 5}}}};
    file.json["nodes"] = {
        {{"name", "moving"}, {"children", {1}}},
        {{"name", "child"}, {"mesh", 0}},
        {{"name", "still"}, {"mesh", 0}},
        {{"name", "hidden"}, {"children", {4}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}},
        {{"name", "below hidden"}, {"mesh", 0}},
        {{"name", "skinned"}, {"mesh", 0}, {"skin", 0}}};
    file.json["skins"] = {{{"joints", {2}}}};
    const int times = file.floats({0, 1}, "SCALAR", 1);
    const int values = file.floats({0, 0, 0, 1, 0, 0}, "VEC3", 3);
    file.json["animations"] = {{{"samplers", {{{"input", times}, {"output", values}}}},
                                {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    const Scene scene = readOrDie(file.write(folder));
    ASSERT_EQ(scene.objects.size(), 3u);
    EXPECT_EQ(scene.objects[0].name, "child");
    EXPECT_FALSE(scene.objects[0].isStatic);
    EXPECT_TRUE(scene.objects[1].isStatic);
    EXPECT_EQ(scene.objects[2].name, "skinned");
    EXPECT_FALSE(scene.objects[2].isStatic);
    EXPECT_EQ(scene.meshes.size(), 1u);
}

TEST(ReaderMaterials, TextureTransformEmissionAndUnlit)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    ASSERT_TRUE(writePng(folder / "a b.png", ImageRgba8(2, 1, u8vec4(9, 8, 7, 6))));
    file.json["images"] = {{{"uri", "a%20b.png"}}, {{"uri", "missing.png"}}};
    file.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
    file.json["textures"] = {{{"source", 1}}, {{"source", 0}, {"sampler", 0}}}; // texture 0 is used by nothing
    file.json["materials"] = {
        {{"emissiveFactor", {1, 0.5, 0}},
         {"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 40}}}, {"KHR_materials_unlit", Json::object()}}},
         {"pbrMetallicRoughness",
          {{"baseColorTexture",
            {{"index", 1},
             {"texCoord", 0},
             {"extensions",
              {{"KHR_texture_transform",
                {{"offset", {0.5, 0.25}}, {"scale", {2, 3}}, {"rotation", 1.5}, {"texCoord", 1}}}}}}}}}}};
    file.json["meshes"][0]["primitives"][0]["material"] = 0;
    const Scene scene = readOrDie(file.write(folder));
    const Material& material = scene.materials.at(0);
    EXPECT_EQ(material.emissiveNits, vec3(40, 20, 0));
    EXPECT_TRUE(material.unlit);
    EXPECT_EQ(material.baseColorTexture.texCoord, 1);
    EXPECT_EQ(material.baseColorTexture.offset, vec2(0.5f, 0.25f));
    EXPECT_EQ(material.baseColorTexture.scale, vec2(2, 3));
    EXPECT_EQ(material.baseColorTexture.rotationRadians, 1.5f);
    ASSERT_EQ(scene.textures.size(), 1u);
    EXPECT_EQ(scene.textures[0].sourceTexture, 1);
    EXPECT_TRUE(scene.textures[0].nearest);
    EXPECT_EQ(int(scene.textures[0].wrapU), int(Texture::Wrap::ClampToEdge));
    EXPECT_EQ(int(scene.textures[0].wrapV), int(Texture::Wrap::MirroredRepeat));
    // TEXCOORD_1 is the texture's: lightmap coordinates go elsewhere.
    EXPECT_EQ(onlyPart(scene).lightmapTexCoord, 2);
}

TEST(ReaderErrors, GeometryFartherThanTenThousandKilometres)
{
    const TemporaryFolder folder;
    const auto read = [&](const std::function<void(GltfBuilder&)>& change) {
        GltfBuilder file;
        file.triangle();
        change(file);
        return readScene(file.write(folder));
    };
    const auto expectTooFar = [&](const std::function<void(GltfBuilder&)>& change, const char* path) {
        const auto scene = read(change);
        ASSERT_FALSE(scene);
        EXPECT_EQ(scene.error().code, ErrorCode::FileInvalid);
        EXPECT_EQ(scene.error().object, path);
        EXPECT_THAT(scene.error().message, testing::AnyOf(HasSubstr("10000 km from the scene's middle"),
                                                          HasSubstr("16777 km from the world's origin")));
    };
    const auto attributes = [](GltfBuilder& file) -> Json& {
        return file.json["meshes"][0]["primitives"][0]["attributes"];
    };
    expectTooFar(
        [&](GltfBuilder& file) {
            attributes(file)["POSITION"] = file.floats({0, 0, 0, 1e30f, 0, 0, 0, 1, 0}, "VEC3", 3);
        },
        "/nodes/0");
    expectTooFar([](GltfBuilder& file) { file.json["nodes"][0]["translation"] = {0, -1e30, 0}; }, "/nodes/0");
    expectTooFar([](GltfBuilder& file) { file.json["nodes"][0]["scale"] = {1.1e7, 1, 1}; }, "/nodes/0");
    expectTooFar(
        [](GltfBuilder& file) {
            const int translation = file.floats({0, 0, 0, 0, 0, 2e7f}, "VEC3", 3);
            file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
                {"TRANSLATION", translation}};
            file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
        },
        "/nodes/0");
    expectTooFar(
        [](GltfBuilder& file) {
            file.json["scenes"][0]["extras"]["halflight_probes"] = {{0, 1e30, 0}};
        },
        "/scenes/0");
    // Large but not too large; and a turned triangle whose bounds' corners lie beyond while its own do not.
    EXPECT_TRUE(read([](GltfBuilder& file) { file.json["nodes"][0]["scale"] = {9e6, 9e6, 1}; }));
    EXPECT_TRUE(read([](GltfBuilder& file) {
        file.json["nodes"][0]["scale"] = {9e6, 9e6, 1};
        file.json["nodes"][0]["rotation"] = {0, 0, 0.38268343, 0.92387953};
    }));
}

TEST(ReaderErrors, EachNamesItsObject)
{
    const TemporaryFolder folder;
    const auto errorOf = [&](const std::function<void(GltfBuilder&)>& damage) {
        GltfBuilder file;
        file.triangle();
        damage(file);
        const auto scene = readScene(file.write(folder));
        return scene ? std::string("loaded") : scene.error().text();
    };
    EXPECT_THAT(errorOf([](auto& f) { f.json["nodes"][0]["mesh"] = 7; }), HasSubstr("/nodes/0: refers to mesh 7 of 1"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["accessors"][0]["count"] = 1000; }),
                HasSubstr("/accessors/0: reads past the end"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["accessors"][0]["count"] = 4000000000u; }), HasSubstr("/accessors/0"));
    EXPECT_THAT(errorOf([](auto& f) {
                    f.json["accessors"][0].erase("bufferView");
                    f.json["accessors"][0]["count"] = 2000000000;
                }),
                HasSubstr("no data"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["accessors"][0]["byteOffset"] = -4; }),
                HasSubstr("/accessors/0/byteOffset: is -4, not an unsigned integer"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["extensionsRequired"] = {"KHR_texture_basisu"}; }),
                HasSubstr("`npx @gltf-transform/cli ktxdecompress IN.glb OUT.glb` makes a file without it"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["nodes"][0]["children"] = {0}; }), HasSubstr("/nodes/0"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["nodes"][0]["extras"]["halflight_static"] = "yes"; }),
                HasSubstr("halflight_static must be"));
    EXPECT_THAT(errorOf([](auto& f) {
                    f.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = 99;
                }),
                HasSubstr("accessor"));
    EXPECT_THAT(errorOf([](auto& f) { f.json["nodes"] = "none"; }), HasSubstr("/nodes: is \"none\", not an array"));
    EXPECT_THAT(
        errorOf([](auto& f) { f.json["extras"] = Json::parse(std::string(2000, '[') + std::string(2000, ']')); }),
        HasSubstr("nested"));
    EXPECT_THAT(errorOf([](auto& f) {
                    f.json["buffers"] = Json::array();
                    f.json["bufferViews"][0]["byteLength"] = 3;
                }),
                testing::Not(HasSubstr("loaded")));
}

// Truncations and single-byte changes of a real file: an error or a scene, never a crash (meant for AddressSanitizer).
TEST(ReaderErrors, DamagedFilesNeverCrash)
{
    const auto path = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes" / "cornell_box_emissive.glb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    std::ifstream stream(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    const TemporaryFolder folder;
    int loaded = 0;
    int refused = 0;
    for (uint32_t i = 0; i < 1500; ++i) {
        std::string damaged = bytes;
        if (i < 100) {
            damaged.resize(bytes.size() * i / 100);
        } else {
            for (uint32_t k = 0; k < 1 + i % 4; ++k)
                damaged[hashCombine(i, k) % 7000] = char("0123456789-e[]{},:\"\xff"[hashCombine(i, 100 + k) % 20]);
        }
        writeText(folder / "damaged.glb", damaged);
        const auto scene = readBakedScene(folder / "damaged.glb");
        ++(scene ? loaded : refused);
        if (!scene) EXPECT_FALSE(scene.error().message.empty());
    }
    EXPECT_GT(refused, 300);
    EXPECT_GT(loaded, 10);
}

} // namespace
} // namespace halflight::reader_test
