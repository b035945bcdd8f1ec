// The deferred path: the same picture as the forward one, a fifth target only for masks, and what goes forward.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

namespace halflight::test::deferred_test {
namespace {

constexpr ivec2 kSize{320, 180};

/// Bumps, metal and holes.
std::vector<Texture> galleryTextures()
{
    Texture bumps;
    bumps.pixels = ImageRgba8(32, 32);
    Texture metal;
    metal.pixels = ImageRgba8(32, 32);
    Texture holes;
    holes.pixels = ImageRgba8(16, 16);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            bumps.pixels.edit()(x, y) =
                u8vec4(128 + 60 * std::sin(0.8f * float(x)), 128 + 50 * std::cos(0.5f * float(y)), 220, 255);
            metal.pixels.edit()(x, y) = u8vec4(255, 40 + 6 * x, 8 * y, 255);
            holes.pixels.edit()(x / 2, y / 2) = u8vec4(200, 180, 60, (x / 8 + y / 8) % 2 == 0 ? 255 : 0);
        }
    return {bumps, metal, holes};
}

struct GalleryMaterials {
    int plaster = 0;
    int bumpy = 0;
    int leaf = 0;
    int lamp = 0;
    int sign = 0;
};

GalleryMaterials addGalleryMaterials(Scene& scene)
{
    const int plaster = addMaterial(scene, vec4(0.07f, 0.3f, 0.55f, 1.0f)); // not a multiple of 1 / 255
    const int bumpy = addMaterial(scene, vec4(0.9f, 0.6f, 0.03f, 1.0f));
    scene.materials[std::size_t(bumpy)].normalTexture.texture = 0;
    scene.materials[std::size_t(bumpy)].metallicRoughnessTexture.texture = 1;
    scene.materials[std::size_t(bumpy)].metallic = 0.93f;
    scene.materials[std::size_t(bumpy)].specular = 0.7f;
    const int leaf = addMaterial(scene, vec4(1.0f));
    scene.materials[std::size_t(leaf)].baseColorTexture.texture = 2;
    scene.materials[std::size_t(leaf)].alphaMode = Material::AlphaMode::Mask;
    scene.materials[std::size_t(leaf)].doubleSided = true;
    const int lamp = addMaterial(scene, vec4(0.2f, 0.2f, 0.2f, 1.0f));
    scene.materials[std::size_t(lamp)].emissiveNits = vec3(0.3f, 0.05f, 0.01f);
    const int sign = addMaterial(scene, vec4(0.15f, 0.8f, 0.4f, 1.0f));
    scene.materials[std::size_t(sign)].unlit = true;
    return {plaster, bumpy, leaf, lamp, sign};
}

void addGalleryObjects(Scene& scene, const GalleryMaterials& kinds)
{
    const auto at = [](vec3 p) { return glm::translate(mat4(1.0f), p); };
    const mat4 upright = glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0));
    addObject(scene, makeRectangle(14, 14, kinds.plaster), at(vec3(0, 0, -3)), true);
    addObject(scene, makeRectangle(14, 5, kinds.bumpy), at(vec3(0, 2.5f, -6)) * upright, true);
    scene.objects[0].lightmap = {0, vec2(0.5f), vec2(0.0f)};
    scene.objects[1].lightmap = {0, vec2(0.5f), vec2(0.5f)};
    addObject(scene, makeRectangle(2, 2, kinds.leaf), at(vec3(-2, 1.2f, -2)) * upright, false);
    addObject(scene, makeRectangle(2, 2, kinds.bumpy), at(vec3(1.5f, 0.8f, -2)), false);
    addObject(scene, makeRectangle(1, 1, kinds.lamp), at(vec3(3, 1, -2)) * upright, false);
    addObject(scene, makeRectangle(1, 1, kinds.sign), at(vec3(-4, 1, -3)) * upright, false);
    scene.objects.back().receiveShadows = false;
    addObject(scene, makeRectangle(1, 1, kinds.plaster), at(vec3(0, 0.5f, 0)), false);
    scene.objects.back().receiveShadows = false;
}

