// The radiosity passes on a device find the occluders, links and light that they find on the processor (spec S6):
// Embree and the processor's estimators are the truth. Both take the same samples.

#include "bake/geometry/balls.h"
#include "bake/test_room.h"
#include "bake/test_sky.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "bake_gpu/glass_court.h"
#include "bake_gpu/kernels.h"
#include "bake_gpu/radiosity_pair.h"
#include "bake_gpu/test_device.h"
#include "transport/radiosity/build.h"
#include "transport/radiosity/device_passes.h"
#include "transport/radiosity/split_patches.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iostream>
#include <numeric>

namespace halflight::test::device_radiosity_test {
namespace {

constexpr std::size_t kAll = ~std::size_t(0);

IntegrationSettings settingsOf(bool glossy = true, int samples = 32)
{
    IntegrationSettings settings;
    settings.samples = samples;
    settings.glossyBounces = glossy;
    return settings;
}

/// Rays along edges decide otherwise by rounding, and so do numbers at the border of a choice.
void expectSame(const BothPasses& passes, const char* name)
{
    const Differences& d = passes.differences();
    std::cout << "    " << name << ": " << d.otherOccluded << " of " << d.occluded << " occluded patches, "
              << d.otherLinks << " of " << d.links << " links, " << d.otherSamples << " of " << d.samples << " and "
              << d.otherParts << " of " << d.parts << " sums of components differ, light by "
              << 100.0 * d.lightDifference / d.light << " %, rays " << d.raysOfCpu << " and " << d.raysOfGpu << "\n";
    EXPECT_GT(d.links, 1000u);
    EXPECT_GT(d.light, 0.0);
    EXPECT_LE(d.otherOccluded, std::max<std::size_t>(d.occluded / 200, 2));
    EXPECT_LE(d.otherLinks, d.links / 500);
    EXPECT_LE(d.otherTints, d.tints / 100);
    EXPECT_LE(d.otherSamples, d.samples / 100);
    EXPECT_LT(std::abs(d.lightDifference), 1.0e-3 * d.light);
    EXPECT_NEAR(double(d.raysOfGpu), double(d.raysOfCpu), 1.0e-3 * double(d.raysOfCpu));
}

/// A thin wall that stands on the floor, seen from both sides, and small leaves without a lightmap.
Scene roomWithWallAndLeaves(bool lamp, bool sun, bool sky)
{
    Scene scene = room(lamp, sun, sky);
    const int gloss = addMaterial(scene, vec3(0.7f, 0.5f, 0.3f), vec3(0.0f), true);
    scene.materials[std::size_t(gloss)].metallic = 0.5f;
    scene.materials[std::size_t(gloss)].roughness = 0.4f;
    scene.materials[std::size_t(gloss)].specular = 1.0f;
    addRectangle(scene, {vec3(-0.83f, -0.1f, 0.71f), vec3(1.1f, 0, -0.37f), vec3(0, 0.9f, 0)}, gloss, 64,
                 {vec2(2, 47), vec2(20, 62)});
    addRectangle(scene, {vec3(-0.7f, 1.1f, -0.7f), vec3(0.4f, 0.1f, 0), vec3(0, 0.1f, 0.4f)}, gloss, 64, {}, 6);
    return scene;
}

using DeviceRadiosityS6 = BakeDeviceTest;

TEST_F(DeviceRadiosityS6, AllPassesAreTheProcessors)
{
    for (const bool lamp : {false, true}) {
        BothPasses passes(roomWithWallAndLeaves(lamp, !lamp, true), 64, settingsOf(), device);
        passes.run(kAll);
        for (const PassKind kind : {PassKind::Fronts, PassKind::Elements, PassKind::Backs, PassKind::Triangles})
            EXPECT_GT(passes.itemsOf(kind), 20u) << int(kind);
        expectSame(passes, lamp ? "lamp and sky" : "sun, point and sky");
    }
}

TEST_F(DeviceRadiosityS6, DiffuseBouncesAndManySamples)
{
    BothPasses diffuse(roomWithWallAndLeaves(true, true, false), 64, settingsOf(false), device);
    diffuse.run(kAll);
    expectSame(diffuse, "diffuse");
    BothPasses many(roomWithWallAndLeaves(false, true, true), 64, settingsOf(true, 128), device);
    many.run(600);
    expectSame(many, "many samples");
}

using DeviceRadiosityS35 = BakeDeviceTest;

/// All rays pass: chance would differ with the last bits of rays, as it does between processor and GPU.
TEST_F(DeviceRadiosityS35, LinksTakeTheColorOfGlass)
{
    Scene scene = roomWithWallAndLeaves(true, true, true);
    addRectangle(scene, {vec3(-0.2f, 0.1f, 0.9f), vec3(0.3f, 0, -1.6f), vec3(0, 1.5f, 0)}, addClearGlass(scene), 64);
    BothPasses passes(scene, 64, settingsOf(), device);
    passes.run(kAll);
    expectSame(passes, "glass");
    EXPECT_GT(passes.differences().tints, 1000u);
}

/// Light by component: a lamp in the rest, a sun, a panel, a wall that glows and a gradient whose colours are of
/// different components; then as many components as there may be, so that calls have fewer items.
TEST_F(DeviceRadiosityS6, LightOfComponentsS33)
{
    Scene scene = roomWithWallAndLeaves(true, true, true);
    IntegrationSettings settings = settingsOf();
    settings.components = {6, {1, 0}, std::vector<int>(scene.materials.size()), {3, 4, 5}};
    settings.components.ofMaterial[2] = 2;
    settings.components.ofMaterial[1] = 3;
    scene.materials[1].emissiveNits = vec3(0.5f, 0.2f, 0.1f);
    BothPasses few(scene, 64, settings, device);
    few.run(kAll);
    expectSame(few, "six components");
    EXPECT_GT(few.differences().parts, 3 * few.differences().samples);
    EXPECT_LE(few.differences().otherParts, few.differences().parts / 100);
    for (int i = 0; i < 15; ++i) { // in the plane of no face, where rounding decides whether there is light
        scene.lights.push_back(pointAt("lamp", vec3(-0.73f + 0.1f * float(i), 1.7f, 0.5f), 0.0f, 1.0f));
        settings.components.ofLight.push_back(i + 2);
    }
    settings.components.count = 17;
    settings.components.ofSky = {1, 1, 1};
    BothPasses many(scene, 64, settings, device);
    many.run(kAll);
    expectSame(many, "seventeen components");
    EXPECT_GT(many.differences().parts, 10 * many.differences().samples);
    EXPECT_LE(many.differences().otherParts, many.differences().parts / 100);
}

/// A gradient whose colours are of different components, through a pane with a colour.
TEST_F(DeviceRadiosityS35, LightOfComponentsS33)
{
    Scene scene = roomWithWallAndLeaves(true, true, true);
    addRectangle(scene, {vec3(-0.2f, 0.1f, 0.9f), vec3(0.3f, 0, -1.6f), vec3(0, 1.5f, 0)}, addClearGlass(scene), 64);
    IntegrationSettings settings = settingsOf();
    settings.components = {6, {1, 0}, std::vector<int>(scene.materials.size()), {3, 4, 5}};
    settings.components.ofMaterial[2] = 2;
    BothPasses passes(scene, 64, settings, device);
    passes.run(kAll);
    expectSame(passes, "six components and glass");
    EXPECT_LE(passes.differences().otherParts, passes.differences().parts / 100);
    EXPECT_GT(passes.differences().tints, 1000u);
}

/// Turned, stretched and mirrored instances.
TEST_F(DeviceRadiosityS6, BallsAndASunInTheSky)
{
    Scene scene = balls::ballsOnFloor();
    scene.sky = skyOf(sunPicture(64, vec3(0.4f, 1, 0.6f), 0.15f, 200.0f), 0.7f);
    BothPasses passes(scene, balls::kPage, settingsOf(), device);
    passes.run(4000);
    expectSame(passes, "balls");
}

/// So many texels that patches have four of them each.
TEST_F(DeviceRadiosityS6, PatchesOfFourTexels)
{
    constexpr int kPage = 360;
    Scene scene;
    const int gray = addMaterial(scene, vec3(0.6f));
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, gray, kPage, {vec2(1), vec2(353, 300)});
    addRectangle(scene, {vec3(-1, 1, -1), vec3(2, 0, 0), vec3(0, 0, 2)}, gray, kPage, {vec2(1, 305), vec2(353, 355)});
    addRectangle(scene, {vec3(-0.97f, -0.1f, 0.86f), vec3(0.7f, 0, 0.113f), vec3(0, 0.3f, 0)}, gray, kPage);
    addRectangle(scene, {vec3(-0.97f, -0.1f, 0.86f), vec3(0, 0.3f, 0), vec3(0.7f, 0, 0.113f)}, gray, kPage);
    scene.lights.push_back(
        makeLight(LightType::Directional, vec3(0), vec3(-0.6f, -0.8f, -0.5f), 8.0f, LightMode::Mixed));
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    BothPasses passes(scene, kPage, settingsOf(), device);
    passes.run(6000);
    expectSame(passes, "four texels");
}

/// Each call fails once.
TEST_F(DeviceRadiosityS6, FaultsAreErrors)
{
    std::atomic<int> left = -1; // calls until one fails, on any thread
    const auto fails = [&] { return left-- == 0; };
    const auto failing = openBakeDevice({.name = testDeviceName(), .fails = fails});
    ASSERT_TRUE(failing) << failing.error().message;
    IntegrationSettings settings = settingsOf();
    Bench bench(room(true, true, true), MixedLightingMode::Shadowmask, 64, settings);
    const PathTracer paths(bench.scene, bench.geometry, LightUse::Bake, Bounces::Glossy, [&](const RayScene& of) {
        return std::make_unique<GpuKernels>(*failing, of, embreeKernels()(of));
    });
    const StratifiedPattern pattern(1);
    const RadiosityInput input{paths, bench.map, pattern, settings};
    int failed = 0;
    for (bool happened = true; happened; failed += happened ? 1 : 0) {
        std::atomic<uint64_t> rays = 0;
        left = failed;
        const Result<Radiosity> result = buildRadiosity(input, {}, rays);
        happened = left < 0;
        left = -1;
        EXPECT_EQ(!result, happened) << failed;
        if (!result) EXPECT_EQ(result.error().code, ErrorCode::DeviceFailed) << result.error().message;
        if (result) EXPECT_GT(rays.load(), 10000u);
    }
    EXPECT_GT(failed, 30);
}

/// The same bits again.
TEST_F(DeviceRadiosityS6, BytesRepeat)
{
    const Scene scene = roomWithWallAndLeaves(true, true, true);
    BothPasses first(scene, 64, settingsOf(), device);
    BothPasses second(scene, 64, settingsOf(), device);
    first.run(kAll);
    second.run(kAll);
    ASSERT_GT(first.bytes().size(), 10000u);
    EXPECT_EQ(first.bytes(), second.bytes());
}

} // namespace
} // namespace halflight::test::device_radiosity_test
