// A GPU that fails at any moment of a bake: the processor bakes instead, and its bytes are those of a bake without a
// GPU (spec S6).

#include "bake/same_bakes.h"
#include "bake/test_room.h"
#include "bake/test_scene.h"
#include "bake_gpu/test_device.h"

#include "halflight/bake/bake.h"

#include <algorithm>
#include <atomic>

namespace halflight::test::faults_test {
namespace {

BakeSettings tinySettings(IntegratorKind kind = IntegratorKind::Cache)
{
    BakeSettings settings;
    settings.integrator = kind;
    settings.samples = 16;
    settings.shadowSamples = 8;
    settings.lightmapSize = 64;
    settings.bounces = 2;
    settings.probeSpacingMeters = 2.0f;
    settings.reflectionProbes = false;
    settings.probeLayout = ProbeLayout::Grid;
    return settings;
}

struct GpuFaults : testing::Test {
    /// A device that fails at the n-th time that it could; never for 0.
    Result<std::shared_ptr<BakeDevice>> deviceFailingAt(int number)
    {
        calls = 0;
        const auto fails = [this, number] { return ++calls == number; };
        return openBakeDevice({.name = testDeviceName(), .fails = fails});
    }
    void expectTheProcessorBakesInstead(const BakeSettings& settings);
    std::atomic<int> calls = 0;
};

void GpuFaults::expectTheProcessorBakesInstead(const BakeSettings& settings)
{
    const Scene scene = room(true, true, true);
    auto device = deviceFailingAt(0);
    if (!device) GTEST_SKIP() << device.error().message;
    const int opened = calls;
    const Result<BakeResult> whole = bake(scene, settings, gpuIntegrators(*device));
    ASSERT_TRUE(whole) << whole.error().text();
    EXPECT_TRUE(whole->report.identity.starts_with("gpu-")) << whole->report.identity;
    EXPECT_NE(whole->report.integrator.find("gpu"), std::string::npos) << whole->report.integrator;
    const int all = calls - opened;
    ASSERT_GT(all, 20);
    const Result<BakeResult> cpu = bake(scene, settings, embreeIntegrators());
    ASSERT_TRUE(cpu);
    constexpr int kMoments = 8;
    for (int moment = 0; moment <= kMoments; ++moment) {
        device = deviceFailingAt(opened + 1 + moment * (all - 1) / kMoments);
        ASSERT_TRUE(device) << device.error().message;
        const Result<BakeResult> result = bake(scene, settings, gpuIntegrators(*device));
        ASSERT_TRUE(result) << result.error().text();
        EXPECT_EQ(result->report.identity, cpu->report.identity) << moment;
        const auto& warnings = result->report.warnings;
        EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& w) {
            return w.starts_with("the GPU failed");
        })) << moment;
        expectSameBakes(result->baked, cpu->baked);
    }
}

TEST_F(GpuFaults, TheProcessorBakesInsteadS6)
{
    expectTheProcessorBakesInstead(tinySettings());
}

TEST_F(GpuFaults, TheProcessorTracesPathsInsteadS6)
{
    expectTheProcessorBakesInstead(tinySettings(IntegratorKind::Path));
}

TEST_F(GpuFaults, TheProcessorBakesGroupsInsteadS33)
{
    BakeSettings settings = tinySettings();
    settings.groups = GroupChoice::Each;
    expectTheProcessorBakesInstead(settings);
}

/// Wherever the device fails while it computes irradiance or a probe, that is an error: no texel keeps what it had.
TEST_F(GpuFaults, EachFailureIsAnErrorS6)
{
    std::atomic<int> failing = 0;
    const auto device = openBakeDevice({.name = testDeviceName(), .fails = [&] { return ++calls == failing; }});
    if (!device) GTEST_SKIP() << device.error().message;
    for (const IntegratorKind kind : {IntegratorKind::Cache, IntegratorKind::Path}) {
        IntegrationSettings settings;
        settings.integrator = kind;
        settings.samples = 48; // more than the cache's first pass
        settings.bounces = 2;
        const auto statusFailingAt = [&](int number) {
            failing = 0;
            Bench bench(room(true, true, true), MixedLightingMode::Shadowmask, 64, settings, 1,
                        gpuIntegrators(*device));
            bench.lightmap = bench.integrator->prepare(bench.map, nullptr);
            EXPECT_TRUE(bench.lightmap->prepareAll({}));
            std::vector<IrradianceEstimate> out(bench.map.texels.size());
            std::vector<ProbeEstimate> probe(1);
            calls = 0;
            failing = number;
            if (Status s = bench.irradiance({allIndices(out.size())}, out); !s) return s;
            return bench.integrator->probes(std::vector{vec3(0, 1, 0)}, std::vector{0u}, 0, probe, {});
        };
        ASSERT_TRUE(statusFailingAt(0)); // makes pipelines, which stay
        waitForPipelines(**device);
        ASSERT_TRUE(statusFailingAt(0));
        const int all = calls;
        ASSERT_GT(all, 10);
        constexpr int kFirst = 6; // commands of the cache's gather
        for (int number = 1; number <= all; ++number) {
            if (number > kFirst && (all - number) % 3 != 0) continue;
            const Status status = statusFailingAt(number);
            ASSERT_FALSE(status) << number << " of " << all;
            EXPECT_EQ(status.error().code, ErrorCode::DeviceFailed);
        }
    }
}

