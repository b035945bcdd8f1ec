// The bake against closed forms (spec S6, S8, S14).

#include "bake/test_scene.h"

#include "bake/gather.h"
#include "bake/main_light.h"

#include "halflight/base/random.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test {
namespace {

constexpr int kPage = 64;

/// Spread of a whole-map mean is far below a texel's; both are checked.
struct Statistics {
    double mean = 0.0;
    double worst = 0.0; ///< largest relative difference of a texel from `expected`
};

Statistics compare(const std::vector<IrradianceEstimate>& estimates, double expected)
{
    Statistics s;
    for (const IrradianceEstimate& e : estimates) {
        s.mean += e.irradiance.y / double(estimates.size());
        s.worst = std::max(s.worst, std::abs(e.irradiance.y - expected) / expected);
    }
    return s;
}

/// What holds for light holds whichever way it is transported.
class BothIntegrators : public testing::TestWithParam<IntegratorKind> {
protected:
    static IntegrationSettings transport()
    {
        IntegrationSettings settings;
        settings.integrator = GetParam();
        return settings;
    }
};
const auto kBoth = testing::Values(IntegratorKind::Cache, IntegratorKind::Path);
std::string integratorName(const testing::TestParamInfo<IntegratorKind>& info)
{
    return info.param == IntegratorKind::Cache ? "Cache" : "Path";
}
class FurnaceS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, FurnaceS6, kBoth, integratorName);
class DirectS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, DirectS6, kBoth, integratorName);
class IndirectS5 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, IndirectS5, kBoth, integratorName);
class EmitterS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, EmitterS6, kBoth, integratorName);
class SkyS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, SkyS6, kBoth, integratorName);
class LeaksS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, LeaksS6, kBoth, integratorName);

/// Every wall of a closed room reflects rho and emits Le: radiance is Le / (1 - rho) everywhere, irradiance pi times
/// that.
TEST_P(FurnaceS6, ClosedRoomReachesEmissionOverOneMinusAlbedo)
{
    for (const float albedo : {0.0f, 0.5f, 0.8f}) {
        Scene scene;
        const int walls = addMaterial(scene, vec3(albedo), vec3(2.0f));
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), walls, true, kPage);
        IntegrationSettings settings = transport();
        settings.samples = 256;
        settings.bounces = 64;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const double expected = kPi * 2.0 / (1.0 - albedo);
        const Statistics s = compare(bench.irradiance(), expected);
        EXPECT_NEAR(s.mean, expected, 0.01 * expected) << "albedo " << albedo;
        EXPECT_LT(s.worst, 0.15) << "albedo " << albedo;
    }
}

/// Metals carry light on as well, as much as their lobe reflects: a texture's blue scales metallic, its green
/// roughness.
TEST_P(FurnaceS6, MetalsReflectWhatTheirLobeDoes)
{
    for (const u8vec4 texel : {u8vec4(255, 255, 255, 255), u8vec4(0, 51, 255, 255), u8vec4(0, 204, 102, 255)}) {
        Scene scene;
        const int walls = addMaterial(scene, vec3(0.8f), vec3(2.0f));
        Texture texture;
        texture.pixels = ImageRgba8(1, 1);
        texture.pixels(0, 0) = texel;
        scene.textures.push_back(std::move(texture));
        Material& material = scene.materials[std::size_t(walls)];
        material.metallic = 1.0f;
        material.roughness = 0.5f;
        material.metallicRoughnessTexture.texture = 0;
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), walls, true, kPage);
        IntegrationSettings settings = transport();
        settings.samples = 256;
        settings.bounces = 64;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const float metallic = float(texel.z) / 255.0f;
        const float roughness = 0.5f * float(texel.y) / 255.0f;
        const float lobe = shading::averageSpecular(vec3(0.8f), 1.0f, roughness).x;
        const double expected = kPi * 2.0 / (1.0 - (metallic * lobe + (1.0f - metallic) * 0.8f));
        EXPECT_NEAR(compare(bench.irradiance(), expected).mean, expected, 0.01 * expected)
            << metallic << " " << roughness;
    }
}

/// Bounces are cut where asked: n bounces in the furnace give the first n + 1 terms of the geometric series.
TEST_P(FurnaceS6, BounceLimitGivesPartialSums)
{
    for (const int bounces : {0, 1, 3}) {
        Scene scene;
        const int walls = addMaterial(scene, vec3(0.5f), vec3(1.0f));
        addBox(scene, vec3(-1), vec3(1), walls, true, kPage);
        IntegrationSettings settings = transport();
        settings.samples = 256;
        settings.bounces = bounces;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const double expected = kPi * (1.0 - std::pow(0.5, bounces + 1)) / 0.5;
        EXPECT_NEAR(compare(bench.irradiance(), expected).mean, expected, 0.01 * expected) << bounces << " bounces";
    }
}

