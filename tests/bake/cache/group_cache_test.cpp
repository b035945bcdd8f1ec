// S33. Light groups with bake --cache, --only and farm: bytes of a bake without, and each group's own changes.

#include "bake/cache/cache.h"
#include "bake/lights/group_states.h"
#include "bake/same_bakes.h"
#include "bake/test_scene.h"
#include "base/temp_folder.h"

#include "halflight/bake/farm.h"
#include "halflight/render/compose.h"

#include <gmock/gmock.h>

#include <cmath>
#include <thread>

namespace halflight::test::group_cache_test {
namespace {

/// Two closed rooms, ten metres apart. Each has a bright lamp, the rest, and a dim one, a group that bounces alone.
Scene rooms()
{
    Scene scene;
    const int walls = addMaterial(scene, vec3(0.6f));
    for (const float x : {0.0f, 10.0f}) {
        const std::string side = x == 0.0f ? "left" : "right";
        addBox(scene, vec3(x - 2, 0, -2), vec3(x + 2, 3, 2), walls, true);
        for (std::size_t face = scene.objects.size() - 6; face < scene.objects.size(); ++face)
            scene.objects[face].name = side;
        const auto lampAt = [&](vec3 place, float candela) -> Light& {
            Light lamp = makeLight(LightType::Point, place, vec3(0, -1, 0), candela, LightMode::Baked);
            lamp.rangeMeters = 5.0f;
            return scene.lights.emplace_back(lamp);
        };
        lampAt(vec3(x + 1, 2.5f, 0.5f), 100.0f).name = side;
        Light& candle = lampAt(vec3(x - 1, 1.0f, -1), 1.0f);
        candle.name = candle.group = "candle " + side;
        candle.color = vec3(1.0f, 0.5f, 0.2f);
    }
    return scene;
}

Scene movedRooms()
{
    Scene scene = rooms();
    scene.lights[3].worldFromLight[3].y += 1.0f;
    return scene;
}

BakeSettings settingsOf(const std::filesystem::path& cache = {})
{
    BakeSettings settings;
    settings.samples = 16;
    settings.shadowSamples = 8;
    settings.bounces = 2;
    settings.lightmapSize = 128;
    settings.probeSpacingMeters = 2.0f;
    settings.directional = true;
    settings.cacheDirectory = cache;
    return settings;
}

const BakeResult& plainBake()
{
    static const BakeResult once = bakeOf(rooms(), settingsOf());
    return once;
}

const BakeResult& movedBake()
{
    static const BakeResult once = bakeOf(movedRooms(), settingsOf());
    return once;
}

double sumOf(const ImageRgb32f& page)
{
    double sum = 0.0;
    for (const vec3 texel : page.texels()) sum += double(luminance(texel));
    return sum;
}

/// Sum of differences over the sum of `truth`.
double difference(const ImageRgb32f& page, const ImageRgb32f& truth)
{
    double off = 0.0;
    for (std::size_t i = 0; i < truth.texelCount(); ++i)
        off += std::abs(double(luminance(page.data()[i])) - double(luminance(truth.data()[i])));
    return off / sumOf(truth);
}

TEST(GroupCacheS33, ACacheChangesNoByte)
{
    TempFolder folder;
    const BakeResult first = bakeOf(rooms(), settingsOf(folder / "cache"));
    expectSameBakes(plainBake().baked, first.baked);
    const BakeResult second = bakeOf(rooms(), settingsOf(folder / "cache"));
    expectSameBakes(plainBake().baked, second.baked);
    EXPECT_GT(second.report.cache.tiles, 10u);
    EXPECT_EQ(second.report.cache.same, second.report.cache.tiles);
}

/// The light that patches reflect is kept by component too.
TEST(GroupCacheS33, TilesThatAreGoneAreComputedFromKeptPatches)
{
    TempFolder folder;
    bakeOf(rooms(), settingsOf(folder / "cache"));
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "cache"))
        if (entry.path().filename().string().starts_with("lightmap-")) std::filesystem::remove(entry.path());
    const BakeResult second = bakeOf(rooms(), settingsOf(folder / "cache"));
    EXPECT_LT(second.report.cache.same, second.report.cache.tiles);
    expectSameBakes(plainBake().baked, second.baked);
}