std::vector<Light> galleryLights(MixedLightingMode mode)
{
    const bool masked = mode == MixedLightingMode::Shadowmask;
    Light sun = directionalLight(vec3(0.5f, 1, 0.4f), 3.0f);
    bakeAsMixed(sun, mode, mode == MixedLightingMode::BakedIndirect ? -1 : 0);
    Light spot;
    spot.type = LightType::Spot;
    spot.worldFromLight = lightPose(vec3(-3, 4, 1), vec3(0.3f, -1, -0.6f));
    spot.intensity = 40.0f;
    spot.color = vec3(1, 0.7f, 0.4f);
    bakeAsMixed(spot, mode, masked ? 1 : -1);
    Light point;
    point.type = LightType::Point;
    point.worldFromLight = lightPose(vec3(3, 2, -4), vec3(0, -1, 0));
    point.intensity = 8.0f;
    point.rangeMeters = 6.0f;
    bakeAsMixed(point, mode, masked ? 2 : -1);
    Light torch = spot;
    torch.baking = {};
    torch.mode = LightMode::Realtime;
    torch.worldFromLight = lightPose(vec3(4, 3, 2), vec3(-0.6f, -1, -0.8f));
    return {sun, spot, point, torch};
}

void addGalleryPages(BakedScene& baked)
{
    constexpr int kPage = 64;
    Image<uint32_t> lightmap(kPage, kPage);
    ImageRgba8 mask(kPage, kPage);
    for (int y = 0; y < kPage; ++y)
        for (int x = 0; x < kPage; ++x) {
            lightmap(x, y) = glm::packF3x9_E1x5(vec3(0.2f + 0.02f * float(x), 0.5f, 0.1f + 0.03f * float(y)));
            mask(x, y) = u8vec4(x / 4 % 2 == 0 ? 255 : 30, y / 4 % 3 == 0 ? 255 : 60, 4 * x, 255);
        }
    baked.lightmaps = {lightmap};
    if (baked.mode != MixedLightingMode::BakedIndirect) baked.shadowmasks = {mask};
}

/// One of each: materials with textures and without, light types, static and dynamic receivers, holes, emission.
BakedScene gallery(MixedLightingMode mode)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = mode;
    Scene& scene = baked.scene;
    scene.sky = {vec3(0.4f, 0.5f, 0.8f), vec3(0.6f), vec3(0.1f)};
    scene.textures = galleryTextures();
    addGalleryObjects(scene, addGalleryMaterials(scene));
    scene.lights = galleryLights(mode);
    addGalleryPages(baked);
    Probe probe;
    probe.radiance = {vec3(0.9f, 1.0f, 1.2f), vec3(0.2f), vec3(0.1f), vec3(-0.1f, 0.0f, 0.1f)};
    probe.occlusion.layers[0] = vec4(0.37f, 0.81f, 0.55f, 1.0f);
    baked.probes.probes = {probe};
    return baked;
}

RenderSettings settingsFor(RunMode mode, RenderPath path)
{
    RenderSettings settings;
    settings.mode = mode;
    settings.path = path;
    settings.size = kSize;
    settings.shadows.directionalMapSize = 1024;
    settings.shadows.atlasSize = 2048;
    settings.shadows.distanceMeters = 9.0f; // the wall lies beyond, the floor within and in the fade
    settings.shadows.fadeRangeMeters = 3.0f;
    return settings;
}

Camera galleryCamera()
{
    return lookAt(vec3(0.4f, 2.2f, 4.5f), vec3(0, 0.9f, -3), 1.1f);
}

MixedLightingMode bakeModeFor(RunMode mode)
{
    if (mode == RunMode::Subtractive) return MixedLightingMode::Subtractive;
    if (mode == RunMode::BakedIndirect) return MixedLightingMode::BakedIndirect;
    return MixedLightingMode::Shadowmask;
}

class DeferredS26 : public RenderTest, public testing::WithParamInterface<RunMode> {
protected:
    RenderedFrame draw(const Camera& camera, const RenderSettings& settings)
    {
        auto frame = renderer->render(camera, settings);
        if (!frame) {
            ADD_FAILURE() << frame.error().text();
            return {ImageRgba32f(settings.size.x, settings.size.y, vec4(0.0f)), {}, {}};
        }
        return std::move(*frame);
    }
};

INSTANTIATE_TEST_SUITE_P(, DeferredS26,
                         testing::Values(RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask,
                                         RunMode::DistanceShadowmask, RunMode::Subtractive));

