// Files as in the wild: extensions that baked light does not need, animation by pointer, old materials, odd cameras.

#include "fixtures.h"

#include <functional>
#include <gmock/gmock.h>

namespace halflight::odd_files_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

Scene readOrDie(const std::filesystem::path& path)
{
    auto scene = readScene(path);
    EXPECT_TRUE(scene) << scene.error().text();
    return scene ? std::move(*scene) : Scene();
}

Scene readWith(const std::function<void(GltfBuilder&)>& change)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    change(file);
    return readOrDie(file.write(folder));
}

TEST(Extensions, ThoseWithoutABearingOnBakedLightNeverRefuseAFile)
{
    for (const char* name : {"KHR_materials_ior", "KHR_materials_clearcoat", "KHR_materials_sheen",
                             "KHR_materials_iridescence", "KHR_materials_anisotropy", "KHR_materials_dispersion",
                             "KHR_materials_diffuse_transmission", "KHR_xmp_json_ld", "MSFT_lod"}) {
        const Scene scene = readWith([&](GltfBuilder& file) {
            file.json["extensionsUsed"] = {name};
            file.json["extensionsRequired"] = {name};
            file.json["materials"] = {{{"extensions", {{name, {{"ior", 1.4}}}}}}};
        });
        EXPECT_EQ(scene.objects.size(), 1u);
        EXPECT_THAT(scene.warnings, Contains(HasSubstr(name)));
    }
    // One warning for all of them; one for what is unknown, and nothing about what is read.
    const Scene scene = readWith([](GltfBuilder& file) {
        file.json["extensionsUsed"] = {"KHR_materials_ior", "KHR_materials_sheen", "ACME_rocket", "KHR_lights_punctual",
                                       "KHR_animation_pointer"};
    });
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("\"KHR_materials_ior\", \"KHR_materials_sheen\"")));
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("does not know them: \"ACME_rocket\"")));
    EXPECT_THAT(scene.warnings, Not(Contains(HasSubstr("KHR_animation_pointer"))));
    // What is unknown may be anything: a file that requires it is refused.
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["extensionsRequired"] = {"ACME_rocket"};
    EXPECT_FALSE(readScene(file.write(folder)));
}

TEST(Extensions, SpecularGlossinessGivesItsDiffuseColour)
{
    const Json old = {{"diffuseFactor", {0.5, 0.25, 0.125, 1}},
                      {"diffuseTexture", {{"index", 0}}},
                      {"specularFactor", {0.02, 0.02, 0.02}},
                      {"glossinessFactor", 0.75}};
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    ASSERT_TRUE(writePng(folder / "a.png", ImageRgba8(2, 1, u8vec4(9, 8, 7, 6))));
    file.json["images"] = {{{"uri", "a.png"}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["materials"] = {{{"extensions", {{"KHR_materials_pbrSpecularGlossiness", old}}}}};
    file.json["extensionsRequired"] = {"KHR_materials_pbrSpecularGlossiness"};
    Scene scene = readOrDie(file.write(folder));
    const Material& material = scene.materials.at(0);
    EXPECT_EQ(material.baseColor, vec4(0.5f, 0.25f, 0.125f, 1));
    EXPECT_TRUE(material.baseColorTexture);
    EXPECT_EQ(material.metallic, 0.0f);
    EXPECT_EQ(material.roughness, 0.25f);
    EXPECT_FLOAT_EQ(material.specular, 0.5f);
    EXPECT_THAT(scene.warnings, Contains(HasSubstr("/materials/0/extensions/KHR_materials_pbrSpecularGlossiness")));
    // The fallback that its author wrote beside it is for programs like this one.
    file.json["materials"][0]["pbrMetallicRoughness"] = {{"baseColorFactor", {1, 0, 0, 1}}, {"metallicFactor", 0.5}};
    scene = readOrDie(file.write(folder));
    EXPECT_EQ(scene.materials.at(0).baseColor, vec4(1, 0, 0, 1));
    EXPECT_EQ(scene.materials.at(0).metallic, 0.5f);
}

/// A file whose only animation targets `pointer`.
void animate(GltfBuilder& file, const std::string& pointer)
{
    const int times = file.floats({0, 1}, "SCALAR", 1);
    const int values = file.floats({0, 0, 0, 1, 0, 0}, "VEC3", 3);
    file.json["extensionsUsed"] = {"KHR_animation_pointer"};
    file.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", values}}}},
         {"channels",
          {{{"sampler", 0},
            {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}}}}}};
}

