// The density where nobody asks for one: by the scene's size, and pages cut to what is used.

#include "atlas_check.h"
#include "shapes.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

namespace halflight::density_test {
namespace {

/// As a bake of medium quality asks for it.
UnwrapSettings byTheScene(const Scene& scene, int pageSize = 2048)
{
    UnwrapSettings settings;
    settings.pageSize = pageSize;
    settings.mostTexelsPerMeter = sceneDensity(scene, pageSize);
    settings.cutPage = true;
    return settings;
}

/// A floor and four boxes on it, `size` wide.
Scene room(float size)
{
    Scene scene = shapes::scene(shapes::plane(size, size));
    scene.meshes.push_back(shapes::box(vec3(0.1f * size)));
    for (int i = 0; i < 4; ++i)
        shapes::add(scene, 1, glm::translate(mat4(1.0f), vec3(0.2f * float(i) - 0.3f, 0.05f, 0.0f) * size));
    return scene;
}

TEST(SceneDensity, IsFortyTexelsPerMeterForRoomsAndAShareOfTheDiagonalBelow)
{
    EXPECT_EQ(sceneDensity(room(10.0f), 2048), 40.0f);
    EXPECT_EQ(sceneDensity(room(1000.0f), 2048), 40.0f);
    EXPECT_EQ(sceneDensity(room(10.0f), 1024), 20.0f);
    for (const float size : {1.0f, 0.02f, 0.001f}) {
        const float diagonal = glm::length(vec3(1.0f, 0.1f, 1.0f)) * size;
        EXPECT_NEAR(sceneDensity(room(size), 2048) * diagonal, 256.0f, 0.1f) << size;
    }
    // Neither what moves nor what gets no texels counts; nothing at all has no density.
    Scene scene = room(0.5f);
    const float density = sceneDensity(scene, 2048);
    for (int i = 0; i < 2; ++i) shapes::add(scene, 1, glm::translate(mat4(1.0f), vec3(100.0f)));
    scene.objects[5].isStatic = false;
    scene.objects[6].lightmapScale = 0.0f;
    EXPECT_EQ(sceneDensity(scene, 2048), density);
    EXPECT_EQ(sceneDensity(Scene(), 2048), 0.0f);
}

TEST(SceneDensity, ScenesOfAllSizesGetPagesThatAreFilled)
{
    for (const float size : {0.004f, 0.3f, 4.0f, 15.0f, 80.0f, 3000.0f}) {
        const Scene scene = room(size);
        const UnwrapSettings settings = byTheScene(scene);
        const Result<UnwrappedScene> result = unwrap(scene, settings);
        ASSERT_TRUE(result) << result.error().text();
        EXPECT_EQ(checkAtlas(*result, settings.paddingTexels).fault, "") << size;
        EXPECT_EQ(result->pageCount, 1) << size;
        EXPECT_EQ(result->pageSize % 4, 0) << size;
        EXPECT_GT(result->coverageWithPadding, 0.7f) << size;
        // 51 texels of 25 mm a metre: a floor of 40 m no longer fits.
        const bool fits = size < 40.0f;
        EXPECT_EQ(result->densityFrom, fits ? DensityFrom::Scene : DensityFrom::Page) << size;
        if (fits) {
            EXPECT_EQ(result->texelsPerMeter, settings.mostTexelsPerMeter) << size;
            EXPECT_LT(result->pageSize, 2048) << size;
        } else {
            EXPECT_LT(result->texelsPerMeter, settings.mostTexelsPerMeter) << size;
        }
        // In all of them a box is some texels wide.
        EXPECT_GT(result->texelsPerMeter * 0.1f * size, 15.0f) << size;
    }
}

/// The largest share of one page that any of the asked densities around `found` fills: by trying them all.
double mostFilled(const Scene& scene, UnwrapSettings settings, float found)
{
    double most = 0.0;
    for (int step = -4; step <= 8; ++step) {
        settings.texelsPerMeter = found * (1.0f + 0.004f * float(step));
        const Result<UnwrappedScene> result = unwrap(scene, settings);
        if (result && result->pageCount == 1) most = std::max(most, double(result->coverage));
    }
    return most;
}

TEST(UnwrapDensity, FillsAPageAsWellAsAnyDensityAroundIt)
{
    struct Case {
        int boxes, pageSize;
    };
    // A search that goes on, one that begins with the usual share, and ones that measure it on a small page.
    for (const auto& [boxes, pageSize] : {Case{40, 512}, Case{400, 500}, Case{400, 512}, Case{250, 1024}}) {
        Scene scene;
        for (int i = 0; i < boxes; ++i) {
            const float size = 0.3f + 1.7f * std::fmod(0.618034f * float(i), 1.0f);
            scene.meshes.push_back(shapes::box(size * vec3(1.0f, 0.4f + 0.2f * float(i % 7), 0.5f)));
            shapes::add(scene, i, mat4(1.0f));
        }
        UnwrapSettings settings;
        settings.pageSize = pageSize;
        const Result<UnwrappedScene> result = unwrap(scene, settings);
        ASSERT_TRUE(result) << result.error().text();
        EXPECT_EQ(result->pageCount, 1);
        EXPECT_GE(double(result->coverage), mostFilled(scene, settings, result->texelsPerMeter) - 0.01)
            << boxes << " boxes, " << pageSize;
    }
}

TEST(UnwrapDensity, SeveralPagesAreTheSameOnAnyNumberOfThreads)
{
    Scene scene;
    for (int i = 0; i < 120; ++i) {
        scene.meshes.push_back(shapes::box(vec3(0.5f + 0.1f * float(i % 9), 1.0f, 0.3f + 0.2f * float(i % 5))));
        shapes::add(scene, i, mat4(1.0f));
    }
    UnwrapSettings settings;
    settings.pageSize = 128;
    settings.texelsPerMeter = 16.0f;
    const auto layout = [&](int threads) {
        const ThreadLimit limit(threads);
        const Result<UnwrappedScene> result = unwrap(scene, settings);
        EXPECT_TRUE(result);
        std::vector<std::pair<int, vec2>> corners;
        for (const Object& object : result->scene.objects)
            corners.emplace_back(object.lightmap.page,
                                 result->scene.meshes[std::size_t(object.mesh)].parts[0].lightmapUv[0]);
        EXPECT_EQ(checkAtlas(*result, settings.paddingTexels).fault, "");
        EXPECT_GE(result->pageCount, 8);
        // Pages are full but for the last.
        EXPECT_GT(double(result->coverageWithPadding) * result->pageCount, 0.85 * double(result->pageCount - 1));
        return corners;
    };
    const auto one = layout(1);
    EXPECT_EQ(one, layout(2));
    EXPECT_EQ(one, layout(5));
}

TEST(SceneDensity, AskedDensityIsKeptAndItsPageIsCutToo)
{
    Scene scene = room(2.0f);
    UnwrapSettings settings = byTheScene(scene);
    settings.texelsPerMeter = 150.0f; // more than the scene's own
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(result->texelsPerMeter, 150.0f);
    EXPECT_EQ(result->densityFrom, DensityFrom::Asked);
    EXPECT_LT(result->pageSize, 512);
    EXPECT_GT(result->coverageWithPadding, 0.7f);
    // Several pages stay whole, and so does a page whose size is asked for.
    settings.pageSize = 256;
    settings.texelsPerMeter = 400.0f;
    settings.cutPage = true;
    const Result<UnwrappedScene> several = unwrap(scene, settings);
    ASSERT_TRUE(several) << several.error().text();
    EXPECT_EQ(several->pageSize, 256);
    settings.texelsPerMeter = 30.0f;
    settings.cutPage = false;
    const Result<UnwrappedScene> whole = unwrap(scene, settings);
    ASSERT_TRUE(whole) << whole.error().text();
    EXPECT_EQ(whole->pageSize, 256);
}

TEST(SceneDensity, AtlasOfTheFileIsDrawnOnASmallerPageThatKeepsItsChartsApart)
{
    // Two squares with a gap of a 64th of the uv square: two texels of 128 or more.
    Scene scene;
    for (const float from : {0.0f, 0.5f + 1.0f / 128.0f}) {
        Mesh mesh = shapes::plane(1.0f, 1.0f, 2);
        for (const vec3 p : mesh.parts[0].positions)
            mesh.parts[0].uv[1].push_back(vec2(from, 0.0f) + (0.5f - 1.0f / 128.0f) * vec2(p.x + 0.5f, p.z + 0.5f));
        scene.meshes.push_back(mesh);
        shapes::add(scene, int(scene.meshes.size()) - 1, mat4(1.0f));
    }
    UnwrapSettings settings = byTheScene(scene);
    settings.mostTexelsPerMeter = 20.0f; // a page of 40 texels, with a gap of less than one
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_TRUE(result) << result.error().text();
    for (const MeshUnwrapReport& report : result->meshes) EXPECT_TRUE(report.kept) << report.reason;
    EXPECT_EQ(checkAtlas(*result, settings.paddingTexels).fault, "");
    EXPECT_GT(result->pageSize, 100);
    EXPECT_LT(result->pageSize, 400);
    // A larger limit is met without room to spare.
    settings.mostTexelsPerMeter = 400.0f;
    const Result<UnwrappedScene> finer = unwrap(scene, settings);
    ASSERT_TRUE(finer) << finer.error().text();
    EXPECT_NEAR(finer->texelsPerMeter, 400.0f, 4.0f);
}

} // namespace
} // namespace halflight::density_test
