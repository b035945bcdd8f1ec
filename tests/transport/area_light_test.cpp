// Area lights in lightmaps, masks and probes against brute force, and their bounced light against that of emissive
// surfaces (spec S6, S8, S14).
#include "bake/area_light_scene.h"
#include "bake/both_integrators.h"
#include "bake/cache/cached_integrator.h"
#include "bake/geometry/indices.h"
#include "bake/lights/channels.h"
#include "bake/seeds.h"

#include "halflight/shading/sh.h"

#include <cstdio>

namespace halflight::test::area_light_test {
namespace {

constexpr int kPage = 64;

class AreaLightS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, AreaLightS6, kBoth, integratorName);

const Rectangle kFloor{vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)};

// A floor below the light, and a wall that stands below its middle, whose horizon cuts it.
TEST_P(AreaLightS6, BakedLightIsTheFormFactors)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0));
        addRectangle(scene, kFloor, black, kPage, {vec2(1), vec2(31)});
        addRectangle(scene, {vec3(0, 0, 2), vec3(0, 0, -4), vec3(0, 1, 0)}, black, kPage, {vec2(1, 33), vec2(31, 43)});
        scene.objects[0].castShadows = scene.objects[1].castShadows = false;
        scene.lights.push_back(
            areaLight(type, vec3(0, 1.5f, 0.2f), vec3(0.1f, -1, 0), vec2(1.4f, 0.8f), 10.0f, LightMode::Baked));
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
        const auto estimates = bench.irradiance();
        double worst = 0.0;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const Texel& texel = bench.map.texels[i];
            const uint32_t triangle = bench.map.fragments[texel.firstFragment].triangle;
            const double expected = irradianceByHand(bench.scene.lights[0], bench.positionOf(texel),
                                                     bench.geometry.geometricNormal(triangle));
            worst = std::max(worst, std::abs(double(estimates[i].irradiance.x) - expected) / (expected + 0.1));
        }
        std::printf("%s: off by %.2f %% at most\n", nameOf(type), 100.0 * worst);
        EXPECT_LT(worst, 0.015) << nameOf(type);
    }
}

// The range's window counts from the light's middle, and nothing arrives beyond, nor behind the light.
TEST_P(AreaLightS6, RangeAndBack)
{
    Scene scene;
    addRectangle(scene, kFloor, addMaterial(scene, vec3(0)), kPage, {vec2(1), vec2(31)});
    scene.lights.push_back(
        areaLight(LightType::Rectangle, vec3(0, 1, 0), vec3(0, -1, 0), vec2(0.5f), 10.0f, LightMode::Baked));
    scene.lights[0].rangeMeters = 2.0f;
    scene.lights.push_back(
        areaLight(LightType::Disk, vec3(0, 1, 0), vec3(0, 1, 0), vec2(0.5f), 10.0f, LightMode::Baked));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, transport());
    const auto estimates = bench.irradiance();
    int dark = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 position = bench.positionOf(bench.map.texels[i]);
        const double ratio = double(glm::distance(position, vec3(0, 1, 0))) / 2.0;
        const double window = std::max(1.0 - std::pow(ratio, 4.0), 0.0);
        const double expected = window * irradianceByHand(bench.scene.lights[0], position, vec3(0, 1, 0));
        EXPECT_NEAR(estimates[i].irradiance.x, expected, 0.01 * expected + 0.01);
        dark += estimates[i].irradiance.x == 0.0f ? 1 : 0;
    }
    EXPECT_GT(dark, 100);
}

/// A plate over half the floor, in the half plane x > 0.
Scene halfShadowed(LightType type, LightMode mode)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, kFloor, black, kPage, {vec2(1), vec2(21)});
    addRectangle(scene, {vec3(0, 0.7f, 20), vec3(20, 0, 0), vec3(0, 0, -40)}, black, kPage);
    scene.lights.push_back(areaLight(type, vec3(0.1f, 1.5f, 0), vec3(-0.2f, -1, 0.1f), vec2(1.2f, 0.7f), 10.0f, mode));
    return scene;
}
/// Whether the plate lets light from a point of the light through to a point of the floor.
bool passes(vec3 light, vec3 floor)
{
    return glm::mix(floor.x, light.x, (0.7f - floor.y) / (light.y - floor.y)) < 0.0f;
}

// The mask is the share of the unshadowed light that arrives, point by point of the penumbra; so mask times unshadowed
// light is the light with its shadow.
TEST(AreaLightS8, MaskIsTheShareOfTheLightThatArrives)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        IntegrationSettings settings;
        settings.shadowSamples = 256;
        Bench bench(halfShadowed(type, LightMode::Mixed), MixedLightingMode::Shadowmask, kPage, settings);
        const int channel = bench.scene.lights[0].baking.occlusionMaskChannel;
        ASSERT_GE(channel, 0);
        const std::vector<vec4> mask = bench.shadowmask();
        double worst = 0.0;
        double sum = 0.0;
        int penumbra = 0;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            const vec3 p = bench.positionOf(bench.map.texels[i]);
            const double all = irradianceByHand(bench.scene.lights[0], p, vec3(0, 1, 0));
            const double lit =
                irradianceByHand(bench.scene.lights[0], p, vec3(0, 1, 0), [&](vec3 light) { return passes(light, p); });
            const double off = double(mask[i][channel]) - lit / all;
            worst = std::max(worst, std::abs(off));
            if (lit <= 0.0 || lit >= all) continue;
            sum += off;
            ++penumbra;
        }
        std::printf("%s: %d texels of penumbra, off by %.3f at most, %.4f in the mean\n", nameOf(type), penumbra, worst,
                    sum / penumbra);
        EXPECT_GT(penumbra, 50);
        EXPECT_LT(worst, 0.06) << nameOf(type);
        EXPECT_NEAR(sum / penumbra, 0.0, 0.005) << nameOf(type);
    }
}

