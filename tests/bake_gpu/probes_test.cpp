// Light probes whose paths a device traces have the light of the processor's (specs S6 and S14). Both take the same
// samples: but for rounding, probes are the same.

#include "bake/area_light_scene.h"
#include "bake/test_sky.h"
#include "bake_gpu/glass_court.h"
#include "bake_gpu/test_device.h"
#include "transport/trace/device_paths.h"

namespace halflight::test::device_probes_test {
namespace {

using DeviceProbesS14 = BakeDeviceTest;

IntegrationSettings settingsOf(int probeSamples = 64)
{
    IntegrationSettings settings;
    settings.probeSamples = probeSamples;
    return settings;
}

/// A grid through the court: some are in the column, and some behind the walls.
std::vector<vec3> places()
{
    std::vector<vec3> positions;
    for (int z = 0; z < 6; ++z)
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 8; ++x)
                positions.emplace_back(-2.3f + 0.66f * float(x), 0.2f + 1.1f * float(y), -2.2f + 0.8f * float(z));
    return positions;
}

std::vector<ProbeEstimate> probesOn(const IntegratorFactory& factory, const Scene& scene,
                                    const IntegrationSettings& settings, const std::vector<vec3>& positions,
                                    const std::vector<uint32_t>& which)
{
    Bench bench(scene, MixedLightingMode::Shadowmask, kCourtPage, settings, 1, factory);
    std::vector<ProbeEstimate> estimates(which.size());
    EXPECT_TRUE(bench.integrator->probes(positions, which, 0, estimates, {}));
    return estimates;
}
std::vector<ProbeEstimate> probesOn(const IntegratorFactory& factory, const Scene& scene,
                                    const IntegrationSettings& settings = settingsOf())
{
    const std::vector<vec3> positions = places();
    return probesOn(factory, scene, settings, positions, allIndices(positions.size()));
}

void expectSame(const std::vector<ProbeEstimate>& cpu, const std::vector<ProbeEstimate>& gpu)
{
    ASSERT_EQ(cpu.size(), gpu.size());
    std::size_t other = 0;
    std::size_t valid = 0;
    double mean = 0.0;
    double difference = 0.0;
    for (std::size_t i = 0; i < cpu.size(); ++i) {
        EXPECT_EQ(cpu[i].valid, gpu[i].valid);
        EXPECT_EQ(cpu[i].occlusion, gpu[i].occlusion);
        valid += cpu[i].valid ? 1 : 0;
        const double light = double(luminance(cpu[i].radiance[0]));
        mean += light;
        difference += double(luminance(gpu[i].radiance[0])) - light;
        bool same = std::abs(double(gpu[i].variance - cpu[i].variance)) <= 1.0e-3 * (double(cpu[i].variance) + 1.0e-6);
        for (std::size_t c = 0; c < 9; ++c)
            same = same && double(glm::distance(cpu[i].radiance[c], gpu[i].radiance[c])) < 1.0e-3 * (light + 1.0e-3);
        other += same ? 0 : 1;
    }
    EXPECT_GT(mean, 0.01 * double(cpu.size()));
    EXPECT_LT(std::abs(difference), 1.0e-3 * mean);
    EXPECT_GT(valid, cpu.size() / 3);
    // A number that falls on the other side of a threshold by rounding makes another path.
    EXPECT_LT(other, cpu.size() / 20);
    testing::Test::RecordProperty("other", std::to_string(other) + " of " + std::to_string(cpu.size()));
}

void expectSame(const Scene& scene, const std::shared_ptr<BakeDevice>& device)
{
    expectSame(probesOn(embreeIntegrators(), scene), probesOn(gpuIntegrators(device), scene));
}

TEST_F(DeviceProbesS14, MixedAndBakedLights)
{
    Scene scene = court();
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.5f, -1, -0.4f), 4.0f));
    scene.lights.push_back(makeLight(LightType::Point, vec3(1, 1.5f, 0.5f), vec3(0, -1, 0), 2.0f, LightMode::Baked));
    scene.lights.back().radiusMeters = 0.2f;
    scene.lights.push_back(areaLight(LightType::Disk, vec3(-1, 2.6f, 0.5f), vec3(0.1f, -1, -0.3f), vec2(0.8f, 0.5f),
                                     20.0f, LightMode::Baked));
    expectSame(scene, device);
}

/// Solids: probes in them are invalid on both.
TEST_F(DeviceProbesS14, InsideASolidIsInvalid)
{
    Scene scene = court();
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    addBox(scene, vec3(-2.6f, -0.2f, -2.6f), vec3(-1.2f, 3.0f, 3.0f), addMaterial(scene, vec3(0.5f)), false);
    const auto cpu = probesOn(embreeIntegrators(), scene);
    const auto gpu = probesOn(gpuIntegrators(device), scene);
    std::size_t inside = 0;
    for (const ProbeEstimate& probe : cpu) inside += probe.valid ? 0 : 1;
    EXPECT_GT(inside, cpu.size() / 8);
    expectSame(cpu, gpu);
}

TEST_F(DeviceProbesS14, SkyWithASun)
{
    Scene scene = court();
    scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f), 0.7f);
    expectSame(scene, device);
}

/// Emitters with and without a picture, from one or both sides, and one that casts no shadow.
TEST_F(DeviceProbesS14, Emitters)
{
    Scene scene = court();
    const int picture = addMaterial(scene, vec3(0.2f), vec3(12.0f), true);
    scene.materials[std::size_t(picture)].emissiveTexture = {.texture = 0};
    addPlates(scene, picture);
    expectSame(scene, device);
}

/// The same bits again, whatever else is asked for, and of a probe with more paths than a call.
TEST_F(DeviceProbesS14, BytesRepeat)
{
    Scene scene = court();
    scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f));
    const std::vector<vec3> positions = places();
    const auto all = probesOn(gpuIntegrators(device), scene);
    const std::vector<uint32_t> which = {3, 40, 77, 78, 140};
    const auto some = probesOn(gpuIntegrators(device), scene, settingsOf(), positions, which);
    for (std::size_t i = 0; i < which.size(); ++i) EXPECT_EQ(some[i].radiance, all[which[i]].radiance);
    Scene open;
    addRectangle(open, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, addMaterial(open, vec3(0.5f)), 0);
    open.sky = {vec3(1.0f, 0.5f, 0.2f), vec3(0.6f), vec3(0.2f)};
    const IntegrationSettings many = settingsOf(int(DevicePaths::kMostPaths) + 1000);
    const auto cpu = probesOn(embreeIntegrators(), open, many, {vec3(0, 1, 0)}, {0});
    const auto gpu = probesOn(gpuIntegrators(device), open, many, {vec3(0, 1, 0)}, {0});
    for (std::size_t c = 0; c < 9; ++c)
        EXPECT_LT(glm::distance(cpu[0].radiance[c], gpu[0].radiance[c]), 1.0e-4f * cpu[0].radiance[0].x);
}

using DeviceProbesS35 = BakeDeviceTest;

TEST_F(DeviceProbesS35, LightThroughGlass)
{
    Scene scene = clearCourt();
    scene.lights.push_back(bakedLight(LightType::Directional, vec3(0), vec3(0.3f, -1, -0.2f), 4.0f));
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    expectSame(scene, device);
}

} // namespace
} // namespace halflight::test::device_probes_test
