// S35. Files whose masks have a colour: version 3, a light's three channels named by its first. All others stay
// version 2.
#include "fixtures.h"

#include "halflight/scene/optimize.h"
#include "halflight/scene/sidecar.h"

#include <gmock/gmock.h>

#include <functional>

namespace halflight::colored_masks_test {
namespace {

using namespace test;
using testing::HasSubstr;

/// The first light has a coloured mask, the second one channel 3.
BakedScene coloredBake()
{
    BakedScene baked = pretendToBake(engineScene());
    baked.maskChannels = {};
    const int channels[] = {0, 3, -1, -1};
    for (std::size_t i = 0; i < baked.scene.lights.size(); ++i)
        baked.scene.lights[i].baking.occlusionMaskChannel = i < 4 ? channels[i] : -1;
    baked.scene.lights[0].baking.coloredMask = true;
    return baked;
}

Json& bakingOf(Json& document)
{
    for (Json& node : document["nodes"])
        if (node.contains("extensions") && node["extensions"].contains("HALFLIGHT_light") &&
            node["extensions"]["HALFLIGHT_light"].contains("baking") &&
            node["extensions"]["HALFLIGHT_light"]["baking"].contains("coloredMask"))
            return node["extensions"]["HALFLIGHT_light"]["baking"];
    ADD_FAILURE() << "no light has a coloured mask";
    return document["nodes"][0];
}

TEST(ColoredFileS35, KeepsTheColor)
{
    const TemporaryFolder folder;
    const BakedScene baked = coloredBake();
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    Json json = jsonOfGlb(folder / "baked.glb");
    EXPECT_EQ(json["extensions"]["HALFLIGHT_mixed_lighting"]["version"], 3);
    EXPECT_EQ(bakingOf(json)["coloredMask"], true);
    EXPECT_EQ(bakingOf(json)["occlusionMaskChannel"], 0);
    OptimizeReport report;
    ASSERT_TRUE(optimizeFile(folder / "baked.glb", folder / "small.glb", {}, report));
    for (const char* name : {"baked.glb", "small.glb"}) {
        const Result<BakedScene> read = readBakedScene(folder / name);
        ASSERT_TRUE(read) << read.error().text();
        EXPECT_TRUE(hasColoredMasks(read->scene));
        EXPECT_TRUE(read->scene.lights[0].baking.coloredMask);
        EXPECT_FALSE(read->scene.lights[1].baking.coloredMask);
        for (std::size_t page = 0; page < baked.shadowmasks.size(); ++page)
            EXPECT_EQ(read->shadowmasks[page].texels(), baked.shadowmasks[page].texels()) << name;
    }
    std::filesystem::create_directories(folder / "beside");
    std::vector<std::string> warnings;
    ASSERT_TRUE(writeSidecar(folder / "beside", folder / "baked.glb", baked, {}, warnings));
    std::ifstream file(folder / "beside" / "bake.json");
    const Json sidecar = Json::parse(file);
    int colored = 0;
    for (const Json& light : sidecar["lights"])
        colored += light.dump().find("\"coloredMask\":true") != std::string::npos;
    EXPECT_EQ(colored, 1) << "the sidecar's lights say so, too";
}

TEST(ColoredFileS35, OthersSayNothingOfIt)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene())));
    const Json json = jsonOfGlb(folder / "baked.glb");
    EXPECT_EQ(json["extensions"]["HALFLIGHT_mixed_lighting"]["version"], 2);
    EXPECT_EQ(json.dump().find("coloredMask"), std::string::npos);
}

std::string errorAfter(const std::function<void(Json& root, Json& baking)>& change)
{
    const TemporaryFolder folder;
    EXPECT_TRUE(writeBakedScene(folder / "baked.glb", coloredBake()));
    std::vector<char> binary;
    Json json = jsonOfGlb(folder / "baked.glb", &binary);
    change(json["extensions"]["HALFLIGHT_mixed_lighting"], bakingOf(json));
    json["buffers"][0]["uri"] = "binary.bin";
    writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
    writeText(folder / "other.gltf", json.dump());
    const Result<BakedScene> read = readBakedScene(folder / "other.gltf");
    return read ? "" : read.error().text();
}

TEST(ColoredFileS35, BrokenOnesAreRefused)
{
    EXPECT_EQ(errorAfter([](Json&, Json&) {}), "");
    EXPECT_THAT(errorAfter([](Json& root, Json&) { root["version"] = 2; }),
                HasSubstr("has a coloured mask, and the version has none"));
    for (const int channel : {-1, 1, 3})
        EXPECT_THAT(errorAfter([&](Json&, Json& baking) { baking["occlusionMaskChannel"] = channel; }),
                    HasSubstr("its channel is not the first of a mask layer"));
    EXPECT_THAT(
        errorAfter([](Json& root, Json&) {
            root["shadowmaskChannels"] = Json::array();
            for (int c = 0; c < 4; ++c) root["shadowmaskChannels"].push_back({{"encoding", "attenuation"}});
            root["shadowmaskChannels"][2] = {{"encoding", "distance"}, {"rangeTexels", 4}, {"penumbraTexels", 1}};
        }),
        HasSubstr("shadowmaskChannels says that it holds distances"));
    EXPECT_THAT(errorAfter([](Json&, Json& baking) { baking["coloredMask"] = "red"; }), HasSubstr("coloredMask"));
}

} // namespace
} // namespace halflight::colored_masks_test
