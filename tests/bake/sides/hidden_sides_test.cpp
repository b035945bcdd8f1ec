// Which crossings of surfaces hide their two sides from one another (spec S6).

#include "bake/seams/seams.h"
#include "bake/test_scene.h"

#include "bake/sides/hidden_sides.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace halflight::test::hidden_sides_test {
namespace {

constexpr int kPage = 64;
constexpr float kTexel = 0.1f; // metres

/// A floor of 4 m × 4 m about the origin.
Scene floorScene()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(1), vec2(63)});
    return scene;
}

/// Adds a sheet over x = 0 from z = -1 to z = 1.
void addSheet(Scene& scene, float low, float high)
{
    addRectangle(scene, {vec3(0, low, -1), vec3(0, 0, 2), vec3(0, high - low, 0)}, 0, kPage);
}

/// Whether the sides are hidden at the point (0, 0, z) of the floor.
bool hiddenAt(const Scene& scene, float z)
{
    const CrossingPoint point{0, 0, vec3(0, 0, z), vec3(0, 1, 0), vec3(1, 0, 0), vec3(0, 1, 0), kTexel};
    const IntegratorFactory factory = embreeIntegrators();
    SourceTree tree(factory, {});
    return hiddenSidesTest(tree)(scene, std::span(&point, 1)).at(0) != 0;
}

TEST(HiddenSidesS6, SheetsHideAsFarAsTheyGo)
{
    Scene scene = floorScene();
    EXPECT_FALSE(hiddenAt(scene, 0.0f)) << "nothing stands there";
    addSheet(scene, -0.5f, 1.0f);
    EXPECT_TRUE(hiddenAt(scene, 0.0f));
    EXPECT_TRUE(hiddenAt(scene, 0.9f));
    EXPECT_FALSE(hiddenAt(scene, 1.2f)) << "beyond its end";
}

TEST(HiddenSidesS6, SheetsThatEndJustAboveTheFloorHide)
{
    Scene scene = floorScene();
    addSheet(scene, 0.01f, 1.0f);
    EXPECT_TRUE(hiddenAt(scene, 0.0f));
}

TEST(HiddenSidesS6, LowSheetsDoNot)
{
    Scene scene = floorScene();
    addSheet(scene, -0.5f, 0.25f);
    EXPECT_FALSE(hiddenAt(scene, 0.0f));
}

/// Below a thick board the floor lies inside it, which takes no cut; through a thin one a texel reaches to the other
/// side.
TEST(HiddenSidesS6, BoardsHideWhereTexelsReachBeyondThem)
{
    for (const float thickness : {0.05f, 0.5f}) {
        Scene scene = floorScene();
        const std::size_t first = scene.meshes.size();
        addBox(scene, vec3(-thickness, -0.5f, -1), vec3(0, 1, 1), 0, false);
        joinObjects(scene, first);
        EXPECT_EQ(hiddenAt(scene, 0.0f), thickness < kTexel) << thickness;
    }
}

/// The floor ends at the sheet: there is nothing to cut.
TEST(HiddenSidesS6, BothSidesAreOfTheSurface)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(1), vec2(63)});
    addSheet(scene, -0.5f, 1.0f);
    EXPECT_FALSE(hiddenAt(scene, 0.0f));
}

/// A floor in two charts: the seam goes where a sheet stands on it, and stays beyond the sheet's end.
TEST(HiddenSidesS6, SeamsEndAtSheets)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(2), vec2(22, 42)});
    addRectangle(scene, {vec3(0, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(30, 2), vec2(50, 42)});
    for (const bool withSheet : {false, true}) {
        if (withSheet) addSheet(scene, -0.5f, 1.0f);
        Bench bench(scene, MixedLightingMode::Shadowmask, kPage, {});
        const std::vector<SeamSample> before = findSeams(bench.geometry, kPage);
        std::vector<SeamSample> after = before;
        ASSERT_TRUE(dropHiddenSeams(*bench.integrator, after));
        ASSERT_GT(before.size(), 60u);
        if (!withSheet) {
            EXPECT_EQ(after.size(), before.size());
            continue;
        }
        EXPECT_NEAR(double(after.size()), 0.5 * double(before.size()), 4.0);
        for (const SeamSample& seam : after) EXPECT_GT(std::abs(seam.sight.from.z), 0.99f);
    }
}

} // namespace
} // namespace halflight::test::hidden_sides_test
