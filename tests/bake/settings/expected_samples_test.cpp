// By what a device is chosen: how many samples a lightmap will take, and whether a GPU can gather its light.

#include "bake/test_scene.h"

#include "halflight/bake/bake.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::expected_samples_test {
namespace {

/// A floor of 6 square metres.
Scene floorScene()
{
    Scene scene;
    addRectangle(scene, {vec3(0), vec3(3, 0, 0), vec3(0, 0, -2)}, addMaterial(scene, vec3(0.5f)), 0);
    scene.objects[0].isStatic = true;
    scene.objects[0].lightmapScale = 1.0f;
    return scene;
}

BakeSettings sampled(int samples)
{
    BakeSettings settings;
    settings.samples = samples;
    return settings;
}

TEST(ExpectedSamples, AreThoseOfTheAreaAtItsDensity)
{
    BakeSettings settings = sampled(10);
    settings.texelsPerMeter = 20.0f;
    Scene scene = floorScene();
    EXPECT_NEAR(expectedSamples(scene, settings), 6.0 * 400.0 * 10.0, 1.0);
    scene.objects[0].lightmapScale = 0.5f;
    EXPECT_NEAR(expectedSamples(scene, settings), 6.0 * 100.0 * 10.0, 1.0);
    scene.objects[0].worldFromObject = mat4(mat3(2.0f)); // four times the area
    EXPECT_NEAR(expectedSamples(scene, settings), 24.0 * 100.0 * 10.0, 1.0);
    scene.objects[0].isStatic = false;
    EXPECT_EQ(expectedSamples(scene, settings), 0.0);
}

TEST(ExpectedSamples, AreLimitedByAPage)
{
    BakeSettings settings = sampled(10);
    settings.lightmapSize = 100;
    EXPECT_NEAR(expectedSamples(floorScene(), settings), 0.8 * 100.0 * 100.0 * 10.0, 1.0);
    // A scene of 3.6 m has 256 texels along its diagonal on a page of 2048, medium's.
    const double perMeter = 256.0 / std::sqrt(13.0);
    EXPECT_NEAR(expectedSamples(floorScene(), sampled(10)), 6.0 * perMeter * perMeter * 10.0, 10.0);
}

} // namespace
} // namespace halflight::test::expected_samples_test
