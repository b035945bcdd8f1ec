// bake --cache: taken-over tiles give what a bake from scratch gives, an interrupted bake goes on, and a change bakes
// anew only what it reaches.

#include "bake/cache/cache.h"
#include "bake/geometry/indices.h"
#include "bake/same_bakes.h"
#include "bake/test_scene.h"
#include "base/temp_folder.h"

#include "halflight/base/file.h"
#include "halflight/base/rgb9e5.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>

namespace halflight::test::cache_test {
namespace {

/// Two closed rooms, ten metres apart, each with a lamp under the ceiling and a box on the floor.
Scene twoRooms()
{
    Scene scene;
    const int walls = addMaterial(scene, vec3(0.6f));
    const int boxes = addMaterial(scene, vec3(0.3f, 0.4f, 0.5f));
    for (const float x : {0.0f, 10.0f}) {
        addBox(scene, vec3(x - 2, 0, -2), vec3(x + 2, 3, 2), walls, true);
        addBox(scene, vec3(x - 0.5f, 0, -0.5f), vec3(x + 0.5f, 1, 0.5f), boxes, false);
        Light lamp = makeLight(LightType::Point, vec3(x + 1, 2.5f, 0.5f), vec3(0, -1, 0), 20.0f, LightMode::Mixed);
        lamp.name = x == 0.0f ? "left" : "right";
        lamp.radiusMeters = 0.1f;
        lamp.rangeMeters = 5.0f;
        scene.lights.push_back(lamp);
    }
    return scene;
}

struct CacheTest : testing::Test {
    static void SetUpTestSuite()
    {
        shared = std::make_unique<Shared>();
        BakeSettings s = usualSettings();
        Result<BakeResult> plain = bake(twoRooms(), s, embreeIntegrators());
        s.cacheDirectory = shared->folder / "cache";
        Result<BakeResult> first = bake(twoRooms(), s, embreeIntegrators());
        ASSERT_TRUE(plain && first);
        shared->plain = std::move(*plain);
        shared->first = std::move(*first);
    }
    static void TearDownTestSuite() { shared.reset(); }

    BakeResult run(const Scene& scene, bool cached, const Progress& progress = {})
    {
        BakeSettings s = settings;
        if (cached) s.cacheDirectory = folder / "cache";
        Result<BakeResult> result = bake(scene, s, embreeIntegrators(), progress);
        if (!result) {
            EXPECT_EQ(result.error().code, ErrorCode::Cancelled) << result.error().text();
            return {};
        }
        return std::move(*result);
    }
    static uint64_t raysOf(const BakeReport& report, const std::string& stage)
    {
        for (const StageReport& s : report.stages)
            if (s.name == stage) return s.rays;
        ADD_FAILURE() << "no stage " << stage;
        return 0;
    }
    /// Mean relative difference of two lightmaps.
    static double difference(const BakedScene& a, const BakedScene& b)
    {
        double sum = 0.0;
        double error = 0.0;
        for (std::size_t p = 0; p < a.lightmaps.size(); ++p) {
            const ImageRgb32f x = decodeRgb9e5(a.lightmaps[p], a.lightmapUnitLux);
            const ImageRgb32f y = decodeRgb9e5(b.lightmaps[p], b.lightmapUnitLux);
            for (std::size_t i = 0; i < x.texelCount(); ++i) {
                sum += double(luminance(x.data()[i]));
                error += std::abs(double(luminance(x.data()[i])) - double(luminance(y.data()[i])));
            }
        }
        return error / sum;
    }

    /// A bake of twoRooms() into an empty cache, which this test has a copy of.
    const BakeResult& firstBake()
    {
        std::filesystem::copy(shared->folder / "cache", folder / "cache", std::filesystem::copy_options::recursive);
        return shared->first;
    }
    static const BakeResult& plainBake() { return shared->plain; }