// What a fully baked light gives in a penumbra.
TEST_P(AreaLightS6, BakedLightWithItsShadow)
{
    Bench bench(halfShadowed(LightType::Rectangle, LightMode::Baked), MixedLightingMode::Shadowmask, kPage,
                transport());
    const auto estimates = bench.irradiance();
    double sum = 0.0;
    double truth = 0.0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = bench.positionOf(bench.map.texels[i]);
        const double expected =
            irradianceByHand(bench.scene.lights[0], p, vec3(0, 1, 0), [&](vec3 light) { return passes(light, p); });
        EXPECT_NEAR(estimates[i].irradiance.x, expected, 0.8) << p.x;
        sum += double(estimates[i].irradiance.x);
        truth += expected;
    }
    EXPECT_NEAR(sum / truth, 1.0, 0.005);
}

/// A box of grey walls around a light.
Scene room(bool emissive, LightType type)
{
    Scene scene;
    addBox(scene, vec3(0), vec3(3, 2, 3), addMaterial(scene, vec3(0.6f)), true, kPage);
    const Light light =
        areaLight(type, vec3(1.5f, 1.9f, 1.2f), vec3(0.3f, -1, 0), vec2(1.0f, 0.6f), 10.0f, LightMode::Baked);
    if (emissive) {
        addEmissive(scene, light);
    } else {
        scene.lights.push_back(light);
    }
    return scene;
}

double meanIrradiance(const Bench& bench, const std::vector<IrradianceEstimate>& estimates)
{
    double sum = 0.0;
    int valid = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        if (bench.map.texels[i].validPoints == 0) continue;
        sum += double(luminance(estimates[i].irradiance));
        ++valid;
    }
    return sum / valid;
}

// Direct and bounced light together are those of an emissive surface in its place.
TEST_P(AreaLightS6, BouncesAsAnEmissiveSurfaceDoes)
{
    IntegrationSettings settings = transport();
    settings.samples = 64;
    settings.bounces = 6;
    const auto bySeeds = [&](bool emissive) {
        return overSeeds([&](uint32_t seed) {
            settings.seed = seed;
            Bench bench(room(emissive, LightType::Rectangle), MixedLightingMode::Shadowmask, kPage, settings);
            return meanIrradiance(bench, bench.irradiance());
        });
    };
    expectSameMean(bySeeds(false), bySeeds(true), {.resolved = 0.01});
}

// Probes hold a baked light's radiance from its directions, and a mixed light's share that arrives.
TEST(AreaLightS14, ProbesHoldLightAndOcclusion)
{
    for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
        for (const LightMode mode : {LightMode::Baked, LightMode::Mixed}) {
            IntegrationSettings settings;
            settings.shadowSamples = 4096;
            settings.probeSamples = 16;
            Bench bench(halfShadowed(type, mode), MixedLightingMode::Shadowmask, kPage, settings);
            const Light& light = bench.scene.lights[0];
            const std::vector<vec3> positions = {vec3(-0.1f, 0.3f, 0.1f), vec3(-0.4f, 0.5f, 0), vec3(0, 3, 0)};
            std::vector<ProbeEstimate> probes(positions.size());
            const std::vector<uint32_t> indices = allIndices(positions.size());
            ASSERT_TRUE(bench.integrator->probes(positions, indices, 0, probes, {}));
            for (std::size_t i = 0; i < positions.size(); ++i) {
                std::array<double, 9> coefficients{};
                double all = 0.0;
                double lit = 0.0;
                forPieces(light, positions[i], 300, [&](vec3 point, vec3 direction, double solidAngle) {
                    const bool visible = positions[i].y > 0.7f || passes(point, positions[i]);
                    all += solidAngle;
                    lit += visible ? solidAngle : 0.0;
                    for (int c = 0; c < 9; ++c)
                        coefficients[std::size_t(c)] +=
                            visible ? solidAngle * 10.0 * double(shading::shBasis(c, direction)) : 0.0;
                });
                if (mode == LightMode::Mixed) {
                    EXPECT_NEAR(probes[i].occlusion[light.baking.occlusionMaskChannel], all > 0 ? lit / all : 1.0,
                                0.02);
                    continue;
                }
                for (std::size_t c = 0; c < 9; ++c)
                    EXPECT_NEAR(probes[i].radiance[c].x, coefficients[c], 0.03 * coefficients[0] + 0.01) << c;
            }
        }
    }
}

// Two lights back to back reach no common point, so that they share a channel; face to face they do not.
TEST(AreaLightChannelsS9, LightsReachTheirFrontAlone)
{
    for (const bool apart : {true, false}) {
        Scene scene;
        addRectangle(scene, kFloor, addMaterial(scene, vec3(0.5f)), kPage, {vec2(1), vec2(31)});
        for (const float side : {-1.0f, 1.0f}) {
            scene.lights.push_back(areaLight(LightType::Rectangle, vec3(side * 3.0f, 1, 0),
                                             vec3(apart ? side : -side, 0, 0), vec2(1.0f), 10.0f, LightMode::Mixed));
            scene.lights.back().name = side > 0.0f ? "right" : "left";
            scene.lights.back().rangeMeters = 5.0f;
        }
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        const int left = scene.lights[0].baking.occlusionMaskChannel;
        EXPECT_EQ(left == scene.lights[1].baking.occlusionMaskChannel, apart);
    }
}

} // namespace
} // namespace halflight::test::area_light_test
