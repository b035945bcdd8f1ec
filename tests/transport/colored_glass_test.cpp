// Light through coloured glass against closed forms: lightmaps, probes, the reference and single rays (spec S35).
#include "bake/both_integrators.h"
#include "bake/test_sky.h"
#include "reference/traced.h"

#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace halflight::test::colored_glass_test {
namespace {

constexpr int kPage = 16;
constexpr float kHeight = 0.5f; // of the glass above the floor, metres
constexpr float kThick = 0.2f;  // metres
const vec3 kColor(0.9f, 0.3f, 0.1f);
const vec3 kLeft(0.8f, 0.4f, 0.2f); // of white light after kDistance
constexpr float kDistance = 0.4f;
constexpr float kAlpha = 0.25f;

enum class Glass { Quad, Pane, Box, Thin };

/// Closed forms: 1 - alpha, or 96 % at each face, times the colour; in a volume c^(way / distance) (Beer's law).
vec3 expectedOf(Glass glass, float cosine)
{
    vec3 passed;
    for (int c = 0; c < 3; ++c) {
        const float volume = std::pow(kLeft[c], kThick / cosine / kDistance);
        const float face = 0.96f * kColor[c];
        passed[c] = glass == Glass::Quad   ? (1.0f - kAlpha) * kColor[c]
                    : glass == Glass::Pane ? face
                    : glass == Glass::Box  ? face * face * volume
                                           : face * volume;
    }
    return passed;
}

int addGlassMaterial(Scene& scene, Glass glass)
{
    const int number = addMaterial(scene, kColor);
    Material& m = scene.materials.back();
    if (glass == Glass::Quad) {
        m.alphaMode = Material::AlphaMode::Blend;
        m.baseColor.w = kAlpha;
        m.tinted = true;
    } else {
        m.transmission = 1.0f;
    }
    if (glass == Glass::Box || glass == Glass::Thin) {
        m.thickness = kThick;
        m.attenuationColor = kLeft;
        m.attenuationMeters = kDistance;
    }
    return number;
}

/// Wide glass above the floor.
void addGlass(Scene& scene, Glass glass, float height = kHeight, float half = 500.0f)
{
    const int material = addGlassMaterial(scene, glass);
    if (glass == Glass::Box) {
        const std::size_t first = scene.objects.size();
        addBox(scene, vec3(-half, height, -half), vec3(half, height + kThick, half), material, false);
        joinObjects(scene, first);
        return;
    }
    addRectangle(scene, {vec3(-half, height, half), vec3(2 * half, 0, 0), vec3(0, 0, -2 * half)}, material, kPage);
}

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

void expectColor(vec3 found, vec3 expected, float relative = 0.01f)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], relative * expected[c]) << "channel " << c;
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

/// Of rays in a scene.
vec3 transmittance(const Traced& traced, vec3 origin, vec3 direction, float end)
{
    return traced.paths->surfaces().transmittance(origin, glm::normalize(direction), 0.0f, end);
}

TEST(GlassRaysS35, PanesMultiplyInAnyOrder)
{
    const vec3 one = expectedOf(Glass::Quad, 1.0f);
    const vec3 expected = one * expectedOf(Glass::Pane, 1.0f) * expectedOf(Glass::Box, 1.0f);
    std::vector<std::pair<Glass, float>> panes = {{Glass::Quad, 1.0f}, {Glass::Pane, 2.0f}, {Glass::Box, 3.0f}};
    do {
        Scene scene;
        for (const auto& [glass, height] : panes) addGlass(scene, glass, height, 5.0f);
        const Traced traced(std::move(scene));
        expectColor(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), kInfinity), expected, 1e-4f);
        expectColor(transmittance(traced, vec3(0.1f, 9, 0.2f), vec3(0, -1, 0), 9.0f), expected, 1e-4f);
        // Up to between two panes.
        expectColor(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 1.5f), one, 1e-4f);
    } while (std::next_permutation(panes.begin(), panes.end()));
}

TEST(GlassRaysS35, FullyCoveredIsOpaque)
{
    Scene scene;
    addGlass(scene, Glass::Quad);
    scene.materials.back().baseColor.w = 1.0f;
    const Traced traced(std::move(scene));
    EXPECT_EQ(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 9.0f), vec3(0.0f));
    EXPECT_TRUE(traced.paths->surfaces().nearest(vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 0.0f, 9.0f).found());
}