    TempFolder folder;
    BakeSettings settings = usualSettings();

private:
    static BakeSettings usualSettings()
    {
        BakeSettings usual;
        usual.samples = 16;
        usual.shadowSamples = 8;
        usual.bounces = 2;
        usual.lightmapSize = 128;
        usual.probeSpacingMeters = 2.0f;
        return usual;
    }
    /// Bakes of twoRooms() without a cache and with one that is empty.
    struct Shared {
        TempFolder folder{"cache_tests"};
        BakeResult plain;
        BakeResult first;
    };
    static inline std::unique_ptr<Shared> shared;
};

TEST_F(CacheTest, ASecondBakeTakesEverythingAndGivesTheSameBytes)
{
    const Scene scene = twoRooms();
    const BakeResult& plain = plainBake();
    const BakeResult& first = firstBake();
    expectSameBakes(plain.baked, first.baked);
    EXPECT_GT(first.report.cache.tiles, 10u);
    EXPECT_EQ(first.report.cache.same, 0u);
    const BakeResult second = run(scene, true);
    expectSameBakes(plain.baked, second.baked);
    EXPECT_EQ(second.report.cache.same, second.report.cache.tiles);
    for (const char* stage : {"lightmap", "shadowmask"}) EXPECT_EQ(raysOf(second.report, stage), 0u) << stage;
    // Where probes go along the edges of shadows is traced in each bake; what they hold comes from the cache.
    EXPECT_LT(raysOf(second.report, "probes"), raysOf(first.report, "probes"));
}

/// Runs at night, apart from the others.
struct InterruptedBake : CacheTest {};

TEST_F(InterruptedBake, GoesOn)
{
    settings.lightmapSize = 512; // several batches
    settings.samples = 4;
    const Scene scene = twoRooms();
    std::atomic<bool> cancel = false;
    Progress progress;
    progress.cancel = &cancel;
    progress.report = [&](std::string_view stage, double fraction) {
        if (stage == "lightmap" && fraction > 0.6) cancel = true;
    };
    EXPECT_EQ(run(scene, true, progress).report.cache.tiles, 0u);
    const BakeResult resumed = run(scene, true);
    EXPECT_GT(resumed.report.cache.same, 0u);
    EXPECT_LT(resumed.report.cache.same, resumed.report.cache.tiles);
    expectSameBakes(run(scene, false).baked, resumed.baked);
}

// What `bake --cache` compares before it says "up to date".
TEST_F(CacheTest, TheHashFollowsEverySettingThatTheFileFollows)
{
    const Scene scene = twoRooms();
    const Hash128 before = bakeHash(scene, settings);
    std::vector<Hash128> seen = {before};
    const auto changes = [&](const char* what, const auto& change) {
        BakeSettings changed = settings;
        change(changed);
        const Hash128 hash = bakeHash(scene, changed);
        EXPECT_EQ(std::count(seen.begin(), seen.end(), hash), 0) << what;
        seen.push_back(hash);
    };
    changes("mode", [](BakeSettings& s) { s.mode = MixedLightingMode::Subtractive; });
    changes("quality", [](BakeSettings& s) { s.quality = Quality::Ultra; }); // probe samples
    changes("samples", [](BakeSettings& s) { s.samples = 32; });
    changes("shadow samples", [](BakeSettings& s) { s.shadowSamples = 16; });
    changes("bounces", [](BakeSettings& s) { s.bounces = 3; });
    changes("integrator", [](BakeSettings& s) { s.integrator = IntegratorKind::Path; });
    changes("noise target", [](BakeSettings& s) { s.noiseTarget = 0.02f; });
    changes("UV mode", [](BakeSettings& s) { s.uvMode = UvMode::Unwrap; });
    changes("density", [](BakeSettings& s) { s.texelsPerMeter = 20.0f; });
    changes("size", [](BakeSettings& s) { s.lightmapSize = 256; });
    changes("padding", [](BakeSettings& s) { s.paddingTexels = 4; });
    changes("denoiser", [](BakeSettings& s) { s.denoiser = Denoiser::Off; });
    changes("directional", [](BakeSettings& s) { s.directional = false; });
    changes("mask encoding", [](BakeSettings& s) { s.maskEncoding = MaskEncoding::Distance; });
    changes("subtractive mask", [](BakeSettings& s) { s.subtractiveMask = false; });
    changes("probe spacing", [](BakeSettings& s) { s.probeSpacingMeters = 1.0f; });
    changes("probe layout", [](BakeSettings& s) { s.probeLayout = ProbeLayout::Grid; });
    changes("seed", [](BakeSettings& s) { s.seed = 2; });

    BakeSettings same = settings;
    same.threads = 1;
    same.imagesDirectory = folder / "images";
    same.cacheDirectory = folder / "cache";
    EXPECT_EQ(bakeHash(scene, same), before);
}

TEST_F(CacheTest, BrokenPartsAreBakedAgain)
{
    const Scene scene = twoRooms();
    const BakeResult& first = firstBake();
    std::size_t parts = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "cache")) {
        if (entry.path().extension() != ".part" || ++parts % 2 == 0) continue;
        // One bit flipped in the middle, or the end cut off.
        auto bytes = readFile(entry.path());
        ASSERT_TRUE(bytes);
        if (parts % 4 == 1) (*bytes)[bytes->size() / 2] ^= std::byte(4);
        if (parts % 4 == 3) bytes->resize(bytes->size() - 7);
        ASSERT_TRUE(writeFileAtomically(entry.path(), bytes->data(), bytes->size()));
    }
    ASSERT_GT(parts, 4u);
    const BakeResult second = run(scene, true);
    expectSameBakes(first.baked, second.baked);
    EXPECT_GT(second.report.cache.same, 0u);
    EXPECT_LT(second.report.cache.same, second.report.cache.tiles);
    EXPECT_EQ(run(scene, true).report.cache.same, second.report.cache.tiles) << "what was added can be read";
}

