// The final gather on a device gives the light that it gives on the processor (spec S6).

#include "bake/geometry/balls.h"
#include "bake/seeds.h"
#include "bake/test_room.h"
#include "bake_gpu/same_light.h"
#include "transport/lightmap/device_gather.h"

#include <cmath>

namespace halflight::test::gather_test {
namespace {

using GatherS6 = BakeDeviceTest;

IntegrationSettings settingsOf(uint32_t seed)
{
    IntegrationSettings settings;
    settings.samples = 48;
    settings.bounces = 4;
    settings.seed = seed;
    return settings;
}

std::vector<IrradianceEstimate> bakeOn(const IntegratorFactory& factory, const Scene& scene, uint32_t seed)
{
    return lightOn(factory, scene, 64, settingsOf(seed));
}

TEST_F(GatherS6, TexelsAreTheProcessors)
{
    for (const bool sky : {true, false}) {
        const Scene scene = room(false, true, sky);
        expectSameLight(bakeOn(embreeIntegrators(), scene, 1), bakeOn(gpuIntegrators(device), scene, 1), 1.0e-3f);
    }
}

/// Sample points of curved, turned, stretched and mirrored surfaces, and of texels that both sides of a board share.
TEST_F(GatherS6, BallsAndBoardsAreTheProcessors)
{
    expectSameLight(lightOn(embreeIntegrators(), balls::ballsOnFloor(), balls::kPage, settingsOf(1), 31),
                    lightOn(gpuIntegrators(device), balls::ballsOnFloor(), balls::kPage, settingsOf(1), 31), 1.0e-3f);
    Scene scene = room(false, true, true);
    const int paper = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    const int board = addRectangle(scene, {vec3(0.3f, 0.4f, 0.6f), vec3(0.5f, 0.4f, 0), vec3(0, 0.3f, -0.6f)}, paper,
                                   64, {vec2(1.3f, 47), vec2(14.6f, 58.2f)});
    scene.meshes[std::size_t(board)].parts[0].texelSides = {TexelSide::Mean, TexelSide::Mean};
    expectSameLight(bakeOn(embreeIntegrators(), scene, 1), bakeOn(gpuIntegrators(device), scene, 1), 1.0e-3f);
}

/// 125,000 triangles on a small page: a call has more fragments than there is room for at first.
TEST_F(GatherS6, FineMeshesAreTheProcessors)
{
    Scene scene;
    const int gray = addMaterial(scene, vec3(0.6f));
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0.3f, -2)}, gray, 64, {vec2(2), vec2(40)}, 250);
    addRectangle(scene, {vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 1.5f, 0)}, gray, 64, {vec2(42, 2), vec2(62, 20)});
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    Bench bench(scene, MixedLightingMode::Shadowmask, 64, settingsOf(1));
    ASSERT_GT(bench.map.fragments.size(), 2 * DeviceGather::kMostBlocks);
    expectSameLight(bakeOn(embreeIntegrators(), scene, 1), bakeOn(gpuIntegrators(device), scene, 1), 1.0e-3f);
}

/// Sixteen bakes on each, of other seeds: blocks of 64 neighbouring texels have the same mean light, by Student's t.
TEST_F(GatherS6, BlocksOfTexelsHaveTheSameMeanOverSeeds)
{
    constexpr int kSeedsOfEach = 16;
    constexpr std::size_t kBlock = 64; // texels are sorted by Morton code
    for (const bool lamp : {false, true}) {
        const Scene scene = room(lamp, !lamp, true);
        std::vector<std::vector<double>> differences;
        double mean = 0.0;
        double difference = 0.0;
        for (uint32_t seed = 1; seed <= kSeedsOfEach; ++seed) {
            const auto cpu = bakeOn(embreeIntegrators(), scene, seed);
            const auto gpu = bakeOn(gpuIntegrators(device), scene, seed + 1000);
            differences.resize(cpu.size() / kBlock);
            for (std::size_t b = 0; b < differences.size(); ++b) {
                double sum = 0.0;
                for (std::size_t i = b * kBlock; i < (b + 1) * kBlock; ++i) {
                    sum += double(luminance(gpu[i].irradiance) - luminance(cpu[i].irradiance));
                    mean += double(luminance(cpu[i].irradiance));
                }
                differences[b].push_back(sum);
                difference += sum;
            }
        }
        EXPECT_LT(std::abs(difference), 0.002 * mean) << "lamp " << lamp;
        for (const std::vector<double>& block : differences) {
            const SeedMean d = meanOf(block);
            // Black blocks differ by nothing.
            EXPECT_LE(std::abs(d.mean), 5.0 * d.error + 1.0e-6) << "lamp " << lamp;
        }
    }
}

/// The same bits, whether one asks for all texels or for some.
TEST_F(GatherS6, TexelsDoNotDependOnTheRequest)
{
    const Scene scene = room(false, true, true);
    const auto all = bakeOn(gpuIntegrators(device), scene, 3);
    Bench bench(scene, MixedLightingMode::Shadowmask, 64, settingsOf(3), 1, gpuIntegrators(device));
    std::vector<uint32_t> some;
    for (uint32_t i = 5; i < all.size(); i += 7) some.push_back(i);
    std::vector<IrradianceEstimate> estimates(some.size());
    ASSERT_TRUE(bench.irradiance({some}, estimates));
    for (std::size_t i = 0; i < some.size(); ++i) {
        EXPECT_EQ(estimates[i].irradiance, all[some[i]].irradiance);
        EXPECT_EQ(estimates[i].moment, all[some[i]].moment);
    }
}

} // namespace
} // namespace halflight::test::gather_test
