// S36. Files with several mask layers: version 3, a picture for each page and layer in use, channels up to 15. All
// other files stay version 2.
#include "fixtures.h"

#include "halflight/scene/optimize.h"
#include "halflight/scene/sidecar.h"

#include <gmock/gmock.h>

#include <functional>

namespace halflight::mask_layers_test {
namespace {

using namespace test;
using testing::HasSubstr;

/// Two pages in three layers, one picture left out; lights in channels 0, 4, 7 and 10.
BakedScene layeredBake()
{
    BakedScene baked = pretendToBake(engineScene());
    baked.maskLayers = 3;
    const std::vector<ImageRgba8> first = std::move(baked.shadowmasks);
    baked.shadowmasks.clear();
    for (std::size_t page = 0; page < first.size(); ++page) {
        baked.shadowmasks.push_back(first[page]);
        for (uint8_t layer = 1; layer < 3; ++layer)
            baked.shadowmasks.emplace_back(33, 17, u8vec4(layer, 100 + page, 0, 255));
    }
    baked.shadowmasks[4] = {}; // page 1, layer 1
    baked.maskChannels[9] = {4.0f, 1.25f};
    const int channels[] = {0, 4, 7, 10};
    for (std::size_t i = 0; i < 4; ++i) baked.scene.lights[i].baking.occlusionMaskChannel = channels[i];
    for (std::size_t i = 0; i < baked.probes.probes.size(); ++i) {
        MaskValues& occlusion = baked.probes.probes[i].occlusion;
        occlusion.layers[1] = vec4(0.25f, 0.5f, 1.0f, 0.01f * float(i));
        occlusion.layers[2] = vec4(1.0f, 0.02f * float(i), 0.75f, 0.0f);
    }
    return baked;
}

void expectSameMasks(const BakedScene& a, const BakedScene& b)
{
    EXPECT_EQ(a.maskLayers, b.maskLayers);
    ASSERT_EQ(a.shadowmasks.size(), b.shadowmasks.size());
    for (std::size_t i = 0; i < a.shadowmasks.size(); ++i)
        EXPECT_EQ(a.shadowmasks[i].texels(), b.shadowmasks[i].texels()) << i;
    for (std::size_t c = 0; c < a.maskChannels.size(); ++c)
        EXPECT_EQ(a.maskChannels[c].rangeTexels, b.maskChannels[c].rangeTexels) << c;
    for (std::size_t i = 0; i < a.scene.lights.size(); ++i)
        EXPECT_EQ(a.scene.lights[i].baking.occlusionMaskChannel, b.scene.lights[i].baking.occlusionMaskChannel);
}

TEST(LayeredFileS36, KeepsEveryLayer)
{
    const TemporaryFolder folder;
    const BakedScene baked = layeredBake();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    const Json root = jsonOfGlb(folder / "baked.glb")["extensions"]["HALFLIGHT_mixed_lighting"];
    EXPECT_EQ(root["version"], 3);
    EXPECT_EQ(root["shadowmaskLayers"], 3);
    EXPECT_EQ(root["shadowmasks"].size(), 6u);
    EXPECT_EQ(root["shadowmasks"][4], Json::object());
    EXPECT_EQ(root["shadowmaskChannels"].size(), 12u);
    const Result<BakedScene> read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    expectSameMasks(baked, *read);
    for (std::size_t i = 0; i < baked.probes.probes.size(); ++i)
        EXPECT_EQ(baked.probes.probes[i].occlusion, read->probes.probes[i].occlusion) << i;
    EXPECT_TRUE(read->lost.empty());

    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(folder / "baked.glb", folder / "small.glb", {}, report));
    const Result<BakedScene> small = readBakedScene(folder / "small.glb");
    ASSERT_TRUE(small) << small.error().text();
    expectSameMasks(baked, *small);
    for (std::size_t i = 0; i < baked.probes.probes.size(); ++i)
        for (int c = 0; c < 12; ++c)
            EXPECT_NEAR(baked.probes.probes[i].occlusion[c], small->probes.probes[i].occlusion[c], 2.0e-3f);
}

TEST(LayeredFileS36, OneLayerStaysVersionTwo)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene())));
    const Json root = jsonOfGlb(folder / "baked.glb")["extensions"]["HALFLIGHT_mixed_lighting"];
    EXPECT_EQ(root["version"], 2);
    EXPECT_FALSE(root.contains("shadowmaskLayers"));
    EXPECT_FALSE(root["probes"].contains("occlusion1"));
}

TEST(LayeredFileS36, TheSidecarHasAPictureForEachLayerInUse)
{
    const TemporaryFolder folder;
    const BakedScene baked = layeredBake();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    std::filesystem::create_directories(folder / "beside");
    std::vector<std::string> warnings;
    const Status written = writeSidecar(folder / "beside", folder / "baked.glb", baked, {}, warnings);
    ASSERT_TRUE(written) << written.error().text();
    std::ifstream file(folder / "beside" / "bake.json");
    const Json json = Json::parse(file);
    EXPECT_EQ(json["shadowmaskLayers"], 3);
    ASSERT_EQ(json["shadowmasks"].size(), 6u);
    EXPECT_TRUE(json["shadowmasks"][4].is_null());
    for (const std::size_t i : {0, 1, 2, 3, 5}) {
        const auto mask = readPng(folder / "beside" / json["shadowmasks"][i].get<std::string>());
        ASSERT_TRUE(mask) << mask.error().text();
        EXPECT_EQ(mask->texels(), baked.shadowmasks[i].texels());
    }
    EXPECT_EQ(json["probes"]["occlusion"][0].size(), 12u);
}

/// The error of reading the file after a change to the root extension and the document.
std::string errorAfter(const std::function<void(Json& root, Json& document)>& change)
{
    const TemporaryFolder folder;
    EXPECT_TRUE(writeBakedScene(folder / "baked.glb", layeredBake()));
    std::vector<char> binary;
    Json json = jsonOfGlb(folder / "baked.glb", &binary);
    change(json["extensions"]["HALFLIGHT_mixed_lighting"], json);
    json["buffers"][0]["uri"] = "binary.bin";
    writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
    writeText(folder / "other.gltf", json.dump());
    const Result<BakedScene> read = readBakedScene(folder / "other.gltf");
    return read ? "" : read.error().text();
}

TEST(LayeredFileS36, BrokenLayersAreRefused)
{
    EXPECT_EQ(errorAfter([](Json&, Json&) {}), "");
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["version"] = 2; }),
                HasSubstr("shadowmaskLayers is not 1 to 4"));
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["shadowmaskLayers"] = 5; }), HasSubstr("shadowmaskLayers"));
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["shadowmaskLayers"] = 0; }), HasSubstr("shadowmaskLayers"));
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["shadowmaskLayers"] = 2; }),
                HasSubstr("has a mask channel of a layer that the file lacks"));
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["shadowmasks"].erase(5); }),
                HasSubstr("5 shadowmasks for 2 lightmaps in 3 layers"));
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["shadowmaskChannels"].erase(5); }),
                HasSubstr("is not an array of 12"));
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["probes"]["occlusion2"] = 0; }), HasSubstr("occlusion2"));
    EXPECT_THAT(errorAfter([](Json&, Json& document) {
                    for (Json& node : document["nodes"])
                        if (node.contains("extensions") && node["extensions"].contains("HALFLIGHT_light"))
                            node["extensions"]["HALFLIGHT_light"]["baking"]["occlusionMaskChannel"] = 16;
                }),
                HasSubstr("occlusionMaskChannel"));
}

} // namespace
} // namespace halflight::mask_layers_test