TEST_P(DirectS6, PointLightFollowsCosineAndInverseSquare)
{
    Scene scene;
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, addMaterial(scene, vec3(0)), kPage,
                 {vec2(1), vec2(63)});
    scene.lights.push_back(
        makeLight(LightType::Point, vec3(0.5f, 1.5f, -0.25f), vec3(0, -1, 0), 100.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const auto estimates = bench.irradiance();
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 toLight = bench.scene.lights[0].position() - bench.positionOf(bench.map.texels[i]);
        const float d2 = glm::dot(toLight, toLight);
        const float expected = 100.0f / d2 * (toLight.y / std::sqrt(d2));
        EXPECT_NEAR(estimates[i].irradiance.x, expected, 2e-3f * expected);
    }
}

/// The lightmap holds no direct light of a mixed light, but all of a baked one; subtractive holds both. What the
/// integrator does not bring of subtractive's main light, a directional one, is made of its mask.
TEST_P(DirectS6, MixedLightsAreInTheLightmapOnlyInSubtractive)
{
    for (const LightMode mode : {LightMode::Realtime, LightMode::Mixed, LightMode::Baked}) {
        for (const MixedLightingMode mixing :
             {MixedLightingMode::BakedIndirect, MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive}) {
            Scene scene;
            addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(1), vec2(9)});
            scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 7.0f, mode));
            Bench bench(std::move(scene), mixing, kPage, transport());
            const bool direct =
                mode == LightMode::Baked || (mode == LightMode::Mixed && mixing == MixedLightingMode::Subtractive);
            std::vector<IrradianceEstimate> estimates = bench.irradiance();
            std::vector<vec3> irradiance = splitEstimates(estimates).irradiance;
            std::optional<MainLight> main = findMainLight(bench.scene);
            EXPECT_EQ(main.has_value(), mode == LightMode::Mixed && mixing == MixedLightingMode::Subtractive);
            if (main) {
                EXPECT_EQ(irradiance[20].x, 0.0f);
                const IntegrationSettings settings = transport();
                ASSERT_TRUE(
                    bakeMainLight({*bench.integrator, bench.geometry, bench.map, settings}, estimates, *main, {}));
                main->addTo(irradiance);
            }
            EXPECT_NEAR(irradiance[20].x, direct ? 7.0f : 0.0f, 1e-4f);
        }
    }
}

/// Subtractive's main light in the lightmap is its mask times what it gives without shadows, strength included; below a
/// pane and a wall, and on the side that faces away.
TEST_P(DirectS6, SubtractiveMainLightIsWhatItsMaskLetsArrive)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(41)});
    addRectangle(scene, {vec3(-2, -1, -2), vec3(4, 0, 0), vec3(0, 0, 4)}, black, kPage, {vec2(43, 1), vec2(51, 9)});
    const int pane = addMaterial(scene, vec3(0.5f), vec3(0), true);
    scene.materials[std::size_t(pane)].alphaMode = Material::AlphaMode::Blend;
    scene.materials[std::size_t(pane)].baseColor.w = 0.6f;
    addRectangle(scene, {vec3(-9, 1, 9), vec3(8, 0, 0), vec3(0, 0, -18)}, pane, kPage);
    const int wall = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, {vec3(1, 1, 9), vec3(8, 0, 0), vec3(0, 0, -18)}, wall, kPage);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 10.0f, LightMode::Mixed));
    scene.lights[0].shadowStrength = 0.5f;
    IntegrationSettings settings = transport();
    settings.bounces = 0;
    Bench bench(std::move(scene), MixedLightingMode::Subtractive, kPage, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    std::optional<MainLight> main = findMainLight(bench.scene);
    ASSERT_TRUE(main);
    ASSERT_TRUE(bakeMainLight({*bench.integrator, bench.geometry, bench.map, settings}, estimates, *main, {}));
    int seen[4] = {};
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 place = bench.positionOf(bench.map.texels[i]);
        if (place.y < -0.5f) { // faces down
            EXPECT_EQ(main->at(i), vec3(0.0f));
            EXPECT_EQ(main->mask()[i], vec4(0, 1, 1, 1));
            ++seen[0];
        } else if (std::abs(place.x + 1.0f) > 0.1f && std::abs(place.x - 1.0f) > 0.1f) {
            const int kind = place.x < -1.0f ? 1 : place.x < 1.0f ? 2 : 3;
            const float arrives = kind == 1 ? 0.4f : kind == 2 ? 1.0f : 0.0f;
            EXPECT_NEAR(main->arriving[i], arrives, 0.002f);
            EXPECT_NEAR(main->at(i).x, 10.0f * (0.5f + 0.5f * main->arriving[i]), 1e-4f);
            ++seen[kind];
        }
    }
    for (const int count : seen) EXPECT_GT(count, 30);
}