TEST(AnimationPointer, NodesThatItMovesShowsOrMorphsAreDynamic)
{
    for (const char* pointer :
         {"/nodes/1/translation", "/nodes/1/rotation", "/nodes/1/scale", "/nodes/0/translation", "/nodes/1/weights",
          "/nodes/1/weights/0", "/meshes/0/weights", "/nodes/1/extensions/KHR_node_visibility/visible"}) {
        const Scene scene = readWith([&](GltfBuilder& file) {
            file.json["nodes"] = {{{"children", {1}}}, {{"mesh", 0}}};
            animate(file, pointer);
        });
        EXPECT_FALSE(scene.objects.at(0).isStatic) << pointer;
    }
    for (const char* pointer : {"/nodes/0/translation", "/nodes/1/name", "/nodes/12/translation", "/nodes/1",
                                "/nodes//translation", "nonsense", ""}) {
        const Scene scene = readWith([&](GltfBuilder& file) {
            file.json["nodes"] = {{{"name", "empty"}}, {{"mesh", 0}}};
            file.json["scenes"] = {{{"nodes", {0, 1}}}};
            animate(file, pointer);
        });
        EXPECT_TRUE(scene.objects.at(0).isStatic) << pointer;
    }
}

TEST(AnimationPointer, LightsAndMaterialsOfTheBakeAreNamed)
{
    const auto warningsOf = [](const std::string& pointer, const Json& extras) {
        return readWith([&](GltfBuilder& file) {
                   file.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"extras", extras}}};
                   file.json["nodes"].push_back(
                       {{"name", "lamp"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
                   file.json["scenes"] = {{{"nodes", {0, 1}}}};
                   file.json["materials"] = {{{"name", "screen"}}};
                   file.json["meshes"][0]["primitives"][0]["material"] = 0;
                   animate(file, pointer);
               })
            .warnings;
    };
    const std::string lights = "/extensions/KHR_lights_punctual/lights/0/";
    EXPECT_THAT(warningsOf(lights + "intensity", {}), Contains(HasSubstr("its bounced light stays as baked")));
    EXPECT_THAT(warningsOf(lights + "range", {}), Contains(HasSubstr("baked shadows and bounced light stay")));
    EXPECT_THAT(warningsOf(lights + "color", {{"halflight_mode", "baked"}}), Contains(HasSubstr("all of its light")));
    EXPECT_THAT(warningsOf(lights + "color", {{"halflight_mode", "realtime"}}), Not(Contains(HasSubstr("lamp"))));
    EXPECT_THAT(warningsOf(lights + "color", {{"halflight_indirect_multiplier", 0}}), Not(Contains(HasSubstr("lamp"))));
    EXPECT_THAT(warningsOf("/materials/0/emissiveFactor", {}), Contains(HasSubstr("\"screen\"")));
    EXPECT_THAT(warningsOf("/materials/7/emissiveFactor", {}), Not(Contains(HasSubstr("animated materials"))));
}

