// Lightmaps against closed forms: furnaces, bounces, form factors, skies (spec S5, S6).

#include "bake/both_integrators.h"
#include "bake/seeds.h"

#include "halflight/shading/brdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace halflight::test::closed_forms_test {
namespace {

constexpr int kPage = 64;

/// The radiance cache's solution of all bounces ends where so much of the light is left.
constexpr double kLeftOfAllBounces = 0.002;

class FurnaceS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, FurnaceS6, kBoth, integratorName);
class IndirectS5 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, IndirectS5, kBoth, integratorName);
class EmitterS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, EmitterS6, kBoth, integratorName);
class SkyS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, SkyS6, kBoth, integratorName);

/// Every wall of a closed room reflects rho and emits Le: radiance is Le / (1 - rho) everywhere, irradiance pi times
/// that.
TEST_P(FurnaceS6, ClosedRoomReachesEmissionOverOneMinusAlbedo)
{
    for (const float albedo : {0.0f, 0.5f, 0.8f, 0.95f}) {
        Scene scene;
        const int walls = addMaterial(scene, vec3(albedo), vec3(2.0f));
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), walls, true, kPage);
        SCOPED_TRACE(testing::Message() << "albedo " << albedo);
        IntegrationSettings settings = transport();
        settings.samples = 32;
        const double expected = kPi * 2.0 / (1.0 - albedo);
        const auto bakes = bakedBySeeds({scene, settings});
        expectMean(meanIrradiance(bakes), expected, {.resolved = 0.01, .bias = kLeftOfAllBounces});
        // Long paths are noisy.
        if (albedo <= 0.8f) EXPECT_LT(compare(meanOverSeeds(bakes), expected).worst, 0.25);
    }
}

/// Without glossy bounces metals carry light on as well, as much as their lobe reflects: a texture's blue scales
/// metallic, its green roughness.
TEST_P(FurnaceS6, MetalsReflectWhatTheirLobeDoes)
{
    for (const u8vec4 texel : {u8vec4(255, 255, 255, 255), u8vec4(0, 51, 255, 255), u8vec4(0, 204, 102, 255)}) {
        Scene scene;
        const int walls = addMaterial(scene, vec3(0.8f), vec3(2.0f));
        Texture texture;
        texture.pixels = ImageRgba8(1, 1);
        texture.pixels.edit()(0, 0) = texel;
        scene.textures.push_back(std::move(texture));
        Material& material = scene.materials[std::size_t(walls)];
        material.metallic = 1.0f;
        material.roughness = 0.5f;
        material.metallicRoughnessTexture.texture = 0;
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), walls, true, kPage);
        IntegrationSettings settings = transport();
        settings.glossyBounces = false;
        settings.samples = 32;
        const float metallic = float(texel.z) / 255.0f;
        const float roughness = 0.5f * float(texel.y) / 255.0f;
        const float lobe = shading::averageSpecular(vec3(0.8f), 1.0f, roughness).x;
        const double expected = kPi * 2.0 / (1.0 - (metallic * lobe + (1.0f - metallic) * 0.8f));
        SCOPED_TRACE(testing::Message() << metallic << " " << roughness);
        const SeedMean found = meanIrradiance(bakedBySeeds({scene, settings}));
        expectMean(found, expected, {.resolved = 0.01, .bias = kLeftOfAllBounces});
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
        settings.samples = 32;
        settings.bounces = bounces;
        SCOPED_TRACE(testing::Message() << bounces << " bounces");
        const double expected = kPi * (1.0 - std::pow(0.5, bounces + 1)) / 0.5;
        expectMean(meanIrradiance(bakedBySeeds({scene, settings})), expected, {.resolved = 0.01});
    }
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
        settings.samples = 128;
        const double x = 0.75 / height;
        const double y = 0.5 / height;
        const double corner = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                               y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
                              (2.0 * kPi);
        const double expected = kPi * radiance * 4.0 * corner;
        SCOPED_TRACE(testing::Message() << "height " << height);
        const auto bakes = bakedBySeeds({scene, settings});
        expectMean(meanIrradiance(bakes), expected, {.resolved = 0.01});
        EXPECT_LT(compare(meanOverSeeds(bakes), expected).worst, 0.05);
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
        settings.samples = 512;
        return meanIrradiance(bakedBySeeds({scene, settings}));
    };
    const SeedMean full = irradianceUnder(true, Material::AlphaMode::Opaque, 1.0f);
    EXPECT_GT(full.mean, 25.0);
    expectSameMean(irradianceUnder(false, Material::AlphaMode::Opaque, 1.0f), full, {.resolved = 0.02});
    EXPECT_EQ(irradianceUnder(true, Material::AlphaMode::Mask, 0.2f).mean, 0.0);
    expectSameMean(irradianceUnder(true, Material::AlphaMode::Mask, 0.8f), full, {.resolved = 0.01});
    expectSameMean(irradianceUnder(true, Material::AlphaMode::Blend, 0.2f), full * 0.2, {.resolved = 0.02});
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

} // namespace
} // namespace halflight::test::closed_forms_test
