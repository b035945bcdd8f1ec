// Light through coloured glass against closed forms: lightmaps, probes, the reference and single rays (spec S35).
#include "bake/both_integrators.h"
#include "bake/test_sky.h"
#include "transport/glass_scene.h"

#include "halflight/shading/reflection.h"
#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace halflight::test::colored_glass_test {
namespace {

using namespace glass;

/// A black floor of 1 x 1 m with texels, which reflects nothing.
Scene floorUnder(Glass glass)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f));
    addRectangle(scene, {vec3(-0.5f, 0, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1)}, black, kPage, {vec2(2), vec2(10)});
    addGlass(scene, glass);
    return scene;
}

void addSun(Scene& scene, vec3 direction)
{
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), direction, 10.0f, LightMode::Baked));
}

IntegrationSettings settingsOf(int samples, IntegratorKind kind = IntegratorKind::Cache)
{
    IntegrationSettings settings;
    settings.integrator = kind;
    settings.samples = samples;
    settings.bounces = 0;
    return settings;
}

vec3 meanOf(const std::vector<IrradianceEstimate>& estimates)
{
    vec3 sum(0.0f);
    float count = 0.0f;
    for (const IrradianceEstimate& e : estimates) {
        if (!e.valid) continue;
        sum += e.irradiance;
        count += 1.0f;
    }
    return sum / count;
}

vec3 bakedMean(Scene scene, const IntegrationSettings& settings)
{
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    return meanOf(bench.irradiance());
}

const vec3 kSlanted = glm::normalize(vec3(0.5f, -1.0f, 0.3f));

std::string glassName(const testing::TestParamInfo<Glass>& info)
{
    constexpr std::array<const char*, 4> kNames = {"Quad", "Pane", "Box", "Thin"};
    return kNames[std::size_t(info.param)];
}
class ColoredGlassS35 : public testing::TestWithParam<Glass> {};
INSTANTIATE_TEST_SUITE_P(Transport, ColoredGlassS35, testing::Values(Glass::Quad, Glass::Pane, Glass::Box, Glass::Thin),
                         glassName);

TEST_P(ColoredGlassS35, SunInLightmap)
{
    for (const vec3 direction : {vec3(0, -1, 0), kSlanted}) {
        Scene scene = floorUnder(GetParam());
        addSun(scene, direction);
        expectColor(bakedMean(std::move(scene), settingsOf(16)),
                    10.0f * -direction.y * expectedOf(GetParam(), -direction.y));
    }
}

TEST_P(ColoredGlassS35, SunInProbe)
{
    Scene scene = floorUnder(GetParam());
    addSun(scene, kSlanted);
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settingsOf(16));
    const std::vector<vec3> places = {vec3(0, 0.25f, 0)};
    const std::vector<uint32_t> which = {0};
    std::vector<ProbeEstimate> out(1);
    ASSERT_TRUE(bench.integrator->probes(places, which, 64, out, {}));
    const vec3 illuminance = 10.0f * expectedOf(GetParam(), -kSlanted.y);
    expectColor(out[0].radiance[0], illuminance * shading::shBasis(0, -kSlanted));
}

/// What a reflection probe sees of a white sky.
TEST_P(ColoredGlassS35, SkyInReflectionProbe)
{
    Scene scene = floorUnder(GetParam());
    scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settingsOf(16));
    const std::vector<ImageRgb32f> pages(1, ImageRgb32f(kPage, kPage));
    ImageRgb32f map(16, 16);
    ASSERT_TRUE(bench.integrator->radianceAround(vec3(0, 0.25f, 0), pages, 4096, map, {}));
    vec3 found(0.0f);
    vec3 expected(0.0f);
    for (int i = 0; i < 16 * 16; ++i) {
        const ivec2 texel(i % 16, i / 16);
        const float cosine = shading::directionFromOctahedron((vec2(texel) + 0.5f) / 16.0f).y;
        if (cosine < 0.7f) continue;
        found += map(texel.x, texel.y);
        expected += expectedOf(GetParam(), cosine);
    }
    expectColor(found, expected);
}

TEST_P(ColoredGlassS35, SunInReference)
{
    Scene scene;
    addFloor(scene, addMaterial(scene, vec3(0.5f)));
    addGlass(scene, GetParam());
    addSun(scene, kSlanted);
    const Traced traced(std::move(scene));
    const vec3 expected = 0.5f / kPi * 10.0f * -kSlanted.y * expectedOf(GetParam(), -kSlanted.y);
    expectColor(traced.radiance(vec3(0.1f, 0.3f, 0.2f), vec3(0.1f, -1, 0), 1), expected);
}

/// Mean of f over the hemisphere, cosine-weighted.
template<typename F> vec3 cosineMean(const F& f)
{
    constexpr int kSteps = 4096;
    vec3 sum(0.0f);
    for (int i = 0; i < kSteps; ++i) {
        const float cosine = (float(i) + 0.5f) / float(kSteps);
        sum += 2.0f * cosine * f(cosine) / float(kSteps);
    }
    return sum;
}

TEST_P(ColoredGlassS35, SkyInLightmapAndReference)
{
    const vec3 passed = cosineMean([&](float cosine) { return expectedOf(GetParam(), cosine); });
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        Scene scene = floorUnder(GetParam());
        scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
        expectColor(bakedMean(std::move(scene), settingsOf(1024, kind)), kPi * passed);
    }
    Scene scene;
    addFloor(scene, addMaterial(scene, vec3(0.5f)));
    addGlass(scene, GetParam());
    scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const Traced traced(std::move(scene));
    expectColor(traced.radiance(vec3(0.1f, 0.3f, 0.2f), vec3(0.1f, -1, 0), 40000), 0.5f * passed);
}

