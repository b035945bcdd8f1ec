// Shadow rays on a device give the masks and the direct light that they give on the processor (spec S8): Embree is the
// truth.

#include "bake/geometry/balls.h"
#include "bake/test_room.h"
#include "bake_gpu/test_device.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>

namespace halflight::test::device_shadows_test {
namespace {

constexpr int kSmallPage = 64;

/// Turned, stretched and mirrored balls with smooth normals, of a shared mesh; a sun with penumbrae, lamps that share a
/// channel, a spot, and a baked lamp with a range.
Scene litBalls(Material::AlphaMode alpha)
{
    Scene scene = balls::ballsOnFloor(alpha);
    scene.sky = {};
    scene.lights[0].angularRadiusRadians = 0.03f;
    scene.lights.push_back(pointAt("left", vec3(-3, 1.6f, 0), 2.2f));
    scene.lights.push_back(pointAt("right", vec3(2.5f, 1.8f, 0.5f), 2.2f));
    scene.lights.back().radiusMeters = 0.2f;
    scene.lights.push_back(
        makeLight(LightType::Spot, vec3(0, 2.5f, 1.5f), vec3(0.1f, -1, -0.6f), 20.0f, LightMode::Mixed));
    scene.lights.back().outerConeRadians = 0.7f;
    scene.lights.push_back(pointAt("baked", vec3(-0.5f, 1.2f, 0.2f), 3.0f));
    scene.lights.back().mode = LightMode::Baked;
    scene.lights.back().radiusMeters = 0.05f;
    scene.lights.push_back(makeLight(LightType::Point, vec3(1, 3, 1), vec3(0, -1, 0), 8.0f, LightMode::Baked));
    return scene;
}

IntegrationSettings settingsOf()
{
    IntegrationSettings settings;
    settings.samples = 16;
    settings.shadowSamples = 32;
    settings.bounces = 0;
    return settings;
}

Bench benchOn(const IntegratorFactory& factory, Scene scene)
{
    return {std::move(scene), MixedLightingMode::Shadowmask, kSmallPage, settingsOf(), 1, factory};
}

/// Texels whose masks differ by more than a byte of a file holds, and the mean difference.
struct MaskDifference {
    std::size_t other = 0;
    double mean = 0.0;
};
MaskDifference compare(const std::vector<vec4>& a, const std::vector<vec4>& b)
{
    MaskDifference result;
    for (std::size_t i = 0; i < a.size(); ++i) {
        float most = 0.0f;
        for (int c = 0; c < 4; ++c) {
            most = std::max(most, std::abs(a[i][c] - b[i][c]));
            result.mean += double(b[i][c] - a[i][c]) / double(4 * a.size());
        }
        result.other += most > 1.0f / 255.0f ? 1 : 0;
    }
    return result;
}

/// Texels that are neither lit nor dark.
std::size_t partlyLit(const std::vector<vec4>& masks)
{
    return std::size_t(std::count_if(masks.begin(), masks.end(), [](vec4 m) {
        return glm::any(glm::greaterThan(m, vec4(0.1f))) && glm::any(glm::lessThan(m, vec4(0.9f)));
    }));
}

class DeviceShadowsS8 : public BakeDeviceTest {};

/// Both trace the same rays. A ray along an edge may pass on one and not on the other by rounding. Edges of holes lie
/// along edges of texels here, so that more points lie on them.
TEST_F(DeviceShadowsS8, MasksAreTheProcessors)
{
    for (const auto alpha : {Material::AlphaMode::Opaque, Material::AlphaMode::Mask, Material::AlphaMode::Blend}) {
        SCOPED_TRACE(int(alpha));
        Bench cpu = benchOn(embreeIntegrators(), litBalls(alpha));
        Bench gpu = benchOn(gpuIntegrators(device), litBalls(alpha));
        const uint64_t before = cpu.integrator->raysTraced();
        const std::vector<vec4> a = cpu.shadowmask();
        const auto raysOfCpu = double(cpu.integrator->raysTraced() - before);
        const uint64_t beforeGpu = gpu.integrator->raysTraced();
        const std::vector<vec4> b = gpu.shadowmask();
        const auto raysOfGpu = double(gpu.integrator->raysTraced() - beforeGpu);
        ASSERT_EQ(a.size(), b.size());
        EXPECT_GT(partlyLit(a), a.size() / 20);
        const MaskDifference d = compare(a, b);
        EXPECT_LE(d.other, a.size() / (alpha == Material::AlphaMode::Opaque ? 500 : 50));
        EXPECT_LT(std::abs(d.mean), 2.0e-4);
        EXPECT_NEAR(raysOfGpu, raysOfCpu, 0.005 * raysOfCpu);
    }
}

/// Area lights near enough to be sampled by solid angle, and far: rectangle and disk.
TEST_F(DeviceShadowsS8, MasksOfAreaLightsAreTheProcessors)
{
    Scene scene = balls::ballsOnFloor();
    scene.sky = {};
    scene.lights[0] = makeLight(LightType::Rectangle, vec3(-1, 1.6f, 0), vec3(0.2f, -1, 0.1f), 30.0f, LightMode::Mixed);
    scene.lights[0].sizeMeters = vec2(0.8f, 0.5f);
    scene.lights.push_back(makeLight(LightType::Disk, vec3(2, 3, -1), vec3(-0.4f, -1, 0.3f), 30.0f, LightMode::Mixed));
    scene.lights[1].sizeMeters = vec2(0.6f);
    const std::vector<vec4> a = benchOn(embreeIntegrators(), scene).shadowmask();
    const std::vector<vec4> b = benchOn(gpuIntegrators(device), scene).shadowmask();
    EXPECT_GT(partlyLit(a), a.size() / 10);
    const MaskDifference d = compare(a, b);
    EXPECT_LE(d.other, a.size() / 100);
    EXPECT_LT(std::abs(d.mean), 2.0e-4);
}

/// With and without a range, and from both sides of a sheet in one texel.
TEST_F(DeviceShadowsS8, DirectLightIsTheProcessors)
{
    Scene scene = litBalls(Material::AlphaMode::Opaque);
    const int cloth = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0.1f, 1.5f), vec3(3.5f, 0, 0), vec3(0, 1.2f, 0)}, cloth, balls::kPage,
                 {vec2(150, 2), vec2(250, 60)});
    Bench cpu = benchOn(embreeIntegrators(), scene);
    Bench gpu = benchOn(gpuIntegrators(device), scene);
    const std::vector<IrradianceEstimate> a = cpu.irradiance();
    const std::vector<IrradianceEstimate> b = gpu.irradiance();
    ASSERT_EQ(a.size(), b.size());
    std::size_t other = 0;
    double mean = 0.0;
    double difference = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(a[i].valid, b[i].valid);
        const auto light = double(luminance(a[i].direct));
        const auto off = double(luminance(b[i].direct)) - light;
        mean += light / double(a.size());
        difference += off / double(a.size());
        other += std::abs(off) > 1.0e-3 * (light + 1.0e-3) ? 1 : 0;
    }
    EXPECT_GT(mean, 0.1);
    EXPECT_LT(std::abs(difference), 1.0e-3 * mean);
    EXPECT_LE(other, a.size() / 100);
}

