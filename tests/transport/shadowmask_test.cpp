// Shadowmasks against geometry (spec S8, S29, S30).

#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace halflight::test::shadowmask_test {
namespace {

constexpr int kPage = 64;

/// Shadows of blended surfaces are as even as these are, not speckled by rays that pass by chance, in masks, in
/// direct light and in probes.
TEST(ShadowmaskS8, PanesDimEvenly)
{
    for (const LightMode mode : {LightMode::Mixed, LightMode::Baked}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0));
        addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(63)});
        const auto addPane = [&](float height, float coverage, float halfWidth) {
            const int pane = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
            scene.materials[std::size_t(pane)].alphaMode = Material::AlphaMode::Blend;
            scene.materials[std::size_t(pane)].baseColor.w = coverage;
            const float w = halfWidth;
            addRectangle(scene, {vec3(-w, height, w), vec3(2 * w, 1.5f, 0), vec3(0, 0, -2 * w)}, pane, kPage);
        };
        addPane(1.0f, 0.3f, 6.0f);
        addPane(2.0f, 0.1f, 9.0f);
        addPane(3.0f, 0.2f, 7.0f);
        scene.lights.push_back(
            makeLight(LightType::Directional, vec3(0), glm::normalize(vec3(0.3f, -1, 0.2f)), 10.0f, mode));
        IntegrationSettings settings;
        settings.samples = 16;
        settings.bounces = 0;
        settings.shadowSamples = 32;
        Scene open = scene; // without the panes
        open.objects.resize(1);
        open.meshes.resize(1);
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const float arrives = 0.7f * 0.9f * 0.8f;
        const float cosine = 1.0f / std::sqrt(1.0f + 0.3f * 0.3f + 0.2f * 0.2f);
        for (const IrradianceEstimate& e : bench.irradiance()) {
            if (mode == LightMode::Baked) EXPECT_NEAR(e.irradiance.x, 10.0f * cosine * arrives, 0.005f * 10.0f);
        }
        if (mode == LightMode::Baked) continue;
        const uint64_t before = bench.integrator->raysTraced();
        for (const vec4 m : bench.shadowmask()) EXPECT_NEAR(m.x, arrives, 0.005f);
        // A pane is no edge of a shadow: as many rays are enough as where all is lit.
        Bench lit(std::move(open), MixedLightingMode::Shadowmask, kPage, settings);
        const uint64_t beforeLit = lit.integrator->raysTraced();
        lit.shadowmask();
        EXPECT_EQ(bench.integrator->raysTraced() - before, lit.integrator->raysTraced() - beforeLit);
        const vec3 position(0.0f, 0.2f, 0.0f);
        const uint32_t which = 0;
        ProbeEstimate probe;
        ASSERT_TRUE(bench.integrator->probes({&position, 1}, {&which, 1}, 64, {&probe, 1}, {}));
        EXPECT_NEAR(probe.occlusion[0], arrives, 1.0e-4f);
    }
}

/// A light that is off in the file has its mask all the same: it may be switched on at run time.
TEST(ShadowmaskS29, LightsThatAreOffHaveAMask)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(63)});
    addBox(scene, vec3(-0.5f, 1.0f, -0.5f), vec3(0.5f, 1.1f, 0.5f), black, false);
    scene.lights.push_back(makeLight(LightType::Point, vec3(0, 2, 0), vec3(0, -1, 0), 0.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    float lowest = 1.0f;
    for (const vec4 m : bench.shadowmask()) lowest = std::min(lowest, m.x);
    EXPECT_EQ(lowest, 0.0f);
}

/// An object that casts no shadow leaves mask and occlusion lit below it; the same one that casts does not.
TEST(ShadowmaskS30, ObjectsThatCastNoShadowLeaveItLit)
{
    for (const auto& [byObject, byMaterial] : {std::pair(true, true), {false, true}, {true, false}}) {
        const bool casts = byObject && byMaterial;
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        const int boxes = addMaterial(scene, vec3(0.5f));
        addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(1), vec2(63)});
        addBox(scene, vec3(-1, 1.0f, -1), vec3(1, 1.2f, 1), boxes, false);
        for (std::size_t i = 1; i < scene.objects.size(); ++i) scene.objects[i].castShadows = byObject;
        scene.materials[std::size_t(boxes)].castShadows = byMaterial;
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 3.0f, LightMode::Mixed));
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
        const auto mask = bench.shadowmask();
        int below = 0;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            const vec3 p = bench.positionOf(bench.map.texels[i]);
            const bool under = std::max(std::abs(p.x), std::abs(p.z)) < 0.9f;
            if (under) EXPECT_EQ(mask[i].x, casts ? 0.0f : 1.0f);
            below += under;
        }
        EXPECT_GT(below, 100);
        std::vector<ProbeEstimate> probe(1);
        const vec3 place(0.2f, 0.5f, 0.1f);
        const uint32_t which = 0;
        ASSERT_TRUE(bench.integrator->probes({&place, 1}, {&which, 1}, 0, probe, {}));
        EXPECT_EQ(probe[0].occlusion[0], casts ? 0.0f : 1.0f);
    }
}

