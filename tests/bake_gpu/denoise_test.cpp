// The denoiser on a device gives what the processor's gives (spec S6).

#include "bake/same_bakes.h"
#include "bake/test_scene.h"
#include "bake_gpu/noisy_floor.h"

#include "halflight/bake/bake.h"

#include <cstring>
#include <span>
#include <vector>

namespace halflight::test::device_denoise_test {
namespace {

/// All that the denoiser changes.
std::vector<float> numbersOf(const std::vector<IrradianceEstimate>& estimates)
{
    std::vector<float> numbers;
    for (const IrradianceEstimate& e : estimates)
        for (const float number : {e.irradiance.x, e.irradiance.y, e.irradiance.z, e.moment.x, e.moment.y, e.moment.z,
                                   e.varianceOfMean, e.direct.x, e.direct.y, e.direct.z, e.varianceOfDirect})
            numbers.push_back(number);
    return numbers;
}
bool sameBits(const std::vector<IrradianceEstimate>& a, const std::vector<IrradianceEstimate>& b)
{
    const std::vector<float> x = numbersOf(a);
    const std::vector<float> y = numbersOf(b);
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0;
}

using DeviceDenoiseS6 = DeviceDenoise;
using DeviceDenoiseS33 = DeviceDenoise;

TEST_F(DeviceDenoiseS6, LightIsTheProcessors)
{
    const Floor floor;
    EXPECT_FALSE(floor.seams.empty());
    for (const Parts parts : {Parts{false, false}, Parts{true, true}}) {
        SCOPED_TRACE(testing::Message() << parts.direct << parts.directions);
        const std::vector<IrradianceEstimate> before = floor.estimates(parts);
        const std::vector<IrradianceEstimate> cpu = floor.denoised(parts, {});
        Status status;
        const std::vector<IrradianceEstimate> gpu = floor.denoised(parts, denoiser(), &status);
        ASSERT_TRUE(status) << status.error().message;
        for (std::size_t i = 0; i < cpu.size(); ++i) ASSERT_EQ(cpu[i].valid, gpu[i].valid);
        expectNear(lightOf(cpu), lightOf(gpu), floor.map);
        EXPECT_GT(meanChange(lightOf(before), lightOf(cpu)), 0.1 * double(kNoise)); // so that the limits say something
    }
}

TEST_F(DeviceDenoiseS6, BytesRepeat)
{
    const Floor floor;
    const Parts all{true, true};
    EXPECT_TRUE(sameBits(floor.denoised(all, denoiser()), floor.denoised(all, denoiser())));
}

/// Without memory, or with a device that is lost at any of its tasks: an error, and estimates as they were.
TEST_F(DeviceDenoiseS6, FaultsAreErrors)
{
    const Floor floor;
    const Parts all{true, true};
    const std::vector<IrradianceEstimate> cpu = floor.denoised(all, {});
    const std::vector<IrradianceEstimate> gpu = floor.denoised(all, denoiser());
    EXPECT_FALSE(sameBits(cpu, gpu)); // so that the comparison says something
    auto& vk = const_cast<gpu::Functions&>(device->device().vk);
    const auto failAt = [&](auto& function, int call, VkResult result, const char* name) {
        using Function = std::remove_reference_t<decltype(function)>;
        Status status;
        const Fault<Function> fault(function, call, result);
        const std::vector<IrradianceEstimate> found = floor.denoised(all, denoiser(), &status);
        if (!fault.happened()) {
            EXPECT_TRUE(sameBits(found, gpu));
            return false;
        }
        EXPECT_FALSE(status);
        if (!status) EXPECT_NE(status.error().message.find(name), std::string::npos) << status.error().message;
        EXPECT_TRUE(sameBits(found, floor.estimates(all))) << "call " << call;
        return true;
    };
    int buffers = 0;
    while (failAt(vk.CreateBuffer, buffers, VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY"))
        buffers += 4;
    EXPECT_GT(buffers, 8);
    int tasks = 0;
    while (failAt(vk.QueueSubmit2, tasks, VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST")) tasks += 3;
    EXPECT_GT(tasks, 12);
}

/// A bake whose denoiser fails has the bytes of one without a device, and one that it cannot serve says so.
void expectReportsSayWhoDenoised(const DeviceDenoiser& denoiser, GroupChoice groups)
{
    Scene scene;
    addBox(scene, vec3(-2, 0, -2), vec3(2, 3, 2), addMaterial(scene, vec3(0.6f)), true);
    scene.lights.push_back(makeLight(LightType::Point, vec3(1, 2, 0), vec3(0, -1, 0), 5.0f, LightMode::Mixed));
    BakeSettings settings;
    settings.samples = 16;
    settings.lightmapSize = 64;
    settings.bounces = 1;
    settings.probeSpacingMeters = 3.0f;
    settings.reflectionProbes = false;
    settings.groups = groups;
    IntegratorFactory factory = embreeIntegrators();
    const Result<BakeResult> cpu = bake(scene, settings, factory);
    factory.denoise = denoiser;
    const Result<BakeResult> gpu = bake(scene, settings, factory);
    ASSERT_TRUE(cpu && gpu);
    EXPECT_EQ(cpu->baked.groups.empty(), groups == GroupChoice::Off);
    for (const ErrorCode code : {ErrorCode::DeviceFailed, ErrorCode::Unsupported}) {
        factory.denoise = [code](const DenoiserTexels&, std::span<Signals>) { return Error{code, "it rains"}; };
        factory.instead = std::make_shared<const IntegratorFactory>(embreeIntegrators());
        const Result<BakeResult> fallen = bake(scene, settings, factory);
        ASSERT_TRUE(fallen);
        ASSERT_EQ(fallen->report.warnings.size(), cpu->report.warnings.size() + 1);
        EXPECT_NE(fallen->report.warnings.back().find("it rains"), std::string::npos);
        expectSameBakes(fallen->baked, cpu->baked);
    }
    EXPECT_EQ(gpu->report.warnings, cpu->report.warnings);
    if (groups == GroupChoice::Off)
        EXPECT_NE(gpu->irradiance[0].texels(), cpu->irradiance[0].texels());
    else
        EXPECT_NE(gpu->groupIrradiance[0][0].texels(), cpu->groupIrradiance[0][0].texels());
}

TEST_F(DeviceDenoiseS6, ReportsSayWhoDenoised)
{
    expectReportsSayWhoDenoised(denoiser(), GroupChoice::Off);
}
TEST_F(DeviceDenoiseS33, ReportsSayWhoDenoised)
{
    expectReportsSayWhoDenoised(denoiser(), GroupChoice::Each);
}

} // namespace
} // namespace halflight::test::device_denoise_test
