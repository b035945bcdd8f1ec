// Texels per metre, and what fits the pages.

#include "shapes.h"
#include "unwrap_and_check.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace halflight::unwrap_pages_test {
namespace {

using namespace unwrap_test;

TEST(UnwrapDensity, IsTexelsPerMeterOfTheWorldForEveryScaleAndMirror)
{
    Scene scene = shapes::scene(shapes::box(), glm::scale(mat4(1.0f), vec3(2.0f)));
    shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(-1.0f, 1.0f, 1.0f)));
    shapes::add(scene, 0, glm::scale(glm::rotate(mat4(1.0f), 1.0f, vec3(1, 2, 3)), vec3(1.0f, 3.0f, 0.5f)));
    scene.objects[1].lightmapScale = 0.5f;
    UnwrapSettings settings;
    settings.texelsPerMeter = 40.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.texelsPerMeter, 40.0f);
    EXPECT_NEAR(texelAreaOf(result, 0), 6.0 * 4.0 * 1600.0, 6.0 * 4.0 * 1.6);
    EXPECT_NEAR(texelAreaOf(result, 1), 6.0 * 400.0, 6.0 * 0.4);
    EXPECT_NEAR(texelAreaOf(result, 2), 2.0 * (3.0 + 1.5 + 0.5) * 1600.0, 2.0 * 5.0 * 1.6);
}

TEST(UnwrapDensity, FitsOnePageAndFillsIt)
{
    for (const int size : {64, 256, 1024}) {
        UnwrapSettings settings;
        settings.pageSize = size;
        Scene scene = shapes::scene(shapes::box());
        for (int i = 1; i < 40; ++i) {
            scene.meshes.push_back(shapes::box(vec3(1.0f, 1.0f + 0.1f * float(i), 0.5f)));
            shapes::add(scene, i, mat4(1.0f));
        }
        const UnwrappedScene result = unwrapAndCheck(scene, settings);
        EXPECT_EQ(result.pageCount, 1);
        EXPECT_EQ(result.pageSize, size);
        EXPECT_GT(result.coverageWithPadding, 0.85f);
    }
}

TEST(UnwrapDensity, UsesAsManyPagesAsItTakesAndKeepsAnObjectOnOne)
{
    Scene scene = shapes::scene(shapes::box());
    for (int i = 1; i < 20; ++i) {
        scene.meshes.push_back(shapes::cylinder(0.5f, 1.0f, 12 + i));
        shapes::add(scene, i, mat4(1.0f));
    }
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 40.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.texelsPerMeter, 40.0f);
    EXPECT_GE(result.pageCount, 3); // 20 objects of 4.5 to 6 square metres, 1600 texels each, on pages of 65536
    EXPECT_LE(result.pageCount, 4);
    EXPECT_TRUE(result.warnings.empty());
    for (const Object& object : result.scene.objects) EXPECT_GE(object.lightmap.page, 0);
}

TEST(UnwrapDensity, WhatDoesNotFitAPageGetsFewerTexelsAndAWarning)
{
    Scene scene = shapes::scene(shapes::plane(100.0f, 1.0f, 4));
    scene.meshes.push_back(shapes::box());
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 20.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_EQ(result.warnings.size(), 1u);
    EXPECT_NEAR(texelAreaOf(result, 1), 6.0 * 400.0, 1.0);
}

TEST(UnwrapDensity, TooManyPagesAreAnErrorThatSaysWhatFits)
{
    // 1000 planes of 4 square metres: at 100 texels per metre 40000 texels each, some 610 pages of 65536 with padding
    // uncounted.
    Scene scene = shapes::scene(shapes::plane(2.0f, 2.0f));
    for (int i = 1; i < 1000; ++i) shapes::add(scene, 0, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 100.0f;
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::InvalidArgument);
    const std::string& message = result.error().message;
    EXPECT_NE(message.find("256 are the most"), std::string::npos) << message;
    const std::size_t at = message.rfind(": ");
    ASSERT_NE(at, std::string::npos) << message;
    // What it says does fit.
    settings.texelsPerMeter = std::stof(message.substr(at + 2));
    EXPECT_GT(settings.texelsPerMeter, 50.0f) << message;
    EXPECT_LT(settings.texelsPerMeter, 65.0f) << message;
    const Result<UnwrappedScene> less = unwrap(scene, settings);
    ASSERT_TRUE(less) << less.error().text();
    EXPECT_LE(less->pageCount, kMaxPages);
    EXPECT_EQ(less->texelsPerMeter, settings.texelsPerMeter);
}

TEST(UnwrapDensity, ObjectsThatNeedManyPagesEachAreShrunkAtOnce)
{
    // A page each, where some fifty were asked.
    Scene scene = shapes::scene(shapes::sphere(1.0f, 20, 40));
    shapes::add(scene, 0, mat4(1.0f));
    scene.meshes.push_back(shapes::box());
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 500.0f;
    const UnwrappedScene result = unwrapAndCheck(scene, settings);
    EXPECT_LE(result.pageCount, 3);
    EXPECT_EQ(result.warnings.size(), 2u); // one for each mesh
    EXPECT_GT(result.coverage, 0.3f);
}

} // namespace
} // namespace halflight::unwrap_pages_test