/// The foot of a wall that goes through the floor: no mask texel beside it is darkened by its own inside.
TEST(ShadowmaskS8, NoDarkSeamAtTheFootOfAWall)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(0), vec2(64)});
    addBox(scene, vec3(-0.53f, -0.5f, -0.53f), vec3(0.53f, 1, 0.53f), grey, false);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto estimates = bench.irradiance();
    const auto mask = bench.shadowmask();
    for (std::size_t i = 0; i < mask.size(); ++i) {
        // One of a texel's sixteen points may slip through the checks; a seam is several.
        if (estimates[i].valid) EXPECT_GE(mask[i].x, 0.93f);
    }
}

/// A lamp close below a floor: the floor itself is between, for each ray. Rays start above it by a small distance,
/// which may not be left out of them.
TEST(ShadowmaskS8, FloorsHideLampsBelow)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-0.4f, 1.98f, 0.4f), vec3(0.8f, 0, 0), vec3(0, 0, -0.8f)}, grey, kPage,
                 {vec2(0), vec2(64)});
    scene.lights.push_back(makeLight(LightType::Point, vec3(-0.03f, 1.75f, 0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    for (const vec4 m : bench.shadowmask()) EXPECT_EQ(m.x, 0.0f);
}

/// A box with averaged normals close to a wall: moving shadow rays out to the curved surface must not move them
/// through.
TEST(ShadowmaskS8, SmoothNormalsDoNotLeakThroughWalls)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    const float corner = 1.0f / std::sqrt(2.0f);
    addRectangle(scene, {vec3(0, -1, 1), vec3(0, 0, -2), vec3(0, 2, 0)}, grey, kPage, {vec2(1), vec2(63)});
    scene.meshes[0].parts[0].normals = {vec3(corner, 0, corner), vec3(corner, 0, -corner), vec3(corner, 0, -corner),
                                        vec3(corner, 0, corner)};
    addBox(scene, vec3(0.2f, -5, -5), vec3(0.3f, 5, 5), grey, false);
    scene.lights.push_back(makeLight(LightType::Point, vec3(3, 0, 0), vec3(-1, 0, 0), 1.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    for (const vec4 m : bench.shadowmask()) EXPECT_EQ(m.x, 0.0f);
}

/// A sun of angular radius a behind a half-plane at height h: the visible share of its disc is a circular segment.
TEST(ShadowmaskS8, PenumbraOfAHalfPlaneIsTheVisibleSegmentOfTheSun)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, {vec3(-0.4f, 0, 0.4f), vec3(0.8f, 0, 0), vec3(0, 0, -0.8f)}, black, kPage, {vec2(1), vec2(63)});
    addRectangle(scene, {vec3(0, 2, 50), vec3(50, 0, 0), vec3(0, 0, -100)}, black, kPage);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    scene.lights[0].angularRadiusRadians = 0.1f;
    IntegrationSettings settings;
    settings.shadowSamples = 256;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    ASSERT_EQ(bench.scene.lights[0].baking.occlusionMaskChannel, 0);
    const auto mask = bench.shadowmask();
    const float halfWidth = 2.0f * std::tan(0.1f);
    int inPenumbra = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const float s = std::clamp(-bench.positionOf(bench.map.texels[i]).x / halfWidth, -1.0f, 1.0f);
        const float expected = 0.5f + (s * std::sqrt(1.0f - s * s) + std::asin(s)) / kPi;
        EXPECT_NEAR(mask[i].x, expected, 0.03f);
        EXPECT_EQ(mask[i].y, 1.0f);
        if (std::abs(s) < 1.0f) ++inPenumbra;
    }
    EXPECT_GT(inPenumbra, 1000);
}

