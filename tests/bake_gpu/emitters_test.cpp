// Samples of emitters and of the sky's bright part on a device (spec S6): the light is Lambert's, and the processor's.

#include "bake/test_room.h"
#include "bake/test_sky.h"
#include "bake_gpu/same_light.h"

#include "halflight/shading/area_light.h"

#include <cmath>

namespace halflight::test::emitters_test {
namespace {

using DeviceEmittersS6 = BakeDeviceTest;

constexpr int kPage = 64;

IntegrationSettings settingsOf(uint32_t seed = 1)
{
    IntegrationSettings settings;
    settings.samples = 48;
    settings.bounces = 4;
    settings.seed = seed;
    return settings;
}

/// Plates under the room's ceiling, each of a colour: 96 triangles, more than a texel's cut has nodes.
void addPlates(Scene& scene, float nits)
{
    constexpr int kSide = 7;
    for (int i = 0; i < kSide * kSide - 1; ++i) {
        const vec3 color(float(1 + i % 3), float(1 + i % 5), float(1 + i % 7));
        const int material = addMaterial(scene, vec3(0.0f), nits * color);
        const vec3 corner(-0.9f + 0.26f * float(i % kSide), 1.9f, -0.9f + 0.26f * float(i / kSide));
        addRectangle(scene, {corner, vec3(0.1f, 0, 0), vec3(0, 0, 0.1f)}, material, kPage);
    }
}

/// Rays of a bake on both, and the texels' light.
void expectSameRaysAndLight(const Scene& scene, const std::shared_ptr<BakeDevice>& device)
{
    const auto bakeOn = [&](const IntegratorFactory& factory, uint64_t& rays) {
        Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settingsOf(), 1, factory);
        const uint64_t before = bench.integrator->raysTraced();
        std::vector<IrradianceEstimate> light = bench.irradiance();
        rays = bench.integrator->raysTraced() - before;
        return light;
    };
    uint64_t rays = 0;
    uint64_t raysOnDevice = 0;
    const auto cpu = bakeOn(embreeIntegrators(), rays);
    const auto gpu = bakeOn(gpuIntegrators(device), raysOnDevice);
    EXPECT_NEAR(double(raysOnDevice), double(rays), 1.0e-3 * double(rays));
    expectSameLight(cpu, gpu, 1.0e-3f);
}

/// A black floor under a lamp: the irradiance of a rectangle (Lambert 1760, Photometria).
TEST_F(DeviceEmittersS6, FloorsHaveLambertsLight)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0.0f));
    constexpr float kNits = 5.0f;
    const int glow = addMaterial(scene, vec3(0.0f), vec3(kNits));
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(2), vec2(62)});
    const Rectangle lamp{vec3(-0.5f, 1.5f, -1.0f), vec3(1.2f, 0, 0), vec3(0, 0, 0.8f)};
    addRectangle(scene, lamp, glow, kPage, {}, 3);
    Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settingsOf(), 1, gpuIntegrators(device));
    const std::vector<IrradianceEstimate> light = bench.irradiance();
    double error = 0.0;
    double mean = 0.0;
    double variance = 0.0;
    for (std::size_t i = 0; i < light.size(); ++i) {
        ASSERT_TRUE(light[i].valid);
        const vec3 from = bench.positionOf(bench.map.texels[i]);
        // Up is +Z there.
        const auto seen = [&](vec3 corner) { return vec3(corner.x - from.x, from.z - corner.z, corner.y - from.y); };
        const vec3 corner = lamp.origin + lamp.edgeU + lamp.edgeV;
        const float share = shading::quadIrradiance(seen(lamp.origin), seen(lamp.origin + lamp.edgeV), seen(corner),
                                                    seen(lamp.origin + lamp.edgeU));
        const auto truth = double(kNits * share);
        EXPECT_NEAR(double(light[i].irradiance.y), truth, 0.1 * truth) << i;
        error += double(light[i].irradiance.y) - truth;
        mean += truth;
        variance += double(light[i].varianceOfMean);
    }
    EXPECT_GT(mean, 0.1 * double(light.size()));
    EXPECT_LT(std::abs(error), 4.0 * std::sqrt(variance));
    EXPECT_LT(std::abs(error), 1.0e-3 * mean);
}

TEST_F(DeviceEmittersS6, ALampsLightIsTheProcessors)
{
    expectSameRaysAndLight(room(true, false, true), device);
}

/// Many rays hit a wall that glows: their weights count.
TEST_F(DeviceEmittersS6, WideAndSmallEmitters)
{
    Scene scene = room(false, false, false);
    addPlates(scene, 0.2f);
    const int glow = addMaterial(scene, vec3(0.3f), vec3(1.0f, 0.7f, 0.4f));
    addRectangle(scene, {vec3(1, 0, -1), vec3(0, 0, 2), vec3(0, 2, 0)}, glow, kPage, {}, 6);
    expectSameRaysAndLight(scene, device);
}

/// Beside a bright sun, roulette leaves out most samples of dim plates.
TEST_F(DeviceEmittersS6, AsManySamplesBesideOtherLight)
{
    Scene scene = room(false, true, true);
    addPlates(scene, 0.1f);
    expectSameRaysAndLight(scene, device);
}

/// A sun in the sky's picture shares the samples with plates.
TEST_F(DeviceEmittersS6, SkyAndPlatesShareTheSamples)
{
    Scene scene = room(false, false, false);
    addPlates(scene, 1.0f);
    scene.sky = skyOf(sunPicture(64, vec3(0.6f, 0.8f, 0.5f), 0.15f, 200.0f), 0.2f);
    expectSameRaysAndLight(scene, device);
}

/// The same bits, whether one asks for all texels or for some.
TEST_F(DeviceEmittersS6, BytesRepeat)
{
    Scene scene = room(false, true, false);
    addPlates(scene, 0.2f);
    scene.sky = skyOf(sunPicture(64, vec3(0.6f, 0.8f, 0.5f), 0.15f, 200.0f));
    const auto all = lightOn(gpuIntegrators(device), scene, kPage, settingsOf(3));
    const auto some = lightOn(gpuIntegrators(device), scene, kPage, settingsOf(3), 7);
    for (std::size_t i = 0; i < some.size(); ++i) {
        EXPECT_EQ(some[i].irradiance, all[7 * i].irradiance);
        EXPECT_EQ(some[i].moment, all[7 * i].moment);
    }
}

} // namespace
} // namespace halflight::test::emitters_test
