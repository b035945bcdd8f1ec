// What the renderer refuses, and what it makes of radiance.
#include "render/render_test.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>

namespace halflight::test::renderer_test {
namespace {

using testing::HasSubstr;

BakedScene oneRectangle()
{
    BakedScene baked;
    addObject(baked.scene, makeRectangle(1, 1, addMaterial(baked.scene, vec4(1.0f))), mat4(1.0f), true);
    return baked;
}

TEST(RendererErrors, NoDriverIsOneClearSentence)
{
    // The loader reads these when the instance is made; this is the only test of its process that needs no driver.
    setenv("VK_DRIVER_FILES", "/nonexistent/driver.json", 1);
    setenv("VK_ICD_FILENAMES", "/nonexistent/driver.json", 1);
    const auto created = Renderer::create();
    unsetenv("VK_DRIVER_FILES");
    unsetenv("VK_ICD_FILENAMES");
    ASSERT_FALSE(created);
    EXPECT_EQ(created.error().code, ErrorCode::DeviceFailed);
    EXPECT_THAT(created.error().message, HasSubstr("driver"));
}

TEST_F(RenderTest, RefusesBrokenScenes)
{
    auto refused = [&](const BakedScene& baked, const char* part) {
        const Status status = renderer->load(baked);
        ASSERT_FALSE(status);
        EXPECT_THAT(status.error().text(), HasSubstr(part));
    };
    BakedScene baked = oneRectangle();
    baked.scene.meshes[0].parts[0].indices[2] = 4;
    refused(baked, "index");
    baked = oneRectangle();
    baked.scene.meshes[0].parts[0].normals.pop_back();
    refused(baked, "attributes");
    baked = oneRectangle();
    baked.scene.meshes[0].parts[0].material = 7;
    refused(baked, "material");
    baked = oneRectangle();
    baked.scene.materials[0].baseColorTexture.texture = 0;
    refused(baked, "/materials/0");
    baked = oneRectangle();
    baked.scene.objects[0].mesh = 3;
    refused(baked, "mesh");
    baked = oneRectangle();
    baked.isBaked = true;
    baked.scene.objects[0].lightmap.page = 0;
    refused(baked, "page");
    baked = oneRectangle();
    baked.isBaked = true;
    baked.lightmaps = {Image<uint32_t>(4, 4), Image<uint32_t>(8, 8)};
    refused(baked, "size");
}

TEST_F(RenderTest, RefusesBadSettings)
{
    startAnew();
    ASSERT_FALSE(renderer->render(Camera{}, {})) << "nothing loaded";
    ASSERT_TRUE(renderer->load(oneRectangle()));
    RenderSettings settings;
    settings.size = {0, 10};
    auto frame = renderer->render(Camera{}, settings);
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().code, ErrorCode::InvalidArgument);
    settings.size = {64, 64};
    settings.shadows.cascades = 5;
    EXPECT_FALSE(renderer->render(Camera{}, settings));
    settings.shadows.cascades = 4;
    settings.mode = RunMode::Shadowmask;
    EXPECT_FALSE(renderer->render(Camera{}, settings)) << "an unbaked scene has no masks";
    settings.mode = RunMode::Realtime;
    Camera camera;
    camera.verticalFovRadians = 0.0f;
    EXPECT_FALSE(renderer->render(camera, settings));
    camera = {};
    camera.worldFromCamera[3].x = NAN;
    EXPECT_FALSE(renderer->render(camera, settings));
    EXPECT_TRUE(renderer->render(Camera{}, settings));
}

// Scenes may be empty, flat, or without anything optional; the same renderer takes one after the other, and frames of
// different sizes and settings.
TEST_F(RenderTest, OddButValidScenes)
{
    BakedScene empty;
    RenderSettings settings;
    settings.size = {33, 17};
    EXPECT_EQ(vec3(render(empty, Camera{}, settings).radiance(5, 5)), vec3(0.0f));

    BakedScene bare = oneRectangle();
    MeshPart& part = bare.scene.meshes[0].parts[0];
    part.normals.clear();
    part.tangents.clear();
    part.uv = {};
    part.lightmapUv.clear();
    part.material = -1;
    bare.scene.objects[0].worldFromObject[1] = vec4(0.0f); // flattened: no inverse
    bare.scene.objects.push_back({});                      // without a mesh
    const Light sun = directionalLight(vec3(0, 1, 0.1f), 2.0f);
    bare.scene.lights.push_back(sun);
    settings.size = {80, 45};
    settings.shadows.cascades = 2;
    const Camera camera = lookAt(vec3(0, 2, 0.01f), vec3(0.0f));
    const RenderedFrame frame = render(bare, camera, settings);
    const Ray ray = pixelRay(camera, settings.size, {40, 22});
    // glTF's default material is white metal of roughness 1.
    const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, vec3(1.0f), 1.0f, 1.0f};
    EXPECT_TRUE(near(vec3(frame.radiance(40, 22)), directRadiance(point, sun, 1.0f)));
}

