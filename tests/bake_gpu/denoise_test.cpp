// The denoiser on a device gives what the processor's gives (spec S6).

#include "bake/denoise/denoise.h"
#include "bake/geometry/flatten.h"
#include "bake/same_bakes.h"
#include "bake/seams/seams.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"
#include "bake/texels/texel_places.h"
#include "bake_gpu/bake_device.h"
#include "bake_gpu/test_device.h"

#include "halflight/bake/bake.h"

#include <cmath>
#include <cstring>
#include <random>

namespace halflight::test::device_denoise_test {
namespace {

constexpr int kPage = 96;
constexpr float kNoise = 0.1f; ///< standard deviation of gathered light, lux
constexpr float kMean = 2.0f;  ///< of light, lux

/// Which parts of the denoiser a run has.
struct Parts {
    bool direct = false; ///< light of baked lights
    bool directions = false;
};

/// A floor in four objects, and a wall on it. The floor's charts lie on the page turned, mirrored, at odd fractions of
/// a texel, and coarser on another page.
struct Floor {
    Floor()
    {
        const int grey = addMaterial(scene, vec3(0.5f));
        addRectangle(scene, {vec3(0, 0, 4), vec3(2, 0, 0), vec3(0, 0, -4)}, grey, kPage,
                     {vec2(3.3f, 2.6f), vec2(23.3f, 42.6f)});
        addRectangle(scene, {vec3(2.3f, 0, 4), vec3(0, 0, -4), vec3(-0.3f, 0, 0)}, grey, kPage,
                     {vec2(30.8f, 4.1f), vec2(70.8f, 7.1f)});
        addRectangle(scene, {vec3(2.3f, 0, 4), vec3(3.7f, 0, 0), vec3(0, 0, -1.5f)}, grey, kPage,
                     {vec2(70.2f, 14.7f), vec2(33.2f, 29.7f)});
        addRectangle(scene, {vec3(2.3f, 0, 2.5f), vec3(3.7f, 0, 0), vec3(0, 0, -2.5f)}, grey, kPage,
                     {vec2(34.9f, 40.3f), vec2(64.5f, 60.3f)});
        addRectangle(scene, {vec3(0, 0, 0), vec3(6, 0, 0), vec3(0, 2, 0)}, grey, kPage,
                     {vec2(3.5f, 66.2f), vec2(63.5f, 86.2f)});
        scene.objects[3].lightmap.page = 1;
        geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 2);
        seams = findSeams(geometry, kPage);
    }

    /// Noisy light with fireflies, dark specks and texels inside geometry.
    [[nodiscard]] std::vector<IrradianceEstimate> estimates(Parts parts) const
    {
        std::mt19937 random(7);
        std::normal_distribution<float> noise(0.0f, kNoise);
        std::uniform_real_distribution<float> unit;
        std::vector<IrradianceEstimate> list(map.texels.size());
        for (std::size_t i = 0; i < list.size(); ++i) {
            const vec3 at = placeOf(geometry, map, map.texels[i]).position;
            const float light = kMean + 0.5f * std::sin(1.5f * at.x) + 0.3f * std::cos(2.0f * at.z + at.y);
            const float dice = unit(random);
            const float factor = dice < 0.01f ? 8.0f : dice < 0.02f ? 0.1f : 1.0f;
            IrradianceEstimate& e = list[i];
            e.irradiance = factor * vec3(light + noise(random), light + noise(random), 0.7f * light);
            e.moment = vec3(noise(random), 0.5f * factor * light, noise(random));
            e.varianceOfMean = kNoise * kNoise * (0.5f + 2.0f * unit(random)) * factor;
            e.samples = dice < 0.015f ? 32 : 256;
            e.valid = dice < 0.98f;
            if (!parts.direct || at.x < 3.0f) continue;
            e.direct = vec3(1.0f + 0.05f * noise(random));
            e.irradiance += e.direct;
            e.varianceOfDirect = 0.001f;
            e.varianceOfMean += e.varianceOfDirect;
        }
        return list;
    }