// Every pixel, not most of them: half a percent of its value, and for black ones 1/2000 of the picture's mean.
TEST_P(DeferredS26, EqualsForward)
{
    const RunMode mode = GetParam();
    ASSERT_TRUE(renderer->load(gallery(bakeModeFor(mode))));
    const RenderedFrame forward = draw(galleryCamera(), settingsFor(mode, RenderPath::Forward));
    const RenderedFrame deferred = draw(galleryCamera(), settingsFor(mode, RenderPath::Deferred));
    EXPECT_EQ(forward.gBufferTargets, 0);
    EXPECT_EQ(forward.forwardObjects, 7);
    EXPECT_EQ(deferred.forwardObjects, mode == RunMode::Subtractive ? 1 : 0);
    EXPECT_GE(deferred.gBufferTargets, 4);
    const PictureDifference difference = compare(forward.radiance, deferred.radiance);
    EXPECT_EQ(difference.differing, 0) << "worst at " << difference.worst.x << ' ' << difference.worst.y << ": "
                                       << difference.worstRelative;
    EXPECT_GT(difference.lit, kSize.x * kSize.y / 2);
}

// S26. The fifth target is there while a mask is in use and absent otherwise, whatever was drawn before.
TEST_F(RenderTest, FifthTargetOnlyWithMaskS26)
{
    BakedScene baked = gallery(MixedLightingMode::Shadowmask);
    ASSERT_TRUE(renderer->load(baked));
    auto targets = [&](RunMode mode, ivec2 size = kSize) {
        RenderSettings settings = settingsFor(mode, RenderPath::Deferred);
        settings.size = size;
        const auto frame = renderer->render(galleryCamera(), settings);
        EXPECT_TRUE(frame);
        EXPECT_EQ(frame->plan.usesMask, frame->gBufferTargets == 5);
        return frame->gBufferTargets;
    };
    EXPECT_EQ(targets(RunMode::Shadowmask), 5);
    EXPECT_EQ(targets(RunMode::BakedIndirect), 4);
    EXPECT_EQ(targets(RunMode::DistanceShadowmask), 5);
    EXPECT_EQ(targets(RunMode::Realtime), 4);
    EXPECT_EQ(targets(RunMode::Shadowmask, {64, 36}), 5);
    EXPECT_EQ(targets(RunMode::Realtime, {64, 36}), 4);
    for (Light& light : baked.scene.lights) { // no mixed light in view: no mask is read in any mode
        light.baking = {};
        light.mode = LightMode::Realtime;
    }
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_EQ(targets(RunMode::Shadowmask), 4);
    ASSERT_TRUE(renderer->load(gallery(MixedLightingMode::Subtractive)));
    EXPECT_EQ(targets(RunMode::Subtractive), 4);
}

// S11. What is lit as it is drawn reads the mask in frames that use one, and in no others, whatever was drawn before.
TEST_F(RenderTest, ForwardReadsMaskOnlyInFramesThatUseOneS11)
{
    BakedScene baked = gallery(MixedLightingMode::Shadowmask);
    ASSERT_TRUE(renderer->load(baked));
    auto readsMask = [&](RunMode mode, DebugView view = DebugView::Lit) {
        RenderSettings settings = settingsFor(mode, RenderPath::Forward);
        settings.view = view;
        const auto frame = renderer->render(galleryCamera(), settings);
        EXPECT_TRUE(frame);
        return frame->forwardReadsMask;
    };
    EXPECT_TRUE(readsMask(RunMode::Shadowmask));
    EXPECT_FALSE(readsMask(RunMode::BakedIndirect));
    EXPECT_TRUE(readsMask(RunMode::DistanceShadowmask));
    EXPECT_FALSE(readsMask(RunMode::Realtime));
    EXPECT_TRUE(readsMask(RunMode::BakedIndirect, DebugView::Shadowmask));
    for (Light& light : baked.scene.lights) light.castShadows = false;
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_FALSE(readsMask(RunMode::Shadowmask));
    // Subtractive: with pages, while a dynamic shadow of the main light is in view.
    baked = gallery(MixedLightingMode::Subtractive);
    const std::vector<ImageRgba8> pages = gallery(MixedLightingMode::Shadowmask).shadowmasks;
    baked.shadowmasks.clear();
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_FALSE(readsMask(RunMode::Subtractive));
    baked.shadowmasks = pages;
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_TRUE(readsMask(RunMode::Subtractive));
    for (Object& object : baked.scene.objects) object.castShadows = false;
    ASSERT_TRUE(renderer->load(baked));
    EXPECT_FALSE(readsMask(RunMode::Subtractive));
}

