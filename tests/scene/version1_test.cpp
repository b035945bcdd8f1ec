// Files of version 1 of the format are read as before.

#include "fixtures.h"

#include <gmock/gmock.h>

namespace halflight {
namespace {

using namespace test;

TEST(Version1, ReadsAsItsCopyInVersion2)
{
    // A bake of assets/tests/penumbra.glb by the last program that wrote version 1.
    const auto file = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/format_v1.glb";
    const Json root = jsonOfGlb(file)["extensions"]["HALFLIGHT_mixed_lighting"];
    ASSERT_EQ(root["version"], 1);
    ASSERT_TRUE(root["lightmaps"][0].contains("bufferView"));

    const Result<BakedScene> old = readBakedScene(file);
    ASSERT_TRUE(old) << old.error().text();
    EXPECT_TRUE(old->isBaked);
    ASSERT_EQ(old->lightmaps.size(), 1u);
    ASSERT_EQ(old->shadowmasks.size(), 1u);
    EXPECT_GT(old->probes.probes.size(), 7u);
    EXPECT_THAT(old->scene.warnings, testing::ElementsAre(testing::HasSubstr("is of version 1 of the format")));

    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "v2.glb", *old));
    const Json written = jsonOfGlb(folder / "v2.glb")["extensions"]["HALFLIGHT_mixed_lighting"];
    EXPECT_EQ(written["version"], 2);
    EXPECT_TRUE(written["lightmaps"][0].contains("index"));
    const Result<BakedScene> now = readBakedScene(folder / "v2.glb");
    ASSERT_TRUE(now) << now.error().text();
    EXPECT_THAT(now->scene.warnings, testing::IsEmpty());
    EXPECT_EQ(now->lightmaps[0].texels(), old->lightmaps[0].texels());
    EXPECT_EQ(now->shadowmasks[0].texels(), old->shadowmasks[0].texels());
    ASSERT_EQ(now->probes.probes.size(), old->probes.probes.size());
    for (std::size_t i = 0; i < old->probes.probes.size(); ++i)
        EXPECT_EQ(now->probes.probes[i].radiance, old->probes.probes[i].radiance);
    ASSERT_EQ(now->scene.objects.size(), old->scene.objects.size());
    for (std::size_t i = 0; i < old->scene.objects.size(); ++i)
        expectSameTexels(old->scene, old->scene.objects[i], now->scene, now->scene.objects[i]);
}

TEST(Version1, NewerVersionsAreRefused)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene(), false)));
    std::vector<char> binary;
    Json json = jsonOfGlb(folder / "baked.glb", &binary);
    json["extensions"]["HALFLIGHT_mixed_lighting"]["version"] = 3;
    json["buffers"][0]["uri"] = "binary.bin";
    writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
    writeText(folder / "newer.gltf", json.dump());
    const Result<BakedScene> read = readBakedScene(folder / "newer.gltf");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::Unsupported);
}

} // namespace
} // namespace halflight