TEST_F(CacheTest, SeveralBakesShareOneFolder)
{
    const Scene scene = twoRooms();
    Scene other = twoRooms();
    other.lights[1].intensity = 5.0f;
    const BakeResult& plain = plainBake();
    std::array<BakeResult, 3> results;
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < results.size(); ++i)
        threads.emplace_back([&, i] { results[i] = run(i == 1 ? other : scene, true); });
    for (std::thread& thread : threads) thread.join();
    expectSameBakes(plain.baked, results[0].baked);
    expectSameBakes(plain.baked, results[2].baked);
    const BakeResult again = run(scene, true);
    EXPECT_EQ(again.report.cache.same, again.report.cache.tiles);
    expectSameBakes(plain.baked, again.baked);
}

/// A killed process leaves a file under a temporary name. It is removed once no running process can own it.
TEST_F(CacheTest, AbandonedFilesAreRemoved)
{
    PartFolder parts(folder / "parts");
    const std::array<std::byte, 3> bytes = {std::byte(1), std::byte(2), std::byte(3)};
    ASSERT_TRUE(parts.write("a", bytes));
    ASSERT_TRUE(writeFileAtomically(folder / "parts" / "b.part.tmp-1", "half"));
    parts.removeAbandoned(std::chrono::hours(1));
    EXPECT_TRUE(std::filesystem::exists(folder / "parts" / "b.part.tmp-1"));
    std::filesystem::last_write_time(folder / "parts" / "b.part.tmp-1",
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(2));
    parts.removeAbandoned(std::chrono::hours(1));
    EXPECT_FALSE(std::filesystem::exists(folder / "parts" / "b.part.tmp-1"));
    EXPECT_TRUE(parts.read("a"));
    // Renamed to another part's name, the bytes are not that part.
    std::filesystem::rename(parts.fileOf("a"), parts.fileOf("c"));
    EXPECT_FALSE(parts.read("c"));
}

/// Each process takes its own share first. A process alone takes all, one that comes later finds them.
TEST_F(CacheTest, ProcessesFillOneFolderInShares)
{
    constexpr std::size_t kParts = 10;
    using Parts = std::vector<std::vector<std::byte>>;
    std::vector<std::size_t> order;
    const auto process = [&](WorkShare share, std::size_t killedAfter) -> std::optional<Parts> {
        PartFolder parts(folder / "shared");
        parts.shareWith(share);
        order.clear();
        Result<Parts> all = parts.complete("stage", kParts, [&](std::size_t part) -> Result<std::vector<std::byte>> {
            if (order.size() == killedAfter) return cancelledError();
            order.push_back(part);
            return std::vector<std::byte>{std::byte(part)};
        });
        return all ? std::optional(std::move(*all)) : std::nullopt;
    };
    EXPECT_FALSE(process({1, 3}, 3));
    EXPECT_EQ(order, (std::vector<std::size_t>{1, 4, 7}));
    const auto all = process({0, 3}, kParts);
    ASSERT_TRUE(all);
    EXPECT_EQ((std::vector<std::size_t>(order.begin(), order.begin() + 4)), (std::vector<std::size_t>{0, 3, 6, 9}));
    EXPECT_EQ(order.size(), 7u);
    for (std::size_t i = 0; i < kParts; ++i) EXPECT_EQ((*all)[i], std::vector<std::byte>{std::byte(i)});
    EXPECT_EQ(process({2, 3}, kParts), all);
    EXPECT_TRUE(order.empty());
}