/// The bake's shadow colour: the median of the light in the main light's shadow, by channel; the darkest twentieth with
/// a mask; what there would be where nothing is shadowed.
TEST(ShadowColorS23, IsTheLightWhereTheMainLightIsShadowed)
{
    MainLight main;
    std::vector<vec3> light;
    for (int i = 0; i < 100; ++i) { // in the sun, which tells nothing
        main.arriving.push_back(1.0f);
        main.unshadowed.emplace_back(5.0f);
        light.emplace_back(50.0f);
    }
    for (int i = 0; i < 100; ++i) { // faces away
        main.arriving.push_back(0.0f);
        main.unshadowed.emplace_back(0.0f);
        light.emplace_back(70.0f);
    }
    for (int i = 0; i <= 100; ++i) { // shadowed: 1…2, 3…2, 4
        main.arriving.push_back(0.0f);
        main.unshadowed.emplace_back(5.0f);
        light.emplace_back(1.0f + 0.01f * float(i), 3.0f - 0.01f * float(i), 4.0f);
    }
    for (int i = 0; i < 40; ++i) { // and covered by what stands there
        main.arriving.push_back(0.0f);
        main.unshadowed.emplace_back(5.0f);
        light.emplace_back(0.001f);
    }
    std::vector<uint8_t> valid(light.size(), 1);
    const auto near = [](vec3 a, vec3 b) { return glm::length(a - b) < 0.02f; };
    EXPECT_TRUE(near(chooseShadowColor(main, light, valid, false), vec3(1.5f, 2.5f, 4.0f)));
    EXPECT_TRUE(near(chooseShadowColor(main, light, valid, true), vec3(1.05f, 2.05f, 4.0f)));
    std::fill(valid.begin() + 200, valid.end(), uint8_t(0));
    EXPECT_EQ(chooseShadowColor(main, light, valid, false), vec3(50.0f)) << "no shadow: the light beside the sun's";
    std::fill(valid.begin(), valid.end(), uint8_t(0));
    EXPECT_EQ(chooseShadowColor(main, light, valid, false), vec3(0.0f));
}

/// Objects and materials that receive no shadows: their baked direct light, and masks of 1.
TEST_P(DirectS6, SurfacesWithoutShadowsAreLitAsIfNothingStoodThereS30)
{
    for (const bool byMaterial : {false, true}) {
        Scene scene;
        const int plain = addMaterial(scene, vec3(0));
        const int unshadowed = addMaterial(scene, vec3(0));
        scene.materials[std::size_t(unshadowed)].receiveShadows = !byMaterial;
        addRectangle(scene, {vec3(-2, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, plain, kPage, {vec2(1), vec2(21, 41)});
        addRectangle(scene, {vec3(0, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, unshadowed, kPage,
                     {vec2(31, 1), vec2(51, 41)});
        scene.objects.back().receiveShadows = byMaterial;
        const int roof = addMaterial(scene, vec3(0), vec3(0), true);
        addRectangle(scene, {vec3(-9, 1, 9), vec3(18, 0, 0), vec3(0, 0, -18)}, roof, kPage); // over both
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 10.0f, LightMode::Baked));
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 3.0f, LightMode::Mixed));
        IntegrationSettings settings = transport();
        settings.bounces = 0;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const std::vector<IrradianceEstimate> estimates = bench.irradiance();
        const std::vector<vec4> mask = bench.shadowmask();
        int seen[2] = {};
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const bool receives = bench.map.texels[i].x < 25;
            EXPECT_NEAR(estimates[i].irradiance.x, receives ? 0.0f : 10.0f, 1e-4f);
            EXPECT_EQ(mask[i].x, receives ? 0.0f : 1.0f);
            ++seen[receives ? 1 : 0];
        }
        EXPECT_GT(seen[0], 500);
        EXPECT_GT(seen[1], 500);
    }
}

