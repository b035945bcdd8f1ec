// Core glTF of a bake: what it holds, and that nothing of Halflight is left in it.

#include "fixtures.h"
#include "scene/document/document.h"
#include "scene/load/load_document.h"
#include "validator.h"

#include "halflight/scene/export.h"

#include <gmock/gmock.h>

namespace halflight::export_test {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<ImageRgba8> twoPages()
{
    return {ImageRgba8(16, 16, u8vec4(200, 100, 50, 255)), ImageRgba8(16, 16, u8vec4(10, 20, 30, 128))};
}

class ExportFile : public testing::Test {
protected:
    void write(BakedScene baked, ExportStyle style, float exposureEv = 0.0f)
    {
        ExportOptions options;
        options.style = style;
        options.strength = 3.0f;
        options.exposureEv = exposureEv;
        const Status done = writeExport(file, std::move(baked), twoPages(), options, report);
        ASSERT_TRUE(done) << done.error().text();
        json = jsonOfGlb(file);
        EXPECT_THAT(json.dump(), testing::Not(HasSubstr("HALFLIGHT_")));
        EXPECT_EQ(report.bytes, std::filesystem::file_size(file));
        const auto loaded = loadDocument(file);
        ASSERT_TRUE(loaded) << loaded.error().text();
        document = *loaded;
    }
    const Json& materialOf(const Json& primitive) const
    {
        return json["materials"].at(primitive["material"].get<std::size_t>());
    }
    const Json& meshOf(const std::string& node) const
    {
        for (const Json& n : json["nodes"]) {
            if (n.value("name", "") == node) return json["meshes"].at(n["mesh"].get<std::size_t>());
        }
        throw std::runtime_error("no node " + node);
    }

    const TemporaryFolder folder;
    const std::filesystem::path file = folder / "export.glb";
    ExportReport report;
    Json json;
    std::shared_ptr<const SourceDocument> document;
};

TEST_F(ExportFile, HasTheCoordinatesOfEachObjectOnItsPage)
{
    const BakedScene baked = pretendToBake(engineScene());
    ASSERT_NO_FATAL_FAILURE(write(baked, ExportStyle::Unlit));
    EXPECT_EQ(report.surfaces, 2u);
    EXPECT_THAT(report.others, ElementsAre("quad 2"));
    for (const std::size_t o : {0u, 1u}) {
        const Object& object = baked.scene.objects[o];
        const Mesh& mesh = baked.scene.meshes[std::size_t(object.mesh)];
        const Json& primitives = meshOf(object.name)["primitives"];
        ASSERT_EQ(primitives.size(), mesh.parts.size());
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            const Json& attributes = primitives[p]["attributes"];
            EXPECT_EQ(attributes.size(), 3u) << attributes; // position, normal, one set of coordinates
            const auto uvs = readVectors<2>(*document, attributes["TEXCOORD_0"].get<int>());
            ASSERT_TRUE(uvs);
            ASSERT_EQ(uvs->size(), mesh.parts[p].lightmapUv.size());
            for (const uint32_t v : mesh.parts[p].indices) {
                const vec2 place = object.lightmap.scale * mesh.parts[p].lightmapUv[v] + object.lightmap.offset;
                EXPECT_LT(glm::distance((*uvs)[v], place), 1.0e-6f);
            }
            const Json& texture = materialOf(primitives[p])["pbrMetallicRoughness"]["baseColorTexture"];
            const Json& image = json["textures"].at(texture["index"].get<std::size_t>());
            const auto bytes = imageBytes(*document, image["source"].get<int>());
            ASSERT_TRUE(bytes);
            const auto picture = decodeImage(bytes->data(), bytes->size());
            ASSERT_TRUE(picture);
            EXPECT_EQ(picture->texels(), twoPages()[std::size_t(object.lightmap.page)].texels());
        }
    }
}

TEST_F(ExportFile, UnlitMaterialsKeepAlphaModeAndSides)
{
    ASSERT_NO_FATAL_FAILURE(write(pretendToBake(engineScene()), ExportStyle::Unlit));
    const Json& primitives = meshOf("quad 0")["primitives"];
    const Json& painted = materialOf(primitives[0]); // masked and double-sided
    EXPECT_EQ(painted["alphaMode"], "MASK");
    EXPECT_FALSE(painted.contains("alphaCutoff")) << "alpha is coverage";
    EXPECT_EQ(painted["doubleSided"], true);
    EXPECT_TRUE(painted["extensions"].contains("KHR_materials_unlit"));
    const Json& plain = materialOf(primitives[1]);
    EXPECT_FALSE(plain.contains("alphaMode"));
    EXPECT_FALSE(plain.contains("doubleSided"));
    EXPECT_THAT(json["extensionsUsed"].get<std::set<std::string>>(), testing::Contains("KHR_materials_unlit"));
}