TEST_F(RenderTest, OrthographicCamera)
{
    BakedScene baked = oneRectangle();
    const Light sun = directionalLight(vec3(0.2f, 1, 0.1f), 2.0f);
    baked.scene.lights.push_back(sun);
    Camera camera = lookAt(vec3(0, 2, 0), vec3(0.0f));
    camera.orthographic = true;
    camera.orthographicHeightMeters = 2.0f; // the rectangle fills the middle half
    camera.farMeters = 10.0f;
    RenderSettings settings;
    settings.size = {64, 64};
    const RenderedFrame frame = render(baked, camera, settings);
    const ShadedPoint point{vec3(0.0f), vec3(0, 1, 0), vec3(0, 1, 0), vec3(1.0f)};
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const bool inside = x >= 16 && x < 48 && y >= 16 && y < 48;
            ASSERT_TRUE(near(vec3(frame.radiance(x, y)), inside ? directRadiance(point, sun, 1.0f) : vec3(0.0f)))
                << x << ' ' << y;
        }
}

// An edge through the middle of a pixel's column: with 2 x 2 samples the column is half as bright.
TEST_F(RenderTest, SupersamplingAveragesRadiance)
{
    BakedScene baked = oneRectangle();
    const Light sun = directionalLight(vec3(0.2f, 1, 0.1f), 2.0f);
    baked.scene.lights.push_back(sun);
    Camera camera = lookAt(vec3(0.5f / 32.0f, 2, 0), vec3(0.5f / 32.0f, 0, 0));
    camera.orthographic = true;
    camera.orthographicHeightMeters = 2.0f;
    camera.farMeters = 10.0f;
    RenderSettings settings;
    settings.size = {64, 64};
    settings.supersampling = 2;
    const RenderedFrame frame = render(baked, camera, settings);
    ASSERT_EQ(frame.radiance.size(), settings.size);
    const ShadedPoint point{vec3(0.0f), vec3(0, 1, 0), vec3(0, 1, 0), vec3(1.0f)};
    const vec3 full = directRadiance(point, sun, 1.0f);
    EXPECT_TRUE(near(vec3(frame.radiance(14, 32)), vec3(0.0f)));
    EXPECT_TRUE(near(vec3(frame.radiance(15, 32)), 0.5f * full));
    EXPECT_TRUE(near(vec3(frame.radiance(16, 32)), full));
    EXPECT_TRUE(near(vec3(frame.radiance(47, 32)), 0.5f * full));
    EXPECT_TRUE(near(vec3(frame.radiance(48, 32)), vec3(0.0f)));
}