/// Folds finer than texels: each texel is half a slope that faces the sun, behind a screen, and half one that the sun
/// grazes. Its light is the grazed half's, not half of what both have without the screen.
TEST_P(DirectS6, ShadowsOnTheBrighterSideOfFoldsCountAsMuch)
{
    constexpr int kFolds = 24;
    const vec3 facing(0, 0.8f, 0.6f);
    const vec3 grazed(0, 0.8f, -0.6f);
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    MeshPart part;
    part.material = black;
    const auto addSlope = [&](vec3 from, vec3 to, vec3 normal, float row) {
        const vec3 along(24, 0, 0);
        const auto first = uint32_t(part.positions.size());
        for (const vec3 corner : {from, to, to + along, from + along}) part.positions.push_back(corner);
        part.normals.insert(part.normals.end(), 4, normal);
        for (const vec2 texel : {vec2(2, row), vec2(2, row + 0.5f), vec2(26, row + 0.5f), vec2(26, row)})
            part.lightmapUv.push_back(texel / float(kPage));
        for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + corner);
    };
    for (int i = 0; i < kFolds; ++i) {
        const vec3 top(0, 0.375f, float(i));
        const vec3 foot(0, 0, float(i) + 0.5f);
        addSlope(top, foot, facing, 2.0f + float(i));
        addSlope(foot, top + vec3(0, 0, 1), grazed, 2.5f + float(i));
        addRectangle(scene, {top + 0.01f * facing, foot - top, vec3(24, 0, 0)}, black, kPage);
    }
    addObject(scene, std::move(part));
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -facing, 1.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const double expected = 0.5 * double(glm::dot(grazed, facing));
    const Statistics s = compare(bench.irradiance(), expected);
    EXPECT_NEAR(s.mean, expected, 0.04 * expected);
    EXPECT_LT(s.worst, 0.2);
}

/// Stripes finer than texels whose normals lean to all sides, a little: their light differs by a tenth, and a texel's
/// is their mean.
TEST_P(DirectS6, GentleFoldsHaveTheirMean)
{
    constexpr int kRows = 32;
    constexpr int kStripes = 5; // of a texel
    Scene scene;
    MeshPart part;
    part.material = addMaterial(scene, vec3(0));
    std::vector<float> expected;
    for (int row = 0; row < kRows; ++row) {
        float sum = 0.0f;
        for (int stripe = 0; stripe < kStripes; ++stripe) {
            const auto first = uint32_t(part.positions.size());
            const float lean = 0.5f * unitFloat(hashPcg(first));
            for (const vec2 corner : {vec2(0, 0), vec2(0, 1), vec2(1, 1), vec2(1, 0)}) {
                const vec2 at(float(kRows) * corner.x, float(row) + (float(stripe) + corner.y) / float(kStripes));
                part.positions.emplace_back(at.x, 0.0f, at.y);
                part.normals.emplace_back(std::sin(lean), std::cos(lean), 0.0f);
                part.lightmapUv.push_back((vec2(2) + at) / float(kPage));
            }
            for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + corner);
            sum += std::cos(lean) / float(kStripes);
        }
        expected.push_back(sum);
    }
    addObject(scene, std::move(part));
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Baked));
    IntegrationSettings settings = transport();
    settings.shadowSamples = 32;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    double squares = 0.0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const int row = int(bench.map.texels[i].y) - 2;
        ASSERT_TRUE(row >= 0 && row < kRows);
        const float error = estimates[i].irradiance.x / expected[std::size_t(row)] - 1.0f;
        squares += double(error * error) / double(estimates.size());
    }
    EXPECT_LT(std::sqrt(squares), 0.0025);
}

/// A mixed light's bounce is baked, scaled by its indirect multiplier: floor lit by a sun, ceiling sees the floor.
TEST_P(IndirectS5, MixedLightBouncesTimesItsMultiplier)
{
    for (const float multiplier : {0.0f, 1.0f, 2.5f}) {
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.4f));
        addRectangle(scene, {vec3(-500, 0, 500), vec3(1000, 0, 0), vec3(0, 0, -1000)}, grey, kPage);
        // The receiver looks down, is small and casts no shadow: it sees the sunlit plane alone.
        addRectangle(scene, {vec3(-0.1f, 1, -0.1f), vec3(0.2f, 0, 0), vec3(0, 0, 0.2f)}, grey, kPage,
                     {vec2(1), vec2(5)});
        scene.objects.back().castShadows = false;
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 10.0f, LightMode::Mixed));
        scene.lights[0].indirectMultiplier = multiplier;
        IntegrationSettings settings = transport();
        settings.samples = 256;
        settings.bounces = 1;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        for (const IrradianceEstimate& e : bench.irradiance())
            EXPECT_NEAR(e.irradiance.x, 0.4f * 10.0f * multiplier, 0.02f);
    }
}

