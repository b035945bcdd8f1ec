// bake --only: chosen objects have a whole bake's light, all others keep that of the last bake in the cache.
#include "bake/some_objects.h"

#include "bake/cache/cache.h"
#include "bake/test_scene.h"
#include "base/temp_folder.h"

#include "halflight/bake/bake.h"
#include "halflight/base/file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace halflight::test::some_objects_test {
namespace {

constexpr int kPageSize = 128;
constexpr int kTables = 3;

struct Area {
    ivec2 min{0};
    ivec2 max{0}; ///< excluded
};
/// Texels of the rectangles in tables(); tiles of 256 texels hold texels of more than one.
Area areaOf(const std::string& name)
{
    if (name == "floor") return {{2, 2}, {42, 42}};
    const int i = name.back() - '0';
    return {{45 + 20 * i, 3}, {63 + 20 * i, 21}};
}

/// A floor and three tables over it, each with texels of its own; a lamp with a mask. The denoiser is off in these
/// tests but one, so that texels stay what the integrator made them.
Scene tables()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.6f));
    const auto place = [](const std::string& name) { return Place{vec2(areaOf(name).min), vec2(areaOf(name).max)}; };
    addRectangle(scene, {vec3(-3, 0, 3), vec3(6, 0, 0), vec3(0, 0, -6)}, grey, kPageSize, place("floor"));
    scene.objects[0].name = "floor";
    for (int i = 0; i < kTables; ++i) {
        const std::string name = "table " + std::to_string(i);
        addRectangle(scene, {vec3(float(i) * 2 - 2.5f, 0.8f, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1)}, grey, kPageSize,
                     place(name));
        scene.objects.back().name = name;
    }
    for (Mesh& mesh : scene.meshes) mesh.parts[0].uv[1] = mesh.parts[0].lightmapUv; // UvMode::Keep
    Light lamp = makeLight(LightType::Point, vec3(0.4f, 2.5f, 0.3f), vec3(0, -1, 0), 40.0f, LightMode::Mixed);
    lamp.name = "lamp";
    lamp.radiusMeters = 0.05f;
    scene.lights.push_back(lamp);
    scene.sky = Sky{vec3(20.0f), vec3(20.0f), vec3(20.0f)};
    return scene;
}

/// The lamp elsewhere and a brighter sky.
Scene changedTables()
{
    Scene scene = tables();
    scene.lights[0].worldFromLight[3] += vec4(-1.5f, 0, 0, 0);
    scene.sky = Sky{vec3(60.0f), vec3(60.0f), vec3(60.0f)};
    return scene;
}

struct SomeObjectsTest : testing::Test {
    SomeObjectsTest() { settings.cacheDirectory = folder / "cache"; }
    static void SetUpTestSuite()
    {
        shared = std::make_unique<Shared>();
        BakeSettings s = usualSettings();
        s.cacheDirectory = shared->folder / "cache";
        Result<BakeResult> last = bake(tables(), s, embreeIntegrators());
        s.cacheDirectory.clear();
        Result<BakeResult> fresh = bake(changedTables(), s, embreeIntegrators());
        ASSERT_TRUE(last && fresh);
        shared->last = std::move(*last);
        shared->fresh = std::move(*fresh);
    }
    static void TearDownTestSuite() { shared.reset(); }

    /// The bake of tables() with the usual settings. This test's cache has a copy of it.
    const BakeResult& lastBake()
    {
        std::filesystem::copy(shared->folder / "cache", settings.cacheDirectory,
                              std::filesystem::copy_options::recursive);
        return shared->last;
    }
    /// The bake of changedTables() with the usual settings.
    static const BakeResult& freshBake() { return shared->fresh; }