// S27. In subtractive mode static receivers go forward while realtime shadows of the sun can fall on them, and only
// then. (That their pixels are right: LawPixels, EqualsForward.)
TEST_F(RenderTest, SubtractiveReceiversGoForwardS27)
{
    BakedScene baked = gallery(MixedLightingMode::Subtractive);
    RenderSettings settings = settingsFor(RunMode::Subtractive, RenderPath::Deferred);
    auto forwardObjects = [&] {
        const RenderedFrame frame = render(baked, galleryCamera(), settings);
        EXPECT_EQ(frame.gBufferTargets, 4);
        return frame.forwardObjects;
    };
    EXPECT_EQ(forwardObjects(), 1) << "the floor; the wall is beyond the shadow distance";
    settings.shadows.distanceMeters = 20.0f;
    EXPECT_EQ(forwardObjects(), 1) << "no shadow reaches the wall";
    baked.scene.objects[4].worldFromObject[3] = vec4(3, 2, -5.5f, 1);
    EXPECT_EQ(forwardObjects(), 2);
    baked.scene.objects[1].receiveShadows = false;
    EXPECT_EQ(forwardObjects(), 1);
    for (Object& object : baked.scene.objects) object.castShadows = false;
    EXPECT_EQ(forwardObjects(), 0);
}

// Frames of either path and of other sizes between two deferred ones leave no trace.
TEST_F(RenderTest, PathsAndSizesAlternateS26)
{
    ASSERT_TRUE(renderer->load(gallery(MixedLightingMode::Shadowmask)));
    const RenderSettings settings = settingsFor(RunMode::Shadowmask, RenderPath::Deferred);
    const auto first = renderer->render(galleryCamera(), settings);
    ASSERT_TRUE(first);
    for (const ivec2 size : {ivec2(64, 64), kSize}) {
        RenderSettings other = settingsFor(RunMode::Realtime, RenderPath::Forward);
        other.size = size;
        ASSERT_TRUE(renderer->render(galleryCamera(), other));
    }
    const auto again = renderer->render(galleryCamera(), settings);
    ASSERT_TRUE(again);
    EXPECT_EQ(first->radiance.texels(), again->radiance.texels());
    EXPECT_EQ(again->gBufferTargets, 5);
}

TEST_F(RenderTest, DebugViewsGoForwardS31)
{
    ASSERT_TRUE(renderer->load(gallery(MixedLightingMode::Shadowmask)));
    for (const DebugView view : {DebugView::Shadowmask, DebugView::Fade, DebugView::Cascades}) {
        RenderSettings settings = settingsFor(RunMode::Shadowmask, RenderPath::Forward);
        settings.view = view;
        const auto forward = renderer->render(galleryCamera(), settings);
        settings.path = RenderPath::Deferred;
        const auto deferred = renderer->render(galleryCamera(), settings);
        ASSERT_TRUE(forward && deferred);
        EXPECT_EQ(forward->radiance.texels(), deferred->radiance.texels());
        EXPECT_EQ(deferred->gBufferTargets, 0);
    }
}

// An orthographic camera's positions come from depth by another formula.
TEST_F(RenderTest, OrthographicDeferredS26)
{
    ASSERT_TRUE(renderer->load(gallery(MixedLightingMode::Shadowmask)));
    Camera camera = galleryCamera();
    camera.orthographic = true;
    camera.orthographicHeightMeters = 7.0f;
    camera.farMeters = 40.0f;
    const auto forward = renderer->render(camera, settingsFor(RunMode::DistanceShadowmask, RenderPath::Forward));
    const auto deferred = renderer->render(camera, settingsFor(RunMode::DistanceShadowmask, RenderPath::Deferred));
    ASSERT_TRUE(forward && deferred);
    const PictureDifference difference = compare(forward->radiance, deferred->radiance);
    EXPECT_EQ(difference.differing, 0) << "worst at " << difference.worst.x << ' ' << difference.worst.y << ": "
                                       << difference.worstRelative;
    EXPECT_GT(difference.lit, kSize.x * kSize.y / 2);
}

} // namespace
} // namespace halflight::test::deferred_test