/// Irradiance under the corner of a parallel rectangle a x b at height c (Howell, "A Catalog of Radiation Heat Transfer
/// Configuration Factors", B-3), here a light centred above the texel: four such corners.
TEST_P(EmitterS6, RectangleLightMatchesItsFormFactor)
{
    const float radiance = 5.0f;
    for (const float height : {0.2f, 1.0f, 4.0f}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0));
        const int lamp = addMaterial(scene, vec3(0), vec3(radiance));
        addRectangle(scene, {vec3(-0.005f, 0, 0.005f), vec3(0.01f, 0, 0), vec3(0, 0, -0.01f)}, black, kPage,
                     {vec2(1), vec2(9)});
        addRectangle(scene, {vec3(-0.75f, height, -0.5f), vec3(1.5f, 0, 0), vec3(0, 0, 1.0f)}, lamp, kPage);
        IntegrationSettings settings = transport();
        settings.samples = 1024;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const double x = 0.75 / height;
        const double y = 0.5 / height;
        const double corner = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                               y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
                              (2.0 * kPi);
        const double expected = kPi * radiance * 4.0 * corner;
        const Statistics s = compare(bench.irradiance(), expected);
        EXPECT_NEAR(s.mean, expected, 0.01 * expected) << "height " << height;
        EXPECT_LT(s.worst, 0.05) << "height " << height;
    }
}

/// A lamp whose object casts no shadow still lights; one whose material has holes lights by what is left of it.
TEST_P(EmitterS6, UnseenAndTransparentLampsLightRight)
{
    const auto irradianceUnder = [&](bool castShadows, Material::AlphaMode alphaMode, float alpha) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0));
        const int lamp = addMaterial(scene, vec3(0), vec3(10.0f));
        scene.materials[std::size_t(lamp)].alphaMode = alphaMode;
        scene.materials[std::size_t(lamp)].baseColor.w = alpha;
        addRectangle(scene, {vec3(-0.005f, 0, 0.005f), vec3(0.01f, 0, 0), vec3(0, 0, -0.01f)}, black, kPage,
                     {vec2(1), vec2(9)});
        addRectangle(scene, {vec3(-2, 0.5f, -2), vec3(4, 0, 0), vec3(0, 0, 4)}, lamp, kPage);
        scene.objects.back().castShadows = castShadows;
        IntegrationSettings settings = transport();
        settings.samples = 1024;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        return compare(bench.irradiance(), 1.0).mean;
    };
    const double full = irradianceUnder(true, Material::AlphaMode::Opaque, 1.0f);
    EXPECT_GT(full, 25.0);
    EXPECT_NEAR(irradianceUnder(false, Material::AlphaMode::Opaque, 1.0f), full, 0.03 * full);
    EXPECT_EQ(irradianceUnder(true, Material::AlphaMode::Mask, 0.2f), 0.0);
    EXPECT_NEAR(irradianceUnder(true, Material::AlphaMode::Mask, 0.8f), full, 0.01 * full);
    EXPECT_NEAR(irradianceUnder(true, Material::AlphaMode::Blend, 0.2f), 0.2 * full, 0.02 * full);
}

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
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const float arrives = 0.7f * 0.9f * 0.8f;
        const float cosine = 1.0f / std::sqrt(1.0f + 0.3f * 0.3f + 0.2f * 0.2f);
        for (const IrradianceEstimate& e : bench.irradiance()) {
            if (mode == LightMode::Baked) EXPECT_NEAR(e.irradiance.x, 10.0f * cosine * arrives, 0.005f * 10.0f);
        }
        if (mode == LightMode::Baked) continue;
        const uint64_t before = bench.integrator->raysTraced();
        for (const vec4 m : bench.shadowmask()) EXPECT_NEAR(m.x, arrives, 0.005f);
        // Few rays tell, as where all is lit.
        EXPECT_LT(double(bench.integrator->raysTraced() - before), 8.5 * double(bench.map.texels.size()));
        const vec3 position(0.0f, 0.2f, 0.0f);
        const uint32_t which = 0;
        ProbeEstimate probe;
        bench.integrator->probes(std::span(&position, 1), std::span(&which, 1), 64, std::span(&probe, 1), {});
        EXPECT_NEAR(probe.occlusion.x, arrives, 1.0e-4f);
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
        bench.integrator->probes(std::vector<vec3>{vec3(0.2f, 0.5f, 0.1f)}, std::vector<uint32_t>{0}, 0, probe, {});
        EXPECT_EQ(probe[0].occlusion.x, casts ? 0.0f : 1.0f);
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