TEST(Cameras, OddOnesAreLeftOutWithTheReasonAndTheRestIsRead)
{
    const auto read = [](const Json& camera) {
        return readWith([&](GltfBuilder& file) {
            file.json["cameras"] = {camera};
            file.json["nodes"][0]["camera"] = 0;
        });
    };
    const auto perspective = [](Json lens) { return Json{{"type", "perspective"}, {"perspective", std::move(lens)}}; };
    const auto orthographic = [](Json lens) {
        return Json{{"type", "orthographic"}, {"orthographic", std::move(lens)}};
    };
    const std::vector<std::pair<Json, const char*>> odd = {
        {perspective({{"yfov", 0.8}, {"znear", 0}, {"zfar", 1000}}), "znear is not above 0"},
        {perspective({{"yfov", 0.8}, {"znear", -1}}), "znear is not above 0"},
        {perspective({{"yfov", 0.8}, {"znear", 1}, {"zfar", 0.5}}), "zfar is not beyond znear"},
        {perspective({{"yfov", 0}, {"znear", 1}}), "yfov"},
        {perspective({{"yfov", 3.5}, {"znear", 1}}), "yfov"},
        {orthographic({{"xmag", 1}, {"ymag", 0}, {"znear", 0}, {"zfar", 10}}), "ymag"},
        {orthographic({{"xmag", 1}, {"ymag", 1}, {"znear", -1}, {"zfar", 10}}), "znear is below 0"},
        {orthographic({{"xmag", 1}, {"ymag", 1}, {"znear", 3}, {"zfar", 3}}), "zfar is not beyond znear"},
    };
    for (const auto& [camera, reason] : odd) {
        const Scene scene = read(camera);
        EXPECT_EQ(scene.cameras.size(), 0u) << camera;
        EXPECT_EQ(scene.objects.size(), 1u);
        EXPECT_THAT(scene.warnings, Contains(testing::AllOf(HasSubstr("/cameras/0"), HasSubstr(reason)))) << camera;
    }
    const Scene tiny = read(perspective({{"yfov", 0.8}, {"znear", 5e-7}, {"zfar", 0.1}, {"aspectRatio", 0}}));
    ASSERT_EQ(tiny.cameras.size(), 1u);
    EXPECT_EQ(tiny.cameras[0].nearMeters, 5e-7f);
    EXPECT_EQ(tiny.cameras[0].farMeters, 0.1f);
    // glTF 2.0, section 5.13.3: without zfar the projection is infinite.
    for (const double znear : {0.1, 5000.0}) {
        const Scene infinite = read(perspective({{"yfov", 0.8}, {"znear", znear}}));
        ASSERT_EQ(infinite.cameras.size(), 1u);
        EXPECT_EQ(infinite.cameras[0].farMeters, kInfinity);
    }
    EXPECT_EQ(read(orthographic({{"xmag", -1}, {"ymag", -1}, {"znear", 0}, {"zfar", 3}})).cameras.size(), 1u);
}

