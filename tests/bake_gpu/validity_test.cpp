// The sample points that a device finds outside geometry are those that the processor finds (spec S6): Embree is the
// truth.

#include "bake/geometry/balls.h"
#include "bake_gpu/glass_court.h"
#include "bake_gpu/test_device.h"

#include <algorithm>
#include <atomic>
#include <bit>

namespace halflight::test::device_validity_test {
namespace {

constexpr int kSmallPage = 128;

/// Balls that the floor cuts, turned, stretched and mirrored; a shell and a solid that go through it, turned, so that
/// their sides cut texels.
Scene cutFloor(bool anySolid, bool clearBalls = false)
{
    Scene scene = balls::ballsOnFloor();
    if (clearBalls) scene.materials[1] = scene.materials[std::size_t(addClearGlass(scene))];
    if (!anySolid) scene.objects.resize(1);
    for (std::size_t i = 1; i < scene.objects.size(); ++i)
        scene.objects[i].worldFromObject =
            glm::translate(mat4(1.0f), vec3(0.03f * float(i), -0.6f, 0.0f)) * scene.objects[i].worldFromObject;
    const int grey = addMaterial(scene, vec3(0.5f));
    const mat4 turn = glm::rotate(mat4(1.0f), 0.4f, vec3(0, 1, 0));
    const auto addTurnedBox = [&](vec3 middle, bool joined) {
        const std::size_t first = scene.objects.size();
        const std::size_t firstMesh = scene.meshes.size();
        addBox(scene, vec3(-0.33f, -0.4f, -0.27f), vec3(0.33f, 0.5f, 0.27f), grey, false);
        if (joined) {
            for (std::size_t i = firstMesh + 1; i < scene.meshes.size(); ++i)
                scene.meshes[firstMesh].parts.push_back(scene.meshes[i].parts[0]);
            scene.meshes.resize(firstMesh + 1);
            scene.objects.resize(first + 1);
        }
        for (std::size_t i = first; i < scene.objects.size(); ++i)
            scene.objects[i].worldFromObject = glm::translate(mat4(1.0f), middle) * turn;
    };
    for (const float x : {-3.3f, -2.5f, -1.0f, 0.2f}) addTurnedBox(vec3(x, 0, 0.5f * x + 1.0f), false);
    if (anySolid) addTurnedBox(vec3(1.2f, 0, 0.1f), true);
    return scene;
}

std::vector<PointMask> masksOn(const IntegratorFactory& factory, const Scene& scene, uint64_t& rays)
{
    const Bench bench(scene, MixedLightingMode::Shadowmask, kSmallPage, {}, 1, factory);
    rays = bench.integrator->raysTraced();
    std::vector<PointMask> masks;
    for (const Texel& texel : bench.map.texels) masks.push_back(texel.validPoints);
    return masks;
}

class DeviceValidityS6 : public BakeDeviceTest {};

/// Both trace the same rays. One along an edge decides otherwise by rounding.
void expectSamePoints(const std::shared_ptr<BakeDevice>& device, bool glass)
{
    for (const bool anySolid : {true, false}) {
        const Scene scene = cutFloor(anySolid, glass);
        uint64_t raysOfCpu = 0;
        uint64_t raysOfGpu = 0;
        const std::vector<PointMask> a = masksOn(embreeIntegrators(), scene, raysOfCpu);
        const std::vector<PointMask> b = masksOn(gpuIntegrators(device), scene, raysOfGpu);
        ASSERT_EQ(a.size(), b.size());
        std::size_t invalid = 0;
        std::size_t partly = 0;
        std::size_t other = 0;
        int points = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            invalid += a[i] == 0 ? 1 : 0;
            partly += a[i] != 0 && a[i] != kAllPoints ? 1 : 0;
            other += a[i] != b[i] ? 1 : 0;
            points += std::popcount(PointMask(a[i] ^ b[i]));
        }
        EXPECT_GT(invalid, a.size() / 100);
        EXPECT_GT(partly, a.size() / 200);
        EXPECT_LE(other, a.size() / 500) << points << " points, any solid " << anySolid;
        EXPECT_NEAR(double(raysOfGpu), double(raysOfCpu), 0.01 * double(raysOfCpu));
    }
}

TEST_F(DeviceValidityS6, PointsAreTheProcessors)
{
    expectSamePoints(device, false);
}

using DeviceValidityS35 = BakeDeviceTest;

/// Boxes among balls of glass that all rays pass.
TEST_F(DeviceValidityS35, PointsBesideColoredGlassAreTheProcessors)
{
    expectSamePoints(device, true);
}

/// The list of texels is in another order each time, and its masks are the same.
TEST_F(DeviceValidityS6, BytesRepeat)
{
    const Scene scene = cutFloor(true);
    uint64_t rays = 0;
    uint64_t raysAgain = 0;
    EXPECT_EQ(masksOn(gpuIntegrators(device), scene, rays), masksOn(gpuIntegrators(device), scene, raysAgain));
    EXPECT_EQ(rays, raysAgain);
}

TEST_F(DeviceValidityS6, FaultsAreErrors)
{
    std::atomic<int> left = -1; // calls until one fails, on any thread
    const auto fails = [&] { return left-- == 0; };
    const auto failing = openBakeDevice({.name = testDeviceName(), .fails = fails});
    ASSERT_TRUE(failing) << failing.error().message;
    Bench bench(cutFloor(true), MixedLightingMode::Shadowmask, kSmallPage, {}, 1, gpuIntegrators(*failing));
    const TexelMap right = bench.map;
    waitForPipelines(**failing);
    int failed = 0;
    for (bool happened = true; happened;) {
        left = failed;
        const Status status = bench.integrator->findValidPoints(bench.map, nullptr, {});
        happened = left < 0;
        left = -1;
        EXPECT_EQ(!status, happened) << failed;
        if (!status) EXPECT_EQ(status.error().code, ErrorCode::DeviceFailed) << status.error().message;
        failed += happened ? 1 : 0;
    }
    EXPECT_GE(failed, 3);
    for (std::size_t i = 0; i < right.texels.size(); ++i)
        EXPECT_EQ(bench.map.texels[i].validPoints, right.texels[i].validPoints);
}

} // namespace
} // namespace halflight::test::device_validity_test
