// Sharing a bake among processes: who does what, and what they need not repeat.

#include "bake/test_scene.h"
#include "base/temp_folder.h"

#include "halflight/bake/farm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <thread>

namespace halflight::test::farm_test {
namespace {

FarmBake bakeOf(std::size_t tiles, uint64_t texels)
{
    FarmBake bake;
    bake.tiles = tiles;
    bake.texels = texels;
    return bake;
}

TEST(FarmWork, EveryTileHasOneWorkerAndWorkersHaveEqualShares)
{
    const std::vector<FarmBake> bakes = {bakeOf(3, 700), bakeOf(64, 1'000'000), bakeOf(1, 1),
                                         bakeOf(0, 0),   bakeOf(40, 90'000),    bakeOf(200, 3'200'000)};
    for (const uint32_t count : {1u, 2u, 7u, 16u, 64u, 1000u}) {
        std::vector<std::multiset<std::size_t>> tiles(bakes.size());
        std::vector<std::multiset<uint32_t>> shares(bakes.size());
        std::vector<uint32_t> sharesOf(bakes.size());
        for (uint32_t index = 0; index < count; ++index) {
            const std::vector<FarmWork> works = farmWork(bakes, {index, count});
            ASSERT_EQ(works.size(), bakes.size());
            double texels = 0.0;
            for (std::size_t b = 0; b < bakes.size(); ++b) {
                const FarmWork& work = works[b];
                tiles[b].insert(work.tiles.begin(), work.tiles.end());
                if (work.share.count == 0) {
                    EXPECT_TRUE(work.tiles.empty()) << "tiles need the bake's cache stage";
                    continue;
                }
                shares[b].insert(work.share.index);
                sharesOf[b] = work.share.count;
                if (bakes[b].tiles > 0) {
                    texels += double(work.tiles.size()) * double(bakes[b].texels) / double(bakes[b].tiles);
                }
            }
            // Equal but for tiles at the two ends of a stretch: the largest has 16,000 texels.
            if (count <= 16) EXPECT_NEAR(texels, 4'290'701.0 / count, 2 * 16'000.0) << index << " of " << count;
        }
        for (std::size_t b = 0; b < bakes.size(); ++b) {
            EXPECT_EQ(tiles[b].size(), bakes[b].tiles);
            EXPECT_EQ(std::set<std::size_t>(tiles[b].begin(), tiles[b].end()).size(), bakes[b].tiles);
            // Shares of the cache stage are 0 … count - 1, each once.
            EXPECT_EQ(shares[b].size(), sharesOf[b]);
            for (uint32_t i = 0; i < sharesOf[b]; ++i) EXPECT_EQ(shares[b].count(i), 1u);
        }
    }
}

TEST(FarmWork, SmallBakesAreNotSplit)
{
    const std::vector<FarmBake> bakes(100, bakeOf(64, 100'000));
    for (uint32_t index = 0; index < 10; ++index) {
        std::size_t bakesOfWorker = 0;
        for (const FarmWork& work : farmWork(bakes, {index, 10})) {
            bakesOfWorker += work.share.count > 0 ? 1 : 0;
            EXPECT_LE(work.share.count, 1u);
        }
        EXPECT_EQ(bakesOfWorker, 10u);
    }
}

/// A lamp in a room with a wall across, so that patches are split and backs are hit.
Scene room()
{
    Scene scene;
    const int walls = addMaterial(scene, vec3(0.6f));
    addBox(scene, vec3(-2, 0, -2), vec3(2, 3, 2), walls, true);
    addBox(scene, vec3(-0.05f, 0, -2), vec3(0.05f, 2, 1), walls, false);
    scene.lights.push_back(makeLight(LightType::Point, vec3(1, 2, 0), vec3(0, -1, 0), 20.0f, LightMode::Mixed));
    return scene;
}

BakeSettings smallSettings()
{
    BakeSettings settings;
    settings.samples = 16;
    settings.lightmapSize = 256;
    settings.probeSpacingMeters = 2.0f;
    return settings;
}

const BakeResult& plainBake()
{
    static const Result<BakeResult> once = bake(room(), smallSettings(), embreeIntegrators());
    return *once;
}

/// Workers one after the other, each with a thread of its own for the cache stage: parts meet in the folder alone.
TEST(FarmWork, TheJoinedBakeHasTheBakesBytes)
{
    TempFolder folder;
    BakeSettings settings = smallSettings();
    const BakeResult& plain = plainBake();
    settings.cacheDirectory = folder / "cache";
    const Result<FarmBake> planned = planFarm(room(), settings, embreeIntegrators());
    ASSERT_TRUE(planned);
    EXPECT_EQ(missingFarmTiles(settings.cacheDirectory, *planned, true).size(), planned->tiles);
    for (const FarmStage stage : {FarmStage::Cache, FarmStage::Tiles}) {
        std::vector<std::thread> threads;
        for (uint32_t index = 0; index < 3; ++index) {
            threads.emplace_back([&, index] {
                FarmWork work = farmWork({*planned}, {index, 3}).front();
                work.stage = stage;
                const auto report = workOnFarm(room(), settings, *planned, work, false, embreeIntegrators());
                EXPECT_TRUE(report);
            });
        }
        for (std::thread& thread : threads) thread.join();
        EXPECT_TRUE(isFarmCacheComplete(settings.cacheDirectory, *planned));
    }
    EXPECT_TRUE(missingFarmTiles(settings.cacheDirectory, *planned, true).empty());
    const Result<BakeResult> joined = bake(room(), settings, embreeIntegrators());
    ASSERT_TRUE(joined);
    EXPECT_EQ(joined->report.cache.same, joined->report.cache.tiles);
    EXPECT_EQ(joined->baked.lightmaps[0].texels(), plain.baked.lightmaps[0].texels());
    EXPECT_EQ(joined->baked.shadowmasks[0].texels(), plain.baked.shadowmasks[0].texels());
    ASSERT_EQ(joined->baked.probes.probes.size(), plain.baked.probes.probes.size());
    for (std::size_t i = 0; i < plain.baked.probes.probes.size(); ++i)
        EXPECT_EQ(joined->baked.probes.probes[i].radiance, plain.baked.probes.probes[i].radiance);
}

/// Bakes a room with a cache whose tiles are gone: what texels have in common is taken from the cache.
TEST(FarmWork, ABakeWithACacheBuildsTheRadianceCacheOnce)
{
    TempFolder folder;
    BakeSettings settings = smallSettings();
    const auto run = [&] {
        Result<BakeResult> result = bake(room(), settings, embreeIntegrators());
        EXPECT_TRUE(result);
        return std::move(*result);
    };
    const auto raysOf = [](const BakeResult& result, const std::string& stage) {
        for (const StageReport& s : result.report.stages)
            if (s.name == stage) return s.rays;
        ADD_FAILURE() << "no stage " << stage;
        return uint64_t(0);
    };
    const BakeResult& plain = plainBake();
    settings.cacheDirectory = folder / "cache";
    const BakeResult first = run();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "cache"))
        if (entry.path().filename().string().starts_with("lightmap-")) std::filesystem::remove(entry.path());
    const BakeResult second = run();
    EXPECT_LT(second.report.cache.same, second.report.cache.tiles) << "the lightmap was computed again";
    EXPECT_GT(raysOf(second, "lightmap"), 0u);
    EXPECT_LT(raysOf(second, "lightmap"), raysOf(first, "lightmap"));
    EXPECT_EQ(raysOf(second, "validity"), 0u);
    for (const BakeResult* cached : {&first, &second})
        EXPECT_EQ(cached->baked.lightmaps[0].texels(), plain.baked.lightmaps[0].texels());
    EXPECT_EQ(second.report.chartCount, plain.report.chartCount);
    EXPECT_EQ(second.report.meshes.size(), plain.report.meshes.size());
}

} // namespace
} // namespace halflight::test::farm_test