    Result<BakeResult> tryOnly(const Scene& scene, const std::vector<std::string>& names)
    {
        BakeSettings some = settings;
        some.only = names;
        return bake(scene, some, embreeIntegrators());
    }
    BakeResult only(const Scene& scene, const std::vector<std::string>& names)
    {
        Result<BakeResult> result = tryOnly(scene, names);
        if (!result) ADD_FAILURE() << result.error().text();
        return result ? std::move(*result) : BakeResult();
    }
    BakeResult whole(const Scene& scene) { return only(scene, {}); }
    std::string refusal(const Scene& scene, const std::vector<std::string>& names)
    {
        const Result<BakeResult> result = tryOnly(scene, names);
        return result ? "" : result.error().message;
    }
    static void expectSame(const BakedScene& a, const BakedScene& b)
    {
        ASSERT_EQ(a.lightmaps.size(), 1u);
        ASSERT_EQ(b.lightmaps.size(), 1u);
        EXPECT_EQ(a.lightmapUnitLux, b.lightmapUnitLux);
        EXPECT_EQ(a.lightmaps[0].texels(), b.lightmaps[0].texels());
        ASSERT_EQ(a.lightmapDirections.size(), b.lightmapDirections.size());
        for (std::size_t i = 0; i < a.lightmapDirections.size(); ++i)
            EXPECT_EQ(a.lightmapDirections[i].texels(), b.lightmapDirections[i].texels());
        ASSERT_EQ(a.shadowmasks.size(), b.shadowmasks.size());
        for (std::size_t i = 0; i < a.shadowmasks.size(); ++i)
            EXPECT_EQ(a.shadowmasks[i].texels(), b.shadowmasks[i].texels());
        expectSameProbes(a, b);
        ASSERT_EQ(a.reflections.probes.size(), b.reflections.probes.size());
        for (std::size_t i = 0; i < a.reflections.probes.size(); ++i)
            EXPECT_EQ(a.reflections.probes[i].position, b.reflections.probes[i].position);
    }
    static void expectSameProbes(const BakedScene& a, const BakedScene& b)
    {
        ASSERT_GT(a.probes.probes.size(), 0u);
        ASSERT_EQ(a.probes.probes.size(), b.probes.probes.size());
        for (std::size_t i = 0; i < a.probes.probes.size(); ++i) {
            EXPECT_EQ(a.probes.probes[i].radiance, b.probes.probes[i].radiance);
            EXPECT_EQ(a.probes.probes[i].occlusion, b.probes.probes[i].occlusion);
        }
    }
    /// Number of an object's texels, without its outermost, that differ.
    template<typename T> static int differences(const Image<T>& a, const Image<T>& b, const std::string& name)
    {
        const Area area = areaOf(name);
        int count = 0;
        for (int y = area.min.y + 1; y < area.max.y - 1; ++y)
            for (int x = area.min.x + 1; x < area.max.x - 1; ++x) count += a(x, y) != b(x, y) ? 1 : 0;
        return count;
    }
    static int differences(const BakeResult& a, const BakeResult& b, const std::string& name)
    {
        return differences(a.irradiance[0], b.irradiance[0], name) +
               differences(a.baked.shadowmasks[0], b.baked.shadowmasks[0], name);
    }

    TempFolder folder;
    BakeSettings settings = usualSettings();

private:
    static BakeSettings usualSettings()
    {
        BakeSettings usual;
        usual.samples = 32;
        usual.shadowSamples = 16;
        usual.bounces = 2;
        usual.uvMode = UvMode::Keep;
        usual.lightmapSize = kPageSize;
        usual.probeSpacingMeters = 2.0f;
        usual.denoiser = Denoiser::Off;
        return usual;
    }
    struct Shared {
        TempFolder folder{"some_objects_tests"};
        BakeResult last;
        BakeResult fresh;
    };
    static inline std::unique_ptr<Shared> shared;
};

TEST_F(SomeObjectsTest, AnUnchangedSceneGivesTheSameBytes)
{
    settings.directional = true;
    for (const Denoiser denoiser : {Denoiser::Off, Denoiser::BuiltIn}) {
        for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
            settings.denoiser = denoiser;
            settings.integrator = kind;
            const BakeResult last = whole(tables());
            const BakeResult again = only(tables(), {"table 1"});
            expectSame(last.baked, again.baked);
            const TileCounts& tiles = again.report.cache;
            EXPECT_EQ(tiles.same, 0u) << "the tiles of the same bake are not taken";
            EXPECT_GT(tiles.kept, tiles.tiles / 2);
            EXPECT_GE(tiles.tiles - tiles.kept, 4u) << "two tiles of texels at least, of lightmap and mask";
        }
    }
}

TEST_F(SomeObjectsTest, ChosenObjectsGetTheNewLightAndOthersKeepTheirs)
{
    const BakeResult& last = lastBake();
    const BakeResult mixed = only(changedTables(), {"table 1", "floor"});
    const BakeResult& fresh = freshBake();
    for (const char* chosen : {"floor", "table 1"}) {
        EXPECT_EQ(differences(mixed, fresh, chosen), 0) << chosen;
        EXPECT_GT(differences(mixed, last, chosen), 200) << "the light did change";
    }
    for (const char* kept : {"table 0", "table 2"}) {
        EXPECT_EQ(differences(mixed, last, kept), 0) << kept;
        EXPECT_GT(differences(mixed, fresh, kept), 200) << "it would have changed";
    }
}