TEST(ShadowmaskS8, HardShadowOfAPointLightIsWhereGeometrySays)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(0.5f), vec2(62.5f)});
    addBox(scene, vec3(-0.5f, 1.0f, -0.5f), vec3(0.5f, 1.1f, 0.5f), black, false);
    scene.lights.push_back(makeLight(LightType::Point, vec3(0, 2, 0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto mask = bench.shadowmask();
    // Projected from (0,2,0) the top edge at 1.1 is the widest: half side 0.5 * 2 / 0.9.
    const float shadow = 0.5f * 2.0f / 0.9f;
    const float texel = 4.0f / 62.0f;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const vec3 p = glm::abs(bench.positionOf(bench.map.texels[i]));
        const float distance = std::max(p.x, p.z);
        if (distance < shadow - texel) EXPECT_EQ(mask[i].x, 0.0f);
        if (distance > shadow + texel) EXPECT_EQ(mask[i].x, 1.0f);
    }
}

/// A sun without extent over a slanted half-plane: a texel's share of light is the area of its lit part. Sixty-four
/// rays resolve it as sixty-four points do, not as the sixteen that a texel's gather rays start from (7 %).
TEST(ShadowmaskS8, HardEdgesAreAntialiasedByAllRays)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(63)});
    const vec2 along = glm::normalize(vec2(0.23f, 1.0f)); // of the edge, in x and z
    const vec2 across(along.y, -along.x);
    addRectangle(scene,
                 {vec3(-20.0f * along.x, 2, -20.0f * along.y), vec3(40.0f * along.x, 0, 40.0f * along.y),
                  vec3(20.0f * across.x, 0, 20.0f * across.y)},
                 black, kPage);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    IntegrationSettings settings;
    settings.shadowSamples = 64;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const auto mask = bench.shadowmask();
    double squares = 0.0;
    int edge = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const Texel& t = bench.map.texels[i];
        if (t.x < 2 || t.y < 2 || t.x > 61 || t.y > 61) continue;
        float lit = 0.0f;
        constexpr int kSide = 64;
        for (int s = 0; s < kSide * kSide; ++s) {
            const vec2 place = vec2(t.x, t.y) + (vec2(s % kSide, s / kSide) + 0.5f) / float(kSide);
            const vec2 floor = (place - 1.0f) * (4.0f / 62.0f);
            if (glm::dot(vec2(-2.0f + floor.x, 2.0f - floor.y), across) < 0.0f) lit += 1.0f / float(kSide * kSide);
        }
        if (lit == 0.0f || lit == 1.0f) {
            EXPECT_NEAR(mask[i].x, lit, 0.02f);
            continue;
        }
        squares += double(mask[i].x - lit) * double(mask[i].x - lit);
        ++edge;
    }
    ASSERT_GT(edge, 60);
    EXPECT_LT(std::sqrt(squares / edge), 0.03);
}

TEST(ShadowmaskS8, AlphaMaskedHolesLetLightThrough)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0));
    // Left half of the texture is a hole.
    ImageRgba8 pixels(2, 1, u8vec4(255));
    pixels(0, 0).w = 0;
    const int grate = addMaterialWithHoles(scene, vec3(0), std::move(pixels));
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, black, kPage, {vec2(1), vec2(63)});
    addRectangle(scene, {vec3(-1, 1, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, grate, kPage);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto mask = bench.shadowmask();
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const float x = bench.positionOf(bench.map.texels[i]).x;
        if (std::abs(x) > 0.05f) EXPECT_EQ(mask[i].x, x < 0.0f ? 1.0f : 0.0f) << x;
    }
}

} // namespace
} // namespace halflight::test::shadowmask_test