/// An open plane under a uniform sky receives pi times its radiance.
TEST_P(SkyS6, UniformSkyGivesPi)
{
    Scene scene;
    scene.sky = {vec3(1.5f), vec3(1.5f), vec3(1.5f)};
    addRectangle(scene, {}, addMaterial(scene, vec3(0.7f)), kPage, {vec2(1), vec2(9)});
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    for (const IrradianceEstimate& e : bench.irradiance()) EXPECT_NEAR(e.irradiance.x, 1.5f * kPi, 1e-4f);
}

vec3 irradianceFromSh(const SphericalHarmonicsL2& sh, vec3 n)
{
    vec3 sum(0.0f);
    for (int i = 0; i < 9; ++i) sum += sh[std::size_t(i)] * shading::shIrradianceWeight(i, n);
    return sum;
}

ProbeEstimate probeAt(Scene scene, vec3 position, int samples, MixedLightingMode mode = MixedLightingMode::Shadowmask)
{
    IntegrationSettings settings;
    settings.probeSamples = samples;
    settings.shadowSamples = 1024;
    Bench bench(std::move(scene), mode, kPage, settings);
    std::vector<ProbeEstimate> out(1);
    bench.integrator->probes(std::vector<vec3>{position}, std::vector<uint32_t>{0}, 0, out, {});
    return out[0];
}

/// Sky radiance 1: the constant coefficient is sqrt(4 pi), all others 0. Sky radiance 1 + y: the y coefficient is
/// sqrt(4 pi / 3) as well, and irradiance upward is pi + 2 pi / 3.
/// An even sky's mean direction is 2/3 of the normal; a distant light's is its own; a mixture's is between them, by
/// irradiance.
TEST(DirectionalS32, MomentsOfSkyAndSun)
{
    const vec3 toSun = glm::normalize(vec3(2, 1, 1));
    for (const auto& [lux, nits] : {std::pair(0.0f, 2.0f), {5.0f, 0.0f}, {5.0f, 2.0f}}) {
        for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
            Scene scene;
            addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(1), vec2(9)});
            scene.sky = {vec3(nits), vec3(nits), vec3(nits)};
            if (lux > 0.0f)
                scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -toSun, lux, LightMode::Baked));
            IntegrationSettings settings;
            settings.samples = 1024;
            settings.integrator = kind;
            Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
            const vec3 expected = kPi * nits * (2.0f / 3.0f) * vec3(0, 1, 0) + lux * toSun.y * toSun;
            const auto estimates = bench.irradiance();
            const float irradiance = kPi * nits + lux * toSun.y;
            EXPECT_LT(glm::distance(estimates[20].moment, expected), 0.01f * irradiance) << lux << ' ' << nits;
            // The page's colour, decoded, is their quotient.
            const ImageRgb32f light(1, 1, estimates[20].irradiance);
            const ImageRgb32f moment(1, 1, estimates[20].moment);
            const u8vec4 texel = encodeDirections({light}, {moment})[0](0, 0);
            EXPECT_LT(glm::distance(vec3(texel) / 127.5f - 1.0f, expected / irradiance), 0.02f);
        }
    }
}

/// An emissive panel that the gather samples directly counts from where it hangs.
TEST(DirectionalS32, MomentOfAPanelPointsAtIt)
{
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        Scene scene;
        addRectangle(scene, {vec3(0), vec3(0.1f, 0, 0), vec3(0, 0, -0.1f)}, addMaterial(scene, vec3(0)), kPage,
                     {vec2(1), vec2(4)});
        const vec3 center(3, 2, 0);
        const vec3 facing = glm::normalize(-center);
        const vec3 across = glm::normalize(glm::cross(facing, vec3(0, 0, 1)));
        addRectangle(scene, {center - 0.05f * (across + vec3(0, 0, 1)), 0.1f * across, vec3(0, 0, 0.1f)},
                     addMaterial(scene, vec3(0), vec3(1000), true), kPage);
        IntegrationSettings settings;
        settings.samples = 256;
        settings.integrator = kind;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        for (const IrradianceEstimate& e : bench.irradiance()) {
            ASSERT_GT(e.irradiance.x, 0.0f);
            EXPECT_LT(glm::distance(e.moment / luminance(e.irradiance), glm::normalize(center)), 0.05f);
        }
    }
}