/// The same bits twice, and whether one asks for all texels or for some.
TEST_F(DeviceShadowsS8, BytesRepeat)
{
    const Scene scene = litBalls(Material::AlphaMode::Mask);
    const std::vector<vec4> all = benchOn(gpuIntegrators(device), scene).shadowmask();
    Bench again = benchOn(gpuIntegrators(device), scene);
    EXPECT_EQ(again.shadowmask(), all);
    std::vector<uint32_t> some;
    for (uint32_t i = 5; i < all.size(); i += 3) some.push_back(i);
    std::vector<vec4> masks(some.size());
    ASSERT_TRUE(again.integrator->shadowmask(again.map, {some}, 0, masks, {}));
    for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(masks[i], all[some[i]]);
}

/// A device that is lost between two submissions, and one that has no memory left: an error, whichever is the first to
/// fail. Without a fault the masks are those of a device that never fails.
TEST_F(DeviceShadowsS8, FaultsAreErrors)
{
    std::atomic<int> left = -1; // calls until one fails, on any thread
    const auto fails = [&] { return left-- == 0; };
    const auto failing = openBakeDevice({.name = testDeviceName(), .fails = fails});
    ASSERT_TRUE(failing) << failing.error().message;
    const Scene scene = room(false, true, false);
    const std::vector<vec4> right = benchOn(gpuIntegrators(*failing), scene).shadowmask();
    waitForPipelines(**failing);
    int failed = 0;
    for (int call = 0;; call += 2) {
        Bench bench = benchOn(gpuIntegrators(*failing), scene);
        std::vector<vec4> masks(bench.map.texels.size());
        left = call;
        const Status status = bench.integrator->shadowmask(bench.map, {allIndices(masks.size())}, 0, masks, {});
        const bool happened = left < 0;
        left = -1;
        EXPECT_EQ(!status, happened) << call;
        if (!happened) {
            EXPECT_EQ(masks, right);
            break;
        }
        ++failed;
        if (!status) EXPECT_EQ(status.error().code, ErrorCode::DeviceFailed) << status.error().message;
    }
    EXPECT_GT(failed, 10);
}

} // namespace
} // namespace halflight::test::device_shadows_test
