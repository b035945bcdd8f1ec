// KHR_materials_transmission as the share of light that a surface stops.

#include "fixtures.h"

namespace halflight::glass_test {
namespace {

using namespace test;

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

} // namespace
} // namespace halflight::glass_test