/// A bright disc in a picture of a sky, which receivers sample.
TEST_P(ColoredGlassS35, BrightSkyInLightmap)
{
    const auto bake = [](Scene scene) {
        scene.sky = skyOf(sunPicture(256, vec3(0, 1, 0), 0.1f, 10000.0f));
        return bakedMean(std::move(scene), settingsOf(256));
    };
    Scene open = floorUnder(GetParam());
    open.objects.resize(1);
    expectColor(bake(floorUnder(GetParam())), bake(std::move(open)) * expectedOf(GetParam(), 0.9975f), 0.015f);
}

/// A square of light above the glass, against the integral over its points.
TEST_P(ColoredGlassS35, EmissiveSurfaceInLightmap)
{
    constexpr float kLampHeight = 2.0f;
    vec3 expected(0.0f);
    constexpr int kSteps = 24;
    for (int i = 0; i < kSteps * kSteps * 64; ++i) { // points of the lamp, by 8 x 8 texels of the floor
        const vec2 lamp = (vec2(i % kSteps, i / kSteps % kSteps) + 0.5f) / float(kSteps) - 0.5f;
        const int texel = i / (kSteps * kSteps);
        const vec2 floor = (vec2(texel % 8, texel / 8) + 0.5f) / 8.0f - 0.5f;
        const float distance2 = glm::dot(lamp - floor, lamp - floor) + kLampHeight * kLampHeight;
        const float cosine = kLampHeight / std::sqrt(distance2);
        expected += expectedOf(GetParam(), cosine) * (5.0f * cosine * cosine / distance2);
    }
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        Scene scene = floorUnder(GetParam());
        const int lamp = addMaterial(scene, vec3(0.0f), vec3(5.0f));
        addRectangle(scene, {vec3(-0.5f, kLampHeight, -0.5f), vec3(1, 0, 0), vec3(0, 0, 1)}, lamp, kPage);
        expectColor(bakedMean(std::move(scene), settingsOf(512, kind)), expected / float(kSteps * kSteps * 64));
    }
}

/// A rectangle light above the glass, in the reference: by its samples, by directions that meet it, and by both.
TEST_P(ColoredGlassS35, AreaLightInReference)
{
    for (const EmitterSampling way : {EmitterSampling::Both, EmitterSampling::Directions, EmitterSampling::Surfaces}) {
        Scene scene;
        addFloor(scene, addMaterial(scene, vec3(0.5f)));
        addGlass(scene, GetParam());
        addGlass(scene, GetParam(), 3.0f); // behind the light
        Light light = makeLight(LightType::Rectangle, vec3(0, 1.5f, 0), vec3(0, -1, 0), 10.0f, LightMode::Baked);
        light.sizeMeters = vec2(0.1f);
        scene.lights.push_back(light);
        Scene open = scene;
        open.objects.resize(1);
        ReferenceTracer::Options options;
        options.emitters = way;
        const int samples = way == EmitterSampling::Directions ? 400000 : 4000;
        const auto found = [&](Scene s) {
            return Traced(std::move(s), options).radiance(vec3(0.0f, 0.3f, 0.0f), vec3(0, -1, 0), samples);
        };
        const float relative = way == EmitterSampling::Directions ? 0.06f : 0.01f;
        expectColor(found(std::move(scene)), found(std::move(open)) * expectedOf(GetParam(), 0.9995f), relative);
    }
}

class GlassBouncesS35 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, GlassBouncesS35, kBoth, integratorName);

/// Two wide planes, rho each, one of which emits L, with glass of colour c between: the lit one has radiance
/// L / (1 - (rho c)^2), and the other receives pi c times that. Links of patches go through the glass.
TEST_P(GlassBouncesS35, PlanesWithGlassBetween)
{
    constexpr int kWide = 64;
    constexpr float kRho = 0.8f;
    Scene scene;
    const int lit = addMaterial(scene, vec3(kRho), vec3(2.0f));
    const int dark = addMaterial(scene, vec3(kRho));
    addRectangle(scene, {vec3(-50, 0, 50), vec3(100, 0, 0), vec3(0, 0, -100)}, dark, kWide, {vec2(1), vec2(29)});
    addRectangle(scene, {vec3(-50, 1, -50), vec3(100, 0, 0), vec3(0, 0, 100)}, lit, kWide, {vec2(32), vec2(60)});
    addGlass(scene, Glass::Quad);
    scene.materials.back().baseColor.w = 0.0f;
    IntegrationSettings settings = transport();
    settings.samples = 256;
    settings.bounces = 32;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kWide, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    std::vector<IrradianceEstimate> below;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 at = bench.positionOf(bench.map.texels[i]);
        if (at.y < 0.5f && std::max(std::abs(at.x), std::abs(at.z)) < 20.0f) below.push_back(estimates[i]);
    }
    const vec3 expected = kPi * 2.0f * kColor / (1.0f - kRho * kRho * kColor * kColor);
    expectColor(meanOf(below), expected, 0.015f);
}

/// A mask of one channel has no colour: it takes the luminance of what passes.
TEST(GlassMasksS35, GreyMasksHoldTheLuminance)
{
    Scene scene = floorUnder(Glass::Quad);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), kSlanted, 10.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settingsOf(16));
    for (const vec4& mask : bench.shadowmask()) EXPECT_NEAR(mask.x, luminance(expectedOf(Glass::Quad, 1.0f)), 0.002f);
}

} // namespace
} // namespace halflight::test::colored_glass_test