TEST_F(CacheTest, ALightReachesOnlyItsOwnRoom)
{
    Scene scene = twoRooms();
    firstBake();
    scene.lights[0].intensity = 40.0f;
    const BakeResult changed = run(scene, true);
    const TileCounts& counts = changed.report.cache;
    EXPECT_EQ(counts.same, 0u);
    // Tiles of the other room alone, and all masks: intensity does not change shadows. Probes between those of the grid
    // stand where the light needs them, so they are all new.
    EXPECT_GT(counts.unchanged, counts.tiles * 2 / 5);
    EXPECT_LT(counts.unchanged, counts.tiles * 9 / 10);
    // From scratch the other room gets fewer samples, as its noise is less beside the brighter map's light.
    EXPECT_LT(difference(run(scene, false).baked, changed.baked), 0.004);
}

/// Check samples cost rays: a bake computes those of each tile once, and the next bake is compared with them.
TEST_F(CacheTest, CheckSamplesAreComputedOnce)
{
    constexpr std::size_t kTiles = 6;
    constexpr std::size_t kTile = 4;
    constexpr std::size_t kCount = kTiles * kTile - 1; // the last tile is smaller
    const auto bakeWith = [&](uint32_t bake, float checkOfTile2, std::vector<uint32_t>& checked) {
        Result<BakeCache> cache = BakeCache::open(folder / "tiles", Hasher().add(bake).hash(), Hasher().add(1u).hash());
        EXPECT_TRUE(cache);
        BakeCache::Work<IrradianceEstimate, float> work;
        work.stage = "lightmap";
        work.tilesPerPart = 2;
        work.count = kCount;
        work.tileSize = kTile;
        work.surface = [](std::size_t first, std::size_t) { return Hasher().add(uint32_t(first)).hash(); };
        work.compute = [&](std::span<const uint32_t> items, std::span<IrradianceEstimate> out, const Progress&) {
            for (std::size_t i = 0; i < items.size(); ++i) out[i].irradiance = vec3(float(bake), float(items[i]), 0.0f);
            return Status();
        };
        work.check = [&](std::span<const uint32_t> items, std::span<float> out, const Progress&) {
            for (std::size_t i = 0; i < items.size(); ++i) {
                checked.push_back(items[i]);
                out[i] = float(items[i]) + (items[i] / kTile == 2 ? checkOfTile2 : 0.0f);
            }
            return Status();
        };
        work.changed = [](std::span<const float> before, std::span<const float> now) {
            return !std::equal(before.begin(), before.end(), now.begin(), now.end());
        };
        std::vector<IrradianceEstimate> out(kCount);
        EXPECT_TRUE(cache->run(work, std::span<IrradianceEstimate>(out), Progress{}));
        cache->finish();
        return out;
    };
    // From nothing; then tile 2 changes; then nothing does.
    const std::array<float, 3> check = {0.0f, 0.5f, 0.5f};
    const std::array<float, 3> bakeOfTile2 = {1.0f, 2.0f, 2.0f};
    for (uint32_t i = 0; i < 3; ++i) {
        SCOPED_TRACE(i);
        std::vector<uint32_t> checked;
        const std::vector<IrradianceEstimate> out = bakeWith(i + 1, check[i], checked);
        std::sort(checked.begin(), checked.end());
        EXPECT_EQ(checked, allIndices(kCount));
        for (std::size_t item = 0; item < kCount; ++item) {
            const float expected = item / kTile == 2 ? bakeOfTile2[i] : 1.0f;
            EXPECT_EQ(out[item].irradiance, vec3(expected, float(item), 0.0f)) << item;
        }
    }
}

TEST_F(CacheTest, AMovedObjectReachesOnlyItsOwnRoom)
{
    Scene scene = twoRooms();
    firstBake();
    for (int i = 6; i < 12; ++i)
        scene.objects[std::size_t(i)].worldFromObject = glm::translate(mat4(1.0f), vec3(0.4f, 0, 0.3f));
    const BakeResult moved = run(scene, true);
    // Half of the tiles are of the other room alone, but for those that hold texels of both: the packer decides them.
    EXPECT_GT(moved.report.cache.unchanged, moved.report.cache.tiles / 5);
    EXPECT_LT(moved.report.cache.unchanged, moved.report.cache.tiles * 7 / 10);
    EXPECT_LT(difference(run(scene, false).baked, moved.baked), 0.002);
}

} // namespace
} // namespace halflight::test::cache_test
