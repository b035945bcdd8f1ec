// S35. Coloured masks with bake --cache, --only and farm: bytes of a bake without, and glass that changes its colour.

#include "bake/cache/cache.h"
#include "bake/lights/group_states.h"
#include "bake/same_bakes.h"
#include "bake/test_scene.h"
#include "base/temp_folder.h"

#include "halflight/bake/farm.h"
#include "halflight/shading/color.h"

#include <algorithm>
#include <string>
#include <thread>

namespace halflight::test::colored_mask_cache_test {
namespace {

const vec3 kRed(0.8f, 0.4f, 0.2f); ///< of a pane: what passes

/// As bright as red, and greener.
vec3 green()
{
    const vec3 color(0.4f, 0.5f, 0.2f);
    return color * (luminance(kRed) / luminance(color));
}

/// Two white floors, far apart, each under a pane of its colour and a board, and a mixed sun straight above.
Scene floors(vec3 left, vec3 right)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.5f));
    for (const float x : {0.0f, 30.0f}) {
        const std::string side = x == 0.0f ? "left" : "right";
        const int glass = addMaterial(scene, x == 0.0f ? left : right);
        Material& pane = scene.materials.back();
        pane.name = "pane " + side;
        pane.alphaMode = Material::AlphaMode::Blend;
        pane.baseColor.w = 0.0f;
        pane.tinted = true;
        addRectangle(scene, {vec3(x - 4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, 64);
        scene.objects.back().name = side;
        addRectangle(scene, {vec3(x - 9, 1, 9), vec3(9, 0, 0), vec3(0, 0, -18)}, glass, 64);
        scene.objects.back().name = "glass " + side;
        addRectangle(scene, {vec3(x + 2, 1, 9), vec3(9, 0, 0), vec3(0, 0, -18)}, white, 64);
        scene.objects.back().name = "board " + side;
        for (std::size_t i = scene.objects.size() - 2; i < scene.objects.size(); ++i)
            scene.objects[i].lightmapScale = 0.0f;
    }
    Light sun = makeLight(LightType::Directional, vec3(0), vec3(1.0e-3f, -1, 0), 100.0f, LightMode::Mixed);
    sun.name = "sun";
    scene.lights.push_back(sun);
    return scene;
}

BakeSettings settingsOf(const std::filesystem::path& cache = {})
{
    BakeSettings settings;
    settings.samples = 16;
    settings.bounces = 1;
    settings.lightmapSize = 128;
    settings.probeSpacingMeters = 4.0f;
    settings.probeLayout = ProbeLayout::Grid;
    settings.reflectionProbes = false;
    settings.cacheDirectory = cache;
    return settings;
}

const BakeResult& redBake()
{
    static const BakeResult once = bakeOf(floors(kRed, kRed), settingsOf());
    return once;
}

/// Texels of the mask that say what a pane of this colour lets through.
int texelsOf(const BakeResult& result, vec3 color)
{
    const ivec3 passed(glm::round(color * 255.0f));
    int count = 0;
    for (const u8vec4& texel : result.baked.shadowmasks[0].texels()) {
        const ivec3 off = glm::abs(ivec3(texel) - passed);
        count += std::max({off.x, off.y, off.z}) <= 1 ? 1 : 0;
    }
    return count;
}

TEST(ColoredMaskCacheS35, ACacheChangesNoByte)
{
    ASSERT_TRUE(redBake().baked.scene.lights[0].baking.coloredMask);
    ASSERT_GT(texelsOf(redBake(), kRed), 1000);
    TempFolder folder;
    expectSameBakes(redBake().baked, bakeOf(floors(kRed, kRed), settingsOf(folder / "cache")).baked);
    const BakeResult second = bakeOf(floors(kRed, kRed), settingsOf(folder / "cache"));
    expectSameBakes(redBake().baked, second.baked);
    EXPECT_GT(second.report.cache.tiles, 10u);
    EXPECT_EQ(second.report.cache.same, second.report.cache.tiles);
}

/// Check samples see a colour that is as bright as the one before.
TEST(ColoredMaskCacheS35, AnotherColorOfGlassIsTracedAgain)
{
    TempFolder folder;
    bakeOf(floors(kRed, kRed), settingsOf(folder / "cache"));
    const BakeResult changed = bakeOf(floors(kRed, green()), settingsOf(folder / "cache"));
    EXPECT_LT(changed.report.cache.same + changed.report.cache.unchanged, changed.report.cache.tiles);
    EXPECT_GT(changed.report.cache.unchanged, changed.report.cache.tiles / 8) << "the other floor's tiles are kept";
    const BakeResult fresh = bakeOf(floors(kRed, green()), settingsOf());
    EXPECT_EQ(changed.baked.shadowmasks[0].texels(), fresh.baked.shadowmasks[0].texels());
    EXPECT_GT(texelsOf(changed, green()), 500);
    EXPECT_GT(texelsOf(changed, kRed), 500);
}

/// The light loses the colour of its mask, and with it two channels.
TEST(ColoredMaskCacheS35, GlassThatTurnsGreyLeavesNoColor)
{
    TempFolder folder;
    bakeOf(floors(kRed, kRed), settingsOf(folder / "cache"));
    const vec3 grey(0.5f);
    const BakeResult changed = bakeOf(floors(grey, grey), settingsOf(folder / "cache"));
    EXPECT_FALSE(changed.baked.scene.lights[0].baking.coloredMask);
    const BakeResult fresh = bakeOf(floors(grey, grey), settingsOf());
    EXPECT_EQ(changed.baked.shadowmasks[0].texels(), fresh.baked.shadowmasks[0].texels());
}

TEST(ColoredMaskCacheS35, SomeObjectsHaveTheNewColor)
{
    TempFolder folder;
    BakeSettings settings = settingsOf(folder / "cache");
    settings.denoiser = Denoiser::Off; // so that texels are what the integrator made them
    const BakeResult last = bakeOf(floors(kRed, kRed), settings);
    settings.only = {"left"};
    const BakeResult kept = bakeOf(floors(kRed, green()), settings);
    EXPECT_EQ(kept.baked.shadowmasks[0].texels(), last.baked.shadowmasks[0].texels())
        << "the right floor is not chosen";
    settings.only = {"right"};
    const BakeResult chosen = bakeOf(floors(kRed, green()), settings);
    settings.only.clear();
    settings.cacheDirectory.clear();
    const BakeResult fresh = bakeOf(floors(kRed, green()), settings);
    EXPECT_EQ(chosen.baked.shadowmasks[0].texels(), fresh.baked.shadowmasks[0].texels());
    EXPECT_GT(texelsOf(chosen, green()), 500);
}

TEST(ColoredMaskCacheS35, AFarmsBakeHasTheSameBytes)
{
    TempFolder folder;
    const BakeSettings settings = settingsOf(folder / "cache");
    const Scene scene = floors(kRed, kRed);
    const Result<FarmBake> planned = planFarm(scene, settings, embreeIntegrators());
    ASSERT_TRUE(planned) << planned.error().text();
    for (const FarmStage stage : {FarmStage::Cache, FarmStage::Tiles}) {
        std::vector<std::thread> threads;
        for (uint32_t index = 0; index < 3; ++index) {
            threads.emplace_back([&, index] {
                FarmWork work = farmWork({*planned}, {index, 3}).front();
                work.stage = stage;
                EXPECT_TRUE(workOnFarm(scene, settings, *planned, work, false, embreeIntegrators()));
            });
        }
        for (std::thread& thread : threads) thread.join();
    }
    EXPECT_TRUE(missingFarmTiles(settings.cacheDirectory, *planned, true).empty());
    const BakeResult joined = bakeOf(scene, settings);
    EXPECT_EQ(joined.report.cache.same, joined.report.cache.tiles);
    expectSameBakes(redBake().baked, joined.baked);
}

} // namespace
} // namespace halflight::test::colored_mask_cache_test