TEST_F(SomeObjectsTest, ProbesAtTheSamePlacesKeepTheirLight)
{
    const BakeResult& last = lastBake();
    Scene brighter = tables();
    brighter.sky = changedTables().sky;
    const BakeResult mixed = only(brighter, {"table 1"});
    expectSameProbes(mixed.baked, last.baked);
    settings.cacheDirectory = folder / "another";
    const BakeResult fresh = whole(brighter);
    EXPECT_NE(fresh.baked.probes.probes[0].radiance, last.baked.probes.probes[0].radiance);
}

TEST_F(SomeObjectsTest, AnotherBakeOfSomeGoesOnFromThere)
{
    lastBake();
    const BakeResult first = only(changedTables(), {"table 1"});
    const BakeResult second = only(changedTables(), {"table 2"});
    EXPECT_EQ(differences(first, second, "table 1"), 0);
    EXPECT_GT(differences(first, second, "table 2"), 200);
    const BakeResult& fresh = freshBake();
    EXPECT_EQ(differences(second, fresh, "table 1"), 0);
    EXPECT_EQ(differences(second, fresh, "table 2"), 0);
}

TEST_F(SomeObjectsTest, TheNextWholeBakeFindsWhatIsOutOfDate)
{
    lastBake();
    only(changedTables(), {"floor"});
    const BakeResult after = whole(changedTables());
    const BakeResult& fresh = freshBake();
    expectSame(after.baked, fresh.baked);
    settings.cacheDirectory = folder / "third";
    lastBake();
    only(changedTables(), {"floor", "table 0", "table 1", "table 2"});
    const BakeReport report = whole(changedTables()).report;
    const std::size_t tiles = Tiling{report.coveredTexels, kTexelTile}.tileCount();
    EXPECT_GE(report.cache.unchanged, 2 * tiles) << "lightmap and mask are right already";
}

TEST_F(SomeObjectsTest, MovedObjectsKeepTheirLightUnlessChosen)
{
    const BakeResult& last = lastBake();
    Scene moved = tables();
    moved.objects[1].worldFromObject = glm::rotate(mat4(1.0f), -1.2f, vec3(0, 0, 1)); // table 0, tilted over the floor
    const BakeResult mixed = only(moved, {"table 2"});
    EXPECT_EQ(differences(mixed, last, "table 0"), 0);
    EXPECT_EQ(differences(mixed, last, "floor"), 0);
    const BakeResult chosen = only(moved, {"table 0"});
    EXPECT_GT(differences(chosen, last, "table 0"), 200);
    EXPECT_EQ(differences(chosen, last, "floor"), 0);
    settings.cacheDirectory = folder / "another";
    EXPECT_EQ(differences(chosen, whole(moved), "table 0"), 0);
}

TEST_F(SomeObjectsTest, SubtractiveBakesKeepTheirOwnMask)
{
    settings.mode = MixedLightingMode::Subtractive;
    Scene scene = tables();
    scene.lights[0] = makeLight(LightType::Directional, vec3(0.0f), vec3(-0.3f, -1, 0.2f), 800.0f, LightMode::Mixed);
    scene.lights[0].name = "sun";
    const BakeResult last = whole(scene);
    ASSERT_TRUE(last.report.mainLight.has_value());
    expectSame(last.baked, only(scene, {"floor"}).baked);
}

TEST_F(SomeObjectsTest, ATileThatCannotBeReadIsComputedWithAWarning)
{
    const BakeResult& last = lastBake();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "cache")) {
        if (entry.path().filename().string().rfind("lightmap-00000", 0) == 0)
            std::filesystem::resize_file(entry.path(), 100);
    }
    const BakeResult again = only(tables(), {"table 1"});
    expectSame(last.baked, again.baked);
    ASSERT_FALSE(again.report.warnings.empty());
    EXPECT_NE(again.report.warnings.back().find("cannot be read"), std::string::npos) << again.report.warnings.back();
}

TEST_F(SomeObjectsTest, NamesAreWholeOrBetweenCommas)
{
    Scene scene = tables();
    scene.objects[1].name = "table, round";
    const auto chosen = [&](const std::vector<std::string>& names) {
        const Result<std::vector<uint8_t>> found = chosenObjects(scene, names);
        return found ? *found : std::vector<uint8_t>();
    };
    using Flags = std::vector<uint8_t>;
    EXPECT_EQ(chosen({"table 1,floor"}), (Flags{1, 0, 1, 0}));
    EXPECT_EQ(chosen({"table 1", "table 2"}), (Flags{0, 0, 1, 1}));
    EXPECT_EQ(chosen({"table, round"}), (Flags{0, 1, 0, 0}));
    scene.objects[3].name = "table 1"; // two of one name
    EXPECT_EQ(chosen({"table 1"}), (Flags{0, 0, 1, 1}));
    EXPECT_EQ(chosenObjects(scene, {"floor,chair"}).error().message,
              "no object or node with objects is called 'chair'");
}