TEST(ProbeS14, ConstantAndCosineSky)
{
    Scene constant;
    constant.sky = {vec3(1), vec3(1), vec3(1)};
    const ProbeEstimate a = probeAt(constant, vec3(0), 4096);
    EXPECT_NEAR(a.radiance[0].x, std::sqrt(4.0f * kPi), 0.01f);
    for (std::size_t i = 1; i < 9; ++i) EXPECT_NEAR(a.radiance[i].x, 0.0f, 0.02f) << i;
    EXPECT_NEAR(irradianceFromSh(a.radiance, vec3(0, 1, 0)).x, kPi, 0.02f);

    Scene cosine;
    cosine.sky = {vec3(2), vec3(1), vec3(0)};
    const ProbeEstimate b = probeAt(cosine, vec3(0), 4096);
    EXPECT_NEAR(b.radiance[0].x, std::sqrt(4.0f * kPi), 0.01f);
    EXPECT_NEAR(b.radiance[1].x, std::sqrt(4.0f * kPi / 3.0f), 0.01f);
    for (std::size_t i = 2; i < 9; ++i) EXPECT_NEAR(b.radiance[i].x, 0.0f, 0.02f) << i;
    EXPECT_NEAR(irradianceFromSh(b.radiance, vec3(0, 1, 0)).x, kPi + 2.0f * kPi / 3.0f, 0.03f);
    EXPECT_NEAR(irradianceFromSh(b.radiance, vec3(0, -1, 0)).x, kPi - 2.0f * kPi / 3.0f, 0.03f);
}

/// A fully baked light in the probe: a delta in direction. Towards it, an L2 irradiance is 17/16 of the light's
/// (1/4 + 1/2 + 5/16 from the bands).
TEST(ProbeS10, FullyBakedLightIsInTheProbes)
{
    Scene scene;
    scene.lights.push_back(makeLight(LightType::Point, vec3(0, 2, 0), vec3(0, -1, 0), 8.0f, LightMode::Baked));
    EXPECT_NEAR(irradianceFromSh(probeAt(scene, vec3(0), 64).radiance, vec3(0, 1, 0)).x, 2.0f * 17.0f / 16.0f, 1e-3f);
    scene.lights[0].mode = LightMode::Mixed;
    EXPECT_EQ(irradianceFromSh(probeAt(scene, vec3(0), 64).radiance, vec3(0, 1, 0)).x, 0.0f);
}

/// A disc of radius r at distance a hides part of a light of radius R at distance d: what is left is
/// 1 - (r d / (a R))^2. Here the disc is a fine fan.
TEST(ProbeS14, OcclusionUnderADisc)
{
    for (const float discRadius : {0.0f, 0.05f, 0.1f, 0.2f}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0), vec3(0), true);
        if (discRadius > 0.0f) {
            MeshPart part;
            part.positions = {vec3(0, 1, 0)};
            constexpr int kSides = 256;
            for (int i = 0; i < kSides; ++i) {
                const float angle = 2.0f * kPi * float(i) / kSides;
                part.positions.push_back(vec3(discRadius * std::cos(angle), 1, discRadius * std::sin(angle)));
                part.indices.insert(part.indices.end(), {0u, uint32_t(1 + (i + 1) % kSides), uint32_t(1 + i)});
            }
            part.normals.assign(part.positions.size(), vec3(0, 1, 0));
            part.material = black;
            addObject(scene, std::move(part));
        }
        scene.lights.push_back(makeLight(LightType::Point, vec3(0, 4, 0), vec3(0, -1, 0), 8.0f, LightMode::Mixed));
        scene.lights[0].radiusMeters = 0.6f;
        const float ratio = discRadius * 4.0f / 0.6f;
        const ProbeEstimate e = probeAt(scene, vec3(0), 16);
        EXPECT_NEAR(e.occlusion.x, std::max(0.0f, 1.0f - ratio * ratio), 0.02f) << discRadius;
        EXPECT_EQ(e.occlusion.y, 1.0f);
        EXPECT_EQ(e.occlusion.z, 1.0f);
        EXPECT_EQ(e.occlusion.w, 1.0f);
    }
}

/// A probe inside a solid sees its back faces and is marked; outside it is not.
TEST(ProbeS14, InsideASolidIsInvalid)
{
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f)), false);
    EXPECT_FALSE(probeAt(scene, vec3(0.3f), 64).valid);
    EXPECT_TRUE(probeAt(scene, vec3(0, 1.5f, 0), 64).valid);
}