TEST(GroupCacheS33, ADimGroupThatMovesIsFoundUnderBrightLight)
{
    TempFolder folder;
    bakeOf(rooms(), settingsOf(folder / "cache"));
    const BakeResult moved = bakeOf(movedRooms(), settingsOf(folder / "cache"));
    EXPECT_GT(moved.report.cache.unchanged, moved.report.cache.tiles / 8) << "the other room's tiles are kept";
    ASSERT_EQ(moved.groupIrradiance.size(), 2u);
    for (std::size_t g = 0; g < 2; ++g)
        EXPECT_LT(difference(moved.groupIrradiance[g][0], movedBake().groupIrradiance[g][0]), 0.005) << g;
    EXPECT_GT(difference(plainBake().groupIrradiance[1][0], movedBake().groupIrradiance[1][0]), 0.1) << "it did move";
    EXPECT_LT(sumOf(movedBake().groupIrradiance[1][0]), 0.02 * sumOf(movedBake().irradiance[0])) << "and is dim";
}

TEST(GroupCacheS33, AnotherColourOfAGroupTracesNothing)
{
    TempFolder folder;
    bakeOf(rooms(), settingsOf(folder / "cache"));
    Scene green = rooms();
    green.lights[1].color = vec3(0, 1, 0);
    const BakeResult again = bakeOf(green, settingsOf(folder / "cache"));
    EXPECT_EQ(again.report.cache.same, again.report.cache.tiles);
    EXPECT_EQ(again.baked.groups[0].weight, vec3(0, 1, 0));
    EXPECT_EQ(again.baked.groups[0].lightmaps[0].texels(), plainBake().baked.groups[0].lightmaps[0].texels());
}

TEST(GroupCacheS33, SomeObjectsHaveTheNewLightOfEachGroup)
{
    TempFolder folder;
    BakeSettings settings = settingsOf(folder / "cache");
    settings.denoiser = Denoiser::Off; // so that texels are what the integrator made them
    const BakeResult last = bakeOf(rooms(), settings);
    settings.only = {"left"};
    expectSameBakes(last.baked, bakeOf(rooms(), settings).baked);
    const BakeResult kept = bakeOf(movedRooms(), settings);
    EXPECT_EQ(kept.baked.groups[1].lightmaps[0].texels(), last.baked.groups[1].lightmaps[0].texels());
    settings.only = {"right"};
    const BakeResult chosen = bakeOf(movedRooms(), settings);
    settings.only.clear();
    settings.cacheDirectory.clear();
    const BakeResult fresh = bakeOf(movedRooms(), settings);
    EXPECT_EQ(chosen.baked.groups[1].lightmaps[0].texels(), fresh.baked.groups[1].lightmaps[0].texels());
}

/// Tiles that are kept unchecked would hold one group's light as another's.
TEST(GroupCacheS33, SomeObjectsNeedTheSameMembers)
{
    TempFolder folder;
    BakeSettings settings = settingsOf(folder / "cache");
    bakeOf(rooms(), settings);
    Scene other = rooms();
    other.lights[0].group = "candle left";
    settings.only = {"left"};
    const Result<BakeResult> refused = bake(other, settings, embreeIntegrators());
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().text(), testing::HasSubstr("bake the whole scene once with this cache"));
}

TEST(GroupCacheS33, AFarmsBakeHasTheSameBytes)
{
    TempFolder folder;
    const BakeSettings settings = settingsOf(folder / "cache");
    const Result<FarmBake> planned = planFarm(rooms(), settings, embreeIntegrators());
    ASSERT_TRUE(planned) << planned.error().text();
    for (const FarmStage stage : {FarmStage::Cache, FarmStage::Tiles}) {
        std::vector<std::thread> threads;
        for (uint32_t index = 0; index < 3; ++index) {
            threads.emplace_back([&, index] {
                FarmWork work = farmWork({*planned}, {index, 3}).front();
                work.stage = stage;
                EXPECT_TRUE(workOnFarm(rooms(), settings, *planned, work, false, embreeIntegrators()));
            });
        }
        for (std::thread& thread : threads) thread.join();
    }
    EXPECT_TRUE(missingFarmTiles(settings.cacheDirectory, *planned, true).empty());
    const BakeResult joined = bakeOf(rooms(), settings);
    EXPECT_EQ(joined.report.cache.same, joined.report.cache.tiles);
    expectSameBakes(plainBake().baked, joined.baked);
}

} // namespace
} // namespace halflight::test::group_cache_test