TEST(Brightness, BeyondWhatABakeCanSumIsRefusedWithItsPath)
{
    const auto errorOf = [](const std::function<void(GltfBuilder&)>& change) {
        const TemporaryFolder folder;
        GltfBuilder file;
        file.triangle();
        change(file);
        const auto scene = readScene(file.write(folder));
        return scene ? std::string("loaded") : scene.error().text();
    };
    const auto emission = [](double strength) {
        return [=](GltfBuilder& f) {
            f.json["materials"] = {
                {{"emissiveFactor", {0, 0.5, 0}},
                 {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", strength}}}}}}};
        };
    };
    const auto lamp = [](double intensity, const Json& extras) {
        return [=](GltfBuilder& f) {
            f.json["extensions"]["KHR_lights_punctual"]["lights"] = {
                {{"type", "point"}, {"intensity", intensity}, {"extras", extras}}};
            f.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
        };
    };
    const auto sky = [](double radiance) {
        return [=](GltfBuilder& f) { f.json["scenes"][0]["extras"]["halflight_sky_ground"] = radiance; };
    };
    EXPECT_EQ(errorOf(emission(1.9e12)), "loaded");
    EXPECT_THAT(errorOf(emission(2.1e12)), HasSubstr("/materials/0: its emission is brighter than 1e12"));
    EXPECT_EQ(errorOf(lamp(1e12, {})), "loaded");
    EXPECT_THAT(errorOf(lamp(1e30, {})), HasSubstr("/nodes/0: light \"triangle\" is brighter"));
    EXPECT_THAT(errorOf(lamp(1e3, {{"halflight_indirect_multiplier", 1e10}})),
                HasSubstr("halflight_indirect_multiplier must be a number from 0 to 1000000"));
    EXPECT_EQ(errorOf(sky(1e12)), "loaded");
    EXPECT_THAT(errorOf(sky(1e30)), HasSubstr("/scenes/0: its sky"));
}

TEST(Brightness, NoNumberThatIsNotFiniteIsWrittenOrRead)
{
    const TemporaryFolder folder;
    const float bad = std::numeric_limits<float>::infinity();
    const std::vector<std::function<void(BakedScene&)>> changes = {
        [&](BakedScene& b) { b.probes.probes[3].radiance[8].z = bad; },
        [&](BakedScene& b) { b.probes.probes[0].occlusion[3] = bad - bad; },
        [&](BakedScene& b) { b.probes.probes[7].position.x = bad; },
        [&](BakedScene& b) { b.lightmapUnitLux = bad; },
        [&](BakedScene& b) { b.scene.objects[0].lightmap.offset.y = bad; },
        [&](BakedScene& b) { b.scene.meshes[0].parts[1].lightmapUv[2].x = bad - bad; }};
    for (std::size_t i = 0; i < changes.size(); ++i) {
        BakedScene baked = pretendToBake(engineScene(), false);
        changes[i](baked);
        const Status written = writeBakedScene(folder / "baked.glb", baked);
        EXPECT_FALSE(written) << i;
        EXPECT_FALSE(std::filesystem::exists(folder / "baked.glb"));
    }
    // A file from elsewhere, with a NaN in its probes' radiance.
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene(), false)));
    std::vector<char> binary;
    const Json json = jsonOfGlb(folder / "baked.glb", &binary);
    const auto accessor = json["extensions"]["HALFLIGHT_mixed_lighting"]["probes"]["radiance"].get<std::size_t>();
    const Json& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    std::fstream file(folder / "baked.glb", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(std::streamoff(std::filesystem::file_size(folder / "baked.glb") - binary.size() +
                              view.value("byteOffset", std::size_t(0)) + 40));
    file.write("\xff\xff\xff\xff", 4);
    file.close();
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_FALSE(read);
    EXPECT_THAT(read.error().text(),
                HasSubstr("/accessors/" + std::to_string(accessor) + ": element 3 holds a number that is not finite"));
}

TEST(Advice, BlenderFilesWithoutLightsAndRoomsInCentimetres)
{
    const auto blender = [](const std::string& generator, bool sky) {
        return readWith([&](GltfBuilder& file) {
                   file.json["asset"]["generator"] = generator;
                   if (sky) file.json["scenes"][0]["extras"]["halflight_sky"] = 1;
               })
            .warnings;
    };
    const auto named = testing::AllOf(HasSubstr("Punctual Lights"), HasSubstr("Custom Properties"));
    EXPECT_THAT(blender("Khronos glTF Blender I/O v4.2.60", false), Contains(named));
    EXPECT_THAT(blender("Khronos glTF Blender I/O v4.2.60", true), Not(Contains(named)));
    EXPECT_THAT(blender("Another", false), Not(Contains(named)));
    // A room of 5 x 3 x 5 with furniture, by the length of its unit; and the same with small things in it.
    const auto room = [](float unit, float small) {
        return readWith([&](GltfBuilder& file) {
                   Json nodes = Json::array();
                   const auto add = [&](vec3 at, float size) {
                       nodes.push_back({{"mesh", 0},
                                        {"translation", {unit * at.x, unit * at.y, unit * at.z}},
                                        {"scale", {unit * size, unit * size, unit * size}}});
                   };
                   add({0, 0, 0}, 5.0f);
                   add({0, 2, 3}, 1.0f);
                   for (int i = 0; i < 4; ++i) add({float(i), 0, 1}, 0.5f);
                   for (int i = 0; i < 4; ++i) add({float(i), 1, 1}, small);
                   file.json["nodes"] = nodes;
                   file.json["scenes"] = {{{"nodes", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}}}};
               })
            .warnings;
    };
    EXPECT_THAT(room(100.0f, 0.5f), Contains(HasSubstr("centimetres")));
    EXPECT_THAT(room(1.0f, 0.5f), Not(Contains(HasSubstr("centimetres"))));
    EXPECT_THAT(room(100.0f, 0.01f), Not(Contains(HasSubstr("centimetres"))));
}

} // namespace
} // namespace halflight::odd_files_test
