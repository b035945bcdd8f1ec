// KHR_materials_transmission as the share of light that a surface stops, and what gives passing light its colour.

#include "fixtures.h"

#include "halflight/scene/fingerprint.h"

#include <gmock/gmock.h>

namespace halflight::glass_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TEST(Glass, TransmissionLetsLightPass)
{
    const auto materialOf = [](const Json& json) {
        const TemporaryFolder folder;
        GltfBuilder file;
        file.triangle();
        file.json["materials"] = {json};
        file.json["extensionsRequired"] = {"KHR_materials_transmission"};
        file.json["meshes"][0]["primitives"][0]["material"] = 0;
        const auto scene = readScene(file.write(folder));
        EXPECT_TRUE(scene);
        return scene ? scene->materials.at(0) : Material();
    };
    const auto glass = [](float factor, float metallic, const char* mode, float alpha) {
        return Json{{"alphaMode", mode},
                    {"pbrMetallicRoughness", {{"metallicFactor", metallic}, {"baseColorFactor", {1, 1, 1, alpha}}}},
                    {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", factor}}}}}};
    };
    // An opaque material has no alpha; the faces of the clearest glass reflect 4 %. What is cut out lets all pass.
    const auto stopped = [&](float factor, float metallic, const char* mode, float alpha) {
        const Material material = materialOf(glass(factor, metallic, mode, alpha));
        return material.coverage(material.baseColor.w, material.metallic, 1.0f);
    };
    EXPECT_NEAR(stopped(1, 0, "OPAQUE", 0.5f), 0.04f, 1e-6f);
    EXPECT_NEAR(stopped(0.5f, 0.5f, "OPAQUE", 1), 0.76f, 1e-6f);
    EXPECT_NEAR(stopped(1, 0, "BLEND", 0.5f), 0.02f, 1e-6f);
    EXPECT_NEAR(stopped(1, 0, "MASK", 1), 0.04f, 1e-6f);
    EXPECT_NEAR(stopped(1, 0, "MASK", 0.4f), 0.0f, 1e-6f);
    EXPECT_TRUE(materialOf(glass(1, 0, "MASK", 1)).isBlended());
    // Not metals, nor unlit materials, whose other properties do not count.
    EXPECT_TRUE(materialOf(glass(1, 1, "OPAQUE", 1)).isOpaque());
    EXPECT_TRUE(materialOf(glass(0, 0, "OPAQUE", 0.5f)).isOpaque());
    Json unlit = glass(1, 0, "OPAQUE", 1);
    unlit["extensions"]["KHR_materials_unlit"] = Json::object();
    EXPECT_TRUE(materialOf(unlit).isOpaque());
    EXPECT_FALSE(materialOf(glass(1, 1, "MASK", 1)).isBlended());
}

// A volume needs transmission, a thickness and a colour; values beyond the extension's ranges are errors.
TEST(Glass, VolumeAndTintS35)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    const Json glass = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                        {"KHR_materials_volume",
                         {{"thicknessFactor", 0.1}, {"attenuationDistance", 2}, {"attenuationColor", {0.5, 1, 0.25}}}}};
    Json thin = glass;
    thin["KHR_materials_volume"].erase("thicknessFactor");
    Json stone = glass;
    stone.erase("KHR_materials_transmission");
    file.json["materials"] = {{{"name", "glass"}, {"extensions", glass}},
                              {{"name", "thin"}, {"extensions", thin}},
                              {{"name", "stone"}, {"extensions", stone}},
                              {{"name", "film"}, {"alphaMode", "BLEND"}, {"extras", {{"halflight_tinted", 1}}}}};
    for (Json& material : file.json["materials"]) material["pbrMetallicRoughness"] = {{"metallicFactor", 0}};
    file.json["extensionsUsed"] = {"KHR_materials_transmission", "KHR_materials_volume"};
    const std::filesystem::path path = file.write(folder);
    const auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_THAT(scene->warnings, Not(Contains(HasSubstr("KHR_materials_volume"))));
    const std::vector<Material>& materials = scene->materials;
    EXPECT_TRUE(materials[0].attenuates());
    EXPECT_EQ(materials[0].attenuationColor, vec3(0.5f, 1.0f, 0.25f));
    EXPECT_EQ(materials[0].attenuationMeters, 2.0f);
    EXPECT_EQ(materials[0].thickness, 0.1f);
    EXPECT_FALSE(materials[1].attenuates());
    EXPECT_FALSE(materials[2].attenuates());
    EXPECT_TRUE(materials[3].tinted);
    EXPECT_FALSE(materials[0].tinted);

    // The settings file is stronger, and the written file says it.
    writeText(folder / "s.toml", "[[material]]\npattern = \"film\"\ntinted = false\n"
                                 "[[material]]\npattern = \"thin\"\ntinted = true\n");
    const auto other = readScene(path, {.settingsFile = folder / "s.toml"});
    ASSERT_TRUE(other) << other.error().text();
    EXPECT_FALSE(other->materials[3].tinted);
    EXPECT_TRUE(other->materials[1].tinted);
    EXPECT_NE(contentHash(*scene), contentHash(*other));
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(*other)));
    const auto again = readScene(folder / "baked.glb");
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_TRUE(again->materials[1].tinted);
    EXPECT_TRUE(again->materials[0].attenuates());

    file.json["materials"][0]["extensions"]["KHR_materials_volume"]["attenuationDistance"] = 0;
    EXPECT_FALSE(readScene(file.write(folder)));
}

} // namespace
} // namespace halflight::glass_test