    /// What the processor gives, or a device.
    [[nodiscard]] std::vector<IrradianceEstimate> denoised(Parts parts, const DeviceDenoiser& device,
                                                           Status* status = nullptr) const
    {
        std::vector<IrradianceEstimate> list = estimates(parts);
        const Status outcome = denoise(geometry, map, seams, list, parts.directions, device);
        if (status != nullptr) *status = outcome;
        return list;
    }

    Scene scene;
    BakeGeometry geometry;
    TexelMap map;
    std::vector<SeamSample> seams;
};

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

class DeviceDenoiseS6 : public BakeDeviceTest {
protected:
    static DeviceDenoiser denoiser() { return gpuIntegrators(device).denoise; }
};

/// Numbers differ by rounding. Where that turns the choice between curve and slope over, a texel is off by what the
/// filter leaves of noise: by less than the noise before it.
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
        std::size_t off = 0;
        double change = 0.0;
        for (std::size_t i = 0; i < cpu.size(); ++i) {
            ASSERT_EQ(cpu[i].valid, gpu[i].valid);
            const float light = glm::distance(cpu[i].irradiance, gpu[i].irradiance);
            const float rest =
                std::max(glm::distance(cpu[i].direct, gpu[i].direct), glm::distance(cpu[i].moment, gpu[i].moment));
            const float variance = std::abs(cpu[i].varianceOfMean - gpu[i].varianceOfMean);
            off += std::max(light, rest) > 1.0e-4f * kMean || variance > 1.0e-3f * kNoise * kNoise ? 1 : 0;
            EXPECT_LT(std::max(light, rest), kNoise) << floor.map.texels[i].x << ", " << floor.map.texels[i].y;
            change += double(glm::distance(cpu[i].irradiance, before[i].irradiance));
        }
        EXPECT_LE(off, cpu.size() / 1000);
        EXPECT_GT(change / double(cpu.size()), 0.1 * double(kNoise)); // so that the limits say something
    }
}

TEST_F(DeviceDenoiseS6, BytesRepeat)
{
    const Floor floor;
    const Parts all{true, true};
    EXPECT_TRUE(sameBits(floor.denoised(all, denoiser()), floor.denoised(all, denoiser())));
}

/// A function of the driver that fails at one of its calls.
template<typename Function> class Fault;
template<typename... Arguments> class Fault<VkResult(VKAPI_PTR*)(Arguments...)> {
public:
    using Function = VkResult(VKAPI_PTR*)(Arguments...);
    Fault(Function& place, int call, VkResult result) : place_(place)
    {
        own = place;
        left = call;
        outcome = result;
        place = &run;
    }
    ~Fault() { place_ = own; }
    Fault(const Fault&) = delete;
    Fault& operator=(const Fault&) = delete;
    [[nodiscard]] static bool happened() { return left < 0; }

private:
    static VkResult VKAPI_PTR run(Arguments... arguments) { return left-- == 0 ? outcome : own(arguments...); }
    Function& place_;
    static inline Function own = nullptr;
    static inline int left = 0;
    static inline VkResult outcome = VK_SUCCESS;
};

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
TEST_F(DeviceDenoiseS6, ReportsSayWhoDenoised)
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
    IntegratorFactory factory = embreeIntegrators();
    const Result<BakeResult> cpu = bake(scene, settings, factory);
    factory.denoise = denoiser();
    const Result<BakeResult> gpu = bake(scene, settings, factory);
    ASSERT_TRUE(cpu && gpu);
    for (const ErrorCode code : {ErrorCode::DeviceFailed, ErrorCode::Unsupported}) {
        factory.denoise = [code](const DenoiserInput&) { return Error{code, "it rains"}; };
        factory.instead = std::make_shared<const IntegratorFactory>(embreeIntegrators());
        const Result<BakeResult> fallen = bake(scene, settings, factory);
        ASSERT_TRUE(fallen);
        ASSERT_EQ(fallen->report.warnings.size(), cpu->report.warnings.size() + 1);
        EXPECT_NE(fallen->report.warnings.back().find("it rains"), std::string::npos);
        expectSameBakes(fallen->baked, cpu->baked);
    }
    EXPECT_EQ(gpu->report.warnings, cpu->report.warnings);
    EXPECT_NE(gpu->irradiance[0].texels(), cpu->irradiance[0].texels());
}

} // namespace
} // namespace halflight::test::device_denoise_test