/// Floor texels under a box that stands on it are inside geometry; those beside it are not, and see the sky.
TEST_P(LeaksS6, TexelsUnderABoxAreMarked)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, grey, kPage, {vec2(0), vec2(64)});
    addBox(scene, vec3(-0.53f, -0.5f, -0.53f), vec3(0.53f, 1, 0.53f), grey, false);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const auto estimates = bench.irradiance();
    const float texel = 4.0f / 64.0f;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = glm::abs(bench.positionOf(bench.map.texels[i]));
        const float distance = std::max(p.x, p.z);
        if (distance < 0.53f - texel) EXPECT_FALSE(estimates[i].valid);
        if (distance > 0.53f + 0.5f * texel) {
            EXPECT_TRUE(estimates[i].valid);
            EXPECT_GT(estimates[i].irradiance.x, 0.4f * kPi) << "a dark rim at " << distance;
        }
    }
}

/// Solids inside solids: a texel within two of them at once is inside, though its rays may meet a front face first.
TEST_P(LeaksS6, TexelsInsideNestedSolidsAreMarked)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-0.2f, 0, 0.2f), vec3(0.4f, 0, 0), vec3(0, 0, -0.4f)}, grey, kPage, {vec2(0), vec2(64)});
    // One mesh for each box, so that each is closed.
    for (const float half : {1.0f, 0.1f}) {
        const std::size_t first = scene.meshes.size();
        const vec3 center(0, half == 1.0f ? 0.0f : 0.15f, 0);
        addBox(scene, center - half, center + half, grey, false);
        joinObjects(scene, first);
    }
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    for (const IrradianceEstimate& e : bench.irradiance()) EXPECT_FALSE(e.valid);
}

/// A room with thick walls, modelled as one hollow body: its inside is outside the solid and takes light, its walls'
/// cores do not, and what a block in it covers is still inside the block.
TEST(LeaksS6, RoomsInHollowBodiesAreLit)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addBox(scene, vec3(-2.2f, -0.2f, -2.2f), vec3(2.2f, 2.7f, 2.2f), grey, false);
    addBox(scene, vec3(-2, 0, -2), vec3(2, 2.5f, 2), grey, true);
    joinObjects(scene, 0);
    const std::size_t block = scene.meshes.size();
    addBox(scene, vec3(-0.5f, -0.1f, -0.5f), vec3(0.5f, 1, 0.5f), grey, false);
    joinObjects(scene, block);
    // Two sheets to look with: on the floor, half of it under the block, and in the wall's core.
    addRectangle(scene, {vec3(-0.5f, 0.01f, 0.4f), vec3(2, 0, 0), vec3(0, 0, -0.8f)}, grey, kPage,
                 {vec2(1), vec2(31, 15)});
    addRectangle(scene, {vec3(2.1f, 0.5f, 0.5f), vec3(0, 1, 0), vec3(0, 0, -1)}, grey, kPage,
                 {vec2(33, 1), vec2(63, 15)});
    scene.lights.push_back(makeLight(LightType::Point, vec3(1.2f, 2.0f, 0), vec3(0, -1, 0), 10.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto estimates = bench.irradiance();
    int lit = 0;
    int hidden = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = bench.positionOf(bench.map.texels[i]);
        if (p.x > 0.6f && p.x < 1.9f) {
            EXPECT_TRUE(estimates[i].valid && estimates[i].irradiance.x > 0.5f) << p.x << ' ' << p.y << ' ' << p.z;
            ++lit;
        } else if (p.x < 0.4f || p.x > 2.05f) {
            EXPECT_FALSE(estimates[i].valid) << p.x << ' ' << p.y << ' ' << p.z;
            ++hidden;
        }
    }
    EXPECT_GT(lit, 50);
    EXPECT_GT(hidden, 100);
}

/// A closed room of single-sided walls in a bright sky stays black, but for rays through the edges of triangles.
TEST_P(LeaksS6, ClosedRoomInABrightSkyStaysDark)
{
    Scene scene;
    scene.sky = {vec3(1000), vec3(1000), vec3(1000)};
    addBox(scene, vec3(-3.1f, 0, -2.7f), vec3(3.3f, 2.9f, 4.1f), addMaterial(scene, vec3(0.8f)), true, kPage);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    double sum = 0.0;
    for (const IrradianceEstimate& e : bench.irradiance()) sum += e.irradiance.x;
    EXPECT_LT(sum / double(bench.map.texels.size()), 0.001 * 1000.0 * kPi);
}

} // namespace
} // namespace halflight::test