/// What lies behind the hit gives no colour, in whichever order candidates come; chance and colour together give the
/// transmittance. Packets and single rays agree.
TEST(GlassRaysS35, HitsTakeTheColorOfTheGlassBefore)
{
    Scene scene;
    for (int i = 0; i < 12; ++i) addGlass(scene, Glass::Quad, -1.0f - 0.1f * float(i), 5.0f);
    addFloor(scene, addMaterial(scene, vec3(0.5f)));
    addGlass(scene, Glass::Quad, 1.0f, 5.0f);
    addGlass(scene, Glass::Box, 2.0f, 5.0f);
    const Traced traced(std::move(scene));
    const RayTracer& surfaces = traced.paths->surfaces();
    constexpr int kRays = 40000;
    std::vector<Ray> rays;
    Sampler sampler(1, 2, 3);
    for (int i = 0; i < kRays; ++i) {
        const vec2 at = sampler.next2() - 0.5f;
        rays.push_back({vec3(at.x, 4, at.y), 0.0f, vec3(0, -1, 0), kInfinity});
    }
    std::vector<RayHit> hits(rays.size());
    surfaces.nearest(rays, hits);
    glm::dvec3 arrives(0.0);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const RayHit alone = surfaces.nearest(rays[i].origin, rays[i].direction, 0.0f, kInfinity);
        EXPECT_NEAR(alone.distance, hits[i].distance, 1e-4f);
        EXPECT_NEAR(alone.tint.y, hits[i].tint.y, 1e-5f);
        if (std::abs(hits[i].distance - 4.0f) < 1e-3f) arrives += glm::dvec3(hits[i].tint) / double(kRays);
    }
    expectColor(vec3(arrives), expectedOf(Glass::Quad, 1.0f) * expectedOf(Glass::Box, 1.0f), 0.015f);
}

/// From within a solid to its outside, and from outside to within.
TEST(GlassRaysS35, WaysThatEndInAVolume)
{
    Scene scene;
    addGlass(scene, Glass::Box, 0.0f, 5.0f);
    const Traced traced(std::move(scene));
    for (int c = 0; c < 3; ++c) {
        const float expected = 0.96f * kColor[c] * std::pow(kLeft[c], 0.05f / kDistance);
        EXPECT_NEAR(transmittance(traced, vec3(0.1f, 0.15f, 0.3f), vec3(0, 1, 0), 9.0f)[c], expected, 1e-4f);
        EXPECT_NEAR(transmittance(traced, vec3(0.1f, 1.2f, 0.3f), vec3(0, -1, 0), 1.05f)[c], expected, 1e-4f);
    }
}

/// A thickness is in the mesh's space: it grows with the object along the surface's normal alone.
TEST(GlassRaysS35, ThicknessTakesTheObjectsScale)
{
    for (const vec3 scale : {vec3(3, 1, 2), vec3(1, 2, 1)}) {
        Scene scene;
        addGlass(scene, Glass::Thin, 1.0f, 5.0f);
        scene.objects.back().worldFromObject = glm::scale(mat4(1.0f), scale);
        const Traced traced(std::move(scene));
        const vec3 found = transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 9.0f);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], 0.96f * kColor[c] * std::pow(kLeft[c], kThick * scale.y / kDistance), 1e-4f);
    }
}

/// Alpha without `tinted` is coverage and stays grey, beside coloured glass too.
TEST(GlassRaysS35, GreyGlassStaysGrey)
{
    Scene scene;
    addGlass(scene, Glass::Quad, 1.0f, 5.0f);
    scene.materials.back().tinted = false;
    addGlass(scene, Glass::Pane, 2.0f, 5.0f);
    const Traced traced(std::move(scene));
    expectColor(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 9.0f), 0.75f * 0.96f * kColor, 1e-4f);
    EXPECT_EQ(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 1.5f), vec3(0.75f));
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

/// A mask has no colour: it takes the luminance of what passes.
TEST(GlassMasksS35, MasksHoldTheLuminance)
{
    Scene scene = floorUnder(Glass::Quad);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), kSlanted, 10.0f, LightMode::Mixed));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settingsOf(16));
    for (const vec4& mask : bench.shadowmask()) EXPECT_NEAR(mask.x, luminance(expectedOf(Glass::Quad, 1.0f)), 0.002f);
}

} // namespace
} // namespace halflight::test::colored_glass_test