TEST_F(ExportFile, EmissiveMaterialsAreBlackToLights)
{
    ASSERT_NO_FATAL_FAILURE(write(pretendToBake(engineScene()), ExportStyle::Emissive));
    const Json& primitives = meshOf("quad 0")["primitives"];
    for (const Json& primitive : primitives) {
        const Json& material = materialOf(primitive);
        EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorFactor"], Json({0, 0, 0, 1}));
        EXPECT_EQ(material["emissiveFactor"], Json({1, 1, 1}));
        EXPECT_EQ(material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 3.0);
        EXPECT_EQ(material["extensions"]["KHR_materials_specular"]["specularFactor"], 0);
        EXPECT_EQ(material["pbrMetallicRoughness"].contains("baseColorTexture"), material.contains("alphaMode"));
    }
}

TEST_F(ExportFile, ObjectsWithoutTexelsKeepTheirMaterialsAtTheSameExposure)
{
    ASSERT_NO_FATAL_FAILURE(write(pretendToBake(engineScene()), ExportStyle::Unlit, 2.0f));
    const Json& painted = materialOf(meshOf("quad 2")["primitives"][0]);
    EXPECT_EQ(painted["name"], "painted");
    EXPECT_TRUE(painted["pbrMetallicRoughness"].contains("baseColorTexture"));
    const Scene before = engineScene();
    const auto read = readScene(file);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->lights.size(), before.lights.size());
    for (std::size_t i = 0; i < before.lights.size(); ++i)
        EXPECT_NEAR(read->lights[i].intensity, before.lights[i].intensity / 4.0f, 1.0e-4f);
    for (const Material& material : read->materials) {
        if (material.name != "painted") continue;
        EXPECT_NEAR(material.emissiveNits.y, 5.0f / 4.0f, 1.0e-4f);
    }
    // What nothing uses is gone: three textures are the painted one and two pages.
    EXPECT_EQ(json["textures"].size(), 3u);
    EXPECT_EQ(json["images"].size(), 3u);
}

TEST_F(ExportFile, UnlitSurfacesOfTheSourceStay)
{
    Scene scene = engineScene();
    scene.materials[0].unlit = true;
    ASSERT_NO_FATAL_FAILURE(write(pretendToBake(scene), ExportStyle::Emissive));
    EXPECT_EQ(materialOf(meshOf("quad 0")["primitives"][0])["name"], "painted");
    EXPECT_EQ(materialOf(meshOf("quad 0")["primitives"][1])["name"], "surfaces 0");
}

TEST_F(ExportFile, InstancesBecomeNodes)
{
    GltfBuilder builder;
    builder.triangle();
    builder.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", builder.floats({0, 0, 0, 5, 0, 0, 0, 7, 0}, "VEC3", 3)}};
    const auto scene = readScene(builder.write(folder));
    ASSERT_TRUE(scene) << scene.error().text();
    const BakedScene baked = pretendToBake(*scene, false);
    ASSERT_NO_FATAL_FAILURE(write(baked, ExportStyle::Unlit));
    EXPECT_EQ(report.surfaces, 3u);
    EXPECT_THAT(json.dump(), testing::Not(HasSubstr("EXT_mesh_gpu_instancing")));
    const auto read = readScene(file);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->objects.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(read->objects[i].worldFromObject, baked.scene.objects[i].worldFromObject);
        EXPECT_EQ(read->objects[i].name, "triangle " + std::to_string(i));
        const Mesh& mesh = read->meshes[std::size_t(read->objects[i].mesh)];
        const LightmapBinding& place = baked.scene.objects[i].lightmap;
        const vec2 first = baked.scene.meshes[0].parts[0].lightmapUv[0];
        EXPECT_LT(glm::distance(mesh.parts[0].uv[0][0], place.scale * first + place.offset), 1.0e-6f);
    }
}

TEST_F(ExportFile, HasNoErrorForTheKhronosValidator)
{
    std::vector<std::filesystem::path> files;
    for (const ExportStyle style : {ExportStyle::Unlit, ExportStyle::Emissive}) {
        ASSERT_NO_FATAL_FAILURE(write(pretendToBake(engineScene()), style, 1.0f));
        files.push_back(folder / (std::string(nameOf(style)) + ".glb"));
        std::filesystem::rename(file, files.back());
    }
    validate(files);
}

} // namespace
} // namespace halflight::export_test