TEST_F(SomeObjectsTest, RenamedObjectsKeepTheirLight)
{
    const BakeResult& all = lastBake();
    Scene renamed = tables();
    renamed.objects[1].name = "bench";
    const BakeResult some = only(renamed, {"floor"});
    expectSame(some.baked, all.baked);
    Scene replaced = renamed; // what is baked anew needs no counterpart
    for (vec3& position : replaced.meshes[1].parts[0].positions) position.y += 0.1f;
    EXPECT_EQ(refusal(replaced, {"bench"}), "");
}

TEST_F(SomeObjectsTest, MasksAndProbesOfANewLightAreBaked)
{
    const BakeResult& before = lastBake();
    Scene more = tables();
    Light second = more.lights[0];
    second.name = "second";
    second.worldFromLight[3] = vec4(-2.0f, 1.6f, 0.0f, 1.0f);
    more.lights.push_back(second);
    const BakeResult some = only(more, {"table 0"});
    const auto says = [](const std::string& warning) {
        return warning.find("no mask of the light 'second'") != std::string::npos;
    };
    EXPECT_EQ(std::count_if(some.report.warnings.begin(), some.report.warnings.end(), says), 1);
    EXPECT_EQ(differences(some.irradiance[0], before.irradiance[0], "floor"), 0) << "the lightmap is kept";
    settings.cacheDirectory = folder / "other";
    const BakeResult all = whole(more);
    EXPECT_EQ(some.baked.shadowmasks[0].texels(), all.baked.shadowmasks[0].texels());
    expectSameProbes(some.baked, all.baked);
    EXPECT_GT(differences(all.irradiance[0], before.irradiance[0], "floor"), 0);
    EXPECT_NE(all.baked.shadowmasks[0].texels(), before.baked.shadowmasks[0].texels());
}

TEST_F(SomeObjectsTest, WhatCannotBeKeptIsRefused)
{
    const std::string noBake = "holds no finished bake with this layout and these settings";
    EXPECT_NE(refusal(tables(), {"floor"}).find(noBake), std::string::npos) << "the cache is empty";
    EXPECT_FALSE(std::filesystem::exists(settings.cacheDirectory)) << "a refusal leaves nothing behind";
    lastBake();
    EXPECT_EQ(refusal(tables(), {"chair"}), "no object or node with objects is called 'chair'");
    Scene dynamic = tables();
    dynamic.objects.push_back(dynamic.objects[1]);
    dynamic.objects.back().isStatic = false;
    dynamic.objects.back().name = "ball";
    EXPECT_EQ(refusal(dynamic, {"ball"}), "none of the objects to bake has lightmap texels");
    Scene swapped = tables();
    std::swap(swapped.objects[1].name, swapped.objects[2].name);
    EXPECT_NE(refusal(swapped, {"floor"}).find("no object 'table 0' at the same texels"), std::string::npos);
    Scene another = tables();
    another.objects[1].name = "bench";
    for (vec3& position : another.meshes[1].parts[0].positions) position.y += 0.1f;
    EXPECT_NE(refusal(another, {"floor"}).find("no object 'bench' at the same texels"), std::string::npos);
    Scene larger = tables();
    for (vec2& uv : larger.meshes[2].parts[0].uv[1]) uv.y *= 1.2f;
    EXPECT_NE(refusal(larger, {"floor"}).find(noBake), std::string::npos) << "another layout";
    settings.samples = 48;
    EXPECT_NE(refusal(tables(), {"floor"}).find(noBake), std::string::npos) << "other settings";
    settings.samples = 32;
    settings.mode = MixedLightingMode::BakedIndirect;
    EXPECT_NE(refusal(tables(), {"floor"}).find(noBake), std::string::npos) << "another mode";
    settings.mode = MixedLightingMode::Shadowmask;
    EXPECT_EQ(refusal(tables(), {"floor"}), "") << "refusals changed nothing";
    settings.cacheDirectory.clear();
    EXPECT_EQ(refusal(tables(), {"floor"}), "a bake of some objects needs a cache, with the last bake");
}

} // namespace
} // namespace halflight::test::some_objects_test