/// What does not fit the memory that the device may take is the processor's: the whole bake, or the denoiser alone.
TEST_F(GpuFaults, MemoryHasALimitS6)
{
    const Scene scene = room(false, true, true);
    auto device = deviceFailingAt(0);
    if (!device) GTEST_SKIP() << device.error().message;
    const Result<BakeResult> whole = bake(scene, tinySettings(), gpuIntegrators(*device));
    ASSERT_TRUE(whole) << whole.error().text();
    EXPECT_GT(whole->report.peakDeviceBytes, uint64_t(64) << 20);
    const Result<BakeResult> cpu = bake(scene, tinySettings(), embreeIntegrators());
    ASSERT_TRUE(cpu);
    EXPECT_EQ(cpu->report.peakDeviceBytes, 0u);
    const auto says = [](const BakeResult& result, const std::string& text) {
        const auto& warnings = result.report.warnings;
        return std::any_of(warnings.begin(), warnings.end(),
                           [&](const std::string& w) { return w.find(text) != std::string::npos; });
    };
    device = openBakeDevice({.name = testDeviceName(), .mostBytes = uint64_t(64) << 20});
    ASSERT_TRUE(device) << device.error().message;
    const Result<BakeResult> small = bake(scene, tinySettings(), gpuIntegrators(*device));
    ASSERT_TRUE(small) << small.error().text();
    EXPECT_TRUE(says(*small, "it takes more than 64 MiB of the device's memory"));
    expectSameBakes(small->baked, cpu->baked);
    device = openBakeDevice({.name = testDeviceName(), .mostBytes = whole->report.peakDeviceBytes});
    ASSERT_TRUE(device) << device.error().message;
    const Result<BakeResult> exact = bake(scene, tinySettings(), gpuIntegrators(*device));
    ASSERT_TRUE(exact) << exact.error().text();
    EXPECT_LE(exact->report.peakDeviceBytes, whole->report.peakDeviceBytes);
    EXPECT_EQ(exact->report.identity, whole->report.identity);
    expectSameBakes(exact->baked, whole->baked);
}

/// As many groups as a file may have take 192 MiB at most: what grows with the scene is small here.
TEST_F(GpuFaults, GroupsTakeLittleMemoryS33)
{
    Scene scene = room(true, true, true);
    for (std::size_t i = 3; i < kMostLightGroups; ++i)
        scene.lights.push_back(pointAt("lamp" + std::to_string(i), vec3(-0.8f + 0.1f * float(i), 1.7f, 0.5f), 3.0f));
    BakeSettings settings = tinySettings();
    std::array<uint64_t, 2> bytes{};
    for (const bool grouped : {false, true}) {
        const auto device = deviceFailingAt(0);
        if (!device) GTEST_SKIP() << device.error().message;
        settings.groups = grouped ? GroupChoice::Each : GroupChoice::Off;
        const Result<BakeResult> result = bake(scene, settings, gpuIntegrators(*device));
        ASSERT_TRUE(result) << result.error().text();
        EXPECT_EQ(result->baked.groups.size(), grouped ? kMostLightGroups : 0u);
        EXPECT_TRUE(result->report.identity.starts_with("gpu-")) << result->report.identity;
        bytes[grouped ? 1 : 0] = result->report.peakDeviceBytes;
    }
    EXPECT_GT(bytes[1], bytes[0]);
    EXPECT_LT(bytes[1] - bytes[0], uint64_t(192) << 20);
    RecordProperty("bytes", std::to_string(bytes[0]) + " and " + std::to_string(bytes[1]));
}

/// A device that cannot be opened is an error: nothing was baked yet.
TEST_F(GpuFaults, DevicesThatFailAtOnceAreAnError)
{
    auto device = deviceFailingAt(1);
    ASSERT_FALSE(device);
    EXPECT_EQ(device.error().code, ErrorCode::DeviceFailed);
    device = openBakeDevice({.name = "no such device"});
    ASSERT_FALSE(device);
    EXPECT_NE(device.error().message.find("has another name"), std::string::npos) << device.error().message;
}

} // namespace
} // namespace halflight::test::faults_test