// Many instances of one mesh are one draw per part and equal separate objects.
TEST_F(RenderTest, InstancesOfSharedMeshes)
{
    BakedScene shared;
    BakedScene separate;
    for (BakedScene* baked : {&shared, &separate}) {
        const int material = addMaterial(baked->scene, vec4(0.5f, 0.6f, 0.7f, 1.0f));
        baked->scene.lights.push_back(directionalLight(vec3(0.5f, 1, 0.2f), 3.0f));
        for (int i = 0; i < 100; ++i) {
            mat4 pose(1.0f);
            pose[0].x = i % 3 == 0 ? -0.8f : 0.8f;
            pose[3] = vec4(float(i % 10) - 4.5f, 0.3f * float(i % 4), -float(i / 10), 1.0f);
            addObject(baked->scene, makeRectangle(1, 1, material), pose, false);
            if (baked == &shared) baked->scene.objects.back().mesh = 0;
        }
    }
    const Camera camera = lookAt(vec3(0, 4, 5), vec3(0, 0, -4));
    RenderSettings settings;
    settings.size = {160, 90};
    EXPECT_EQ(render(shared, camera, settings).radiance.texels(), render(separate, camera, settings).radiance.texels());
}

TEST(DisplayedPicture, ExposureToneMapAndSrgb)
{
    ImageRgba32f radiance(4, 1);
    radiance(0, 0) = vec4(0.36f, 0.36f, 0.36f, 1);
    radiance(1, 0) = vec4(NAN, -1.0f, 0.0f, 1);
    radiance(2, 0) = vec4(1.0e30f);
    radiance(3, 0) = vec4(INFINITY);
    const ImageRgba8 picture = displayedPicture(radiance, 1.0f);
    // 0.36 at EV 1 is 0.18; below its shoulder the neutral mapper takes 0.04 away: 0.14, which is sRGB 104.5 / 255.
    const float expected = 255.0f * (1.055f * std::pow(0.14f, 1.0f / 2.4f) - 0.055f);
    EXPECT_NEAR(float(picture(0, 0).g), expected, 0.51f);
    EXPECT_EQ(picture(1, 0), u8vec4(0, 0, 0, 255));
    EXPECT_GE(int(picture(2, 0).r), 250);
    EXPECT_GE(int(picture(3, 0).r), 250);
}

TEST(AutomaticExposure, LogAverageAtMiddleGrey)
{
    ImageRgba32f radiance(2, 2);
    radiance(0, 0) = vec4(10, 10, 10, 1);
    radiance(1, 0) = vec4(1000, 1000, 1000, 1);
    radiance(0, 1) = vec4(0, 0, 0, 1); // says nothing
    radiance(1, 1) = vec4(INFINITY, 0, 0, 1);
    EXPECT_NEAR(automaticExposure(radiance), std::log2(100.0f / 0.18f), 1.0e-4f);
    EXPECT_EQ(automaticExposure(ImageRgba32f(3, 3)), 0.0f);
}

// Highlights of a colour: up to 2 % of the pixels may be burnt, that is above 4 after exposure. With more of them the
// picture becomes darker, by two stops at most.
TEST(AutomaticExposure, KeepsHighlights)
{
    const auto exposureWith = [](int bright, float value) {
        ImageRgba32f radiance(20, 10, vec4(1, 1, 1, 1));
        for (int i = 0; i < bright; ++i) radiance(i, 0) = vec4(0.2f * value, value, 0.1f * value, 1);
        return automaticExposure(radiance);
    };
    const auto logAverage = [](int bright, float value) {
        const float bits = std::log2(luminance(vec3(0.2f, 1, 0.1f) * value));
        return float(bright) / 200.0f * bits - std::log2(0.18f);
    };
    EXPECT_NEAR(exposureWith(4, 100.0f), logAverage(4, 100.0f), 1e-3f);
    EXPECT_NEAR(exposureWith(5, 90.0f), std::log2(90.0f / 4.0f), 1e-3f);
    EXPECT_NEAR(exposureWith(5, 1000.0f), logAverage(5, 1000.0f) + 2.0f, 1e-3f);
    EXPECT_NEAR(exposureWith(20, 2.0f), logAverage(20, 2.0f), 1e-3f);
    // Four units are shown as what the limit says.
    EXPECT_EQ(displayedPicture(ImageRgba32f(1, 1, vec4(4, 4, 4, 1)), 0.0f)(0, 0).x, 253);
}

} // namespace
} // namespace halflight::test::renderer_test
