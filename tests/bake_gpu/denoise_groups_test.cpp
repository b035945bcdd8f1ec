// The denoiser on a device gives each component of bakes with light groups what the processor's gives (spec S33).

#include "bake_gpu/bake_device.h"
#include "bake_gpu/noisy_floor.h"
#include "gpu/compute.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace halflight::test::denoise_groups_test {
namespace {

template<typename T> bool sameBytes(const std::vector<T>& a, const std::vector<T>& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool sameBits(ComponentSignals& a, ComponentSignals& b)
{
    return std::ranges::equal(a.components(), b.components(), [](const Signals& x, const Signals& y) {
        return sameBytes(x.gathered, y.gathered) && sameBytes(x.direct, y.direct) && sameBytes(x.moments, y.moments);
    });
}

using DeviceDenoiseS33 = DeviceDenoise;

TEST_F(DeviceDenoiseS33, ComponentsHaveTheProcessorsLight)
{
    const Floor floor;
    ComponentSignals before = floor.components();
    ComponentSignals cpu = floor.components();
    ComponentSignals gpu = floor.components();
    ASSERT_TRUE(floor.denoiseAll(cpu.components(), {}));
    ASSERT_TRUE(floor.denoiseAll(gpu.components(), denoiser()));
    for (std::size_t c = 0; c < cpu.count(); ++c) {
        SCOPED_TRACE("component " + std::to_string(c));
        const Signals& own = gpu.components()[c];
        EXPECT_EQ(own.direct.size(), before.components()[c].direct.size());
        EXPECT_EQ(own.moments.size(), before.components()[c].moments.size());
        expectNear(lightOf(cpu.components()[c]), lightOf(own), floor.map);
        const double change = meanChange(lightOf(before.components()[c]), lightOf(own));
        if (c < 3)
            EXPECT_GT(change, 0.1 * double(kNoise));
        else
            EXPECT_EQ(change, 0.0); // black stays black
    }
}

/// Components use the same memory, and nothing of one reaches another.
TEST_F(DeviceDenoiseS33, EachIsAsIfAlone)
{
    const Floor floor;
    ComponentSignals together = floor.components();
    ComponentSignals alone = floor.components();
    ASSERT_TRUE(floor.denoiseAll(together.components(), denoiser()));
    for (Signals& component : alone.components()) ASSERT_TRUE(floor.denoiseAll(std::span(&component, 1), denoiser()));
    EXPECT_TRUE(sameBits(together, alone));
}

/// A device that is lost at any of its tasks leaves all components as they were.
TEST_F(DeviceDenoiseS33, FaultsChangeNoComponent)
{
    const Floor floor;
    ComponentSignals before = floor.components();
    ComponentSignals denoised = floor.components();
    ASSERT_TRUE(floor.denoiseAll(denoised.components(), denoiser()));
    auto& vk = const_cast<gpu::Functions&>(device->device().vk);
    for (int task = 0;; task += 5) {
        const Fault<PFN_vkQueueSubmit2> fault(vk.QueueSubmit2, task, VK_ERROR_DEVICE_LOST);
        ComponentSignals found = floor.components();
        const Status status = floor.denoiseAll(found.components(), denoiser());
        if (!fault.happened()) {
            EXPECT_TRUE(status);
            EXPECT_TRUE(sameBits(found, denoised));
            EXPECT_GT(task, 30); // it failed in more than one component
            return;
        }
        ASSERT_FALSE(status) << task;
        EXPECT_EQ(status.error().code, ErrorCode::DeviceFailed);
        EXPECT_TRUE(sameBits(found, before)) << task;
    }
}

/// Where a device may not take the memory, the processor denoises.
TEST_F(DeviceDenoiseS33, MemoryHasALimit)
{
    const Floor floor;
    ComponentSignals cpu = floor.components();
    ComponentSignals found = floor.components();
    ASSERT_TRUE(floor.denoiseAll(cpu.components(), {}));
    const uint64_t opened = (*openBakeDevice({.name = testDeviceName()}))->device().memory().peakBytes();
    const auto small = openBakeDevice({.name = testDeviceName(), .mostBytes = opened});
    ASSERT_TRUE(small) << small.error().message;
    std::vector<gpu::Buffer> taken;
    try {
        for (;;) taken.emplace_back((*small)->device(), VkDeviceSize(1) << 16, gpu::kAddressed, gpu::MemoryUse::Device);
    } catch (const gpu::LimitReached&) {
        EXPECT_FALSE(taken.empty());
    }
    const Status status = floor.denoiseAll(found.components(), gpuIntegrators(*small).denoise);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::Unsupported);
    EXPECT_TRUE(sameBits(found, cpu));
}

} // namespace
} // namespace halflight::test::denoise_groups_test
