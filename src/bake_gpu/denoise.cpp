#include "bake_gpu/denoise.h"

#include "bake/denoise/denoise_outliers.h"
#include "bake/texels/texel_places.h"
#include "bake_gpu/denoise_layout.h"
#include "bake_gpu/denoise_pipelines.h"
#include "bake_gpu/transfer.h"

#include "shaders/bake/denoise_differences.comp.h"
#include "shaders/bake/denoise_filter.comp.h"
#include "shaders/bake/denoise_outliers.comp.h"
#include "shaders/bake/denoise_variances.comp.h"

#include "halflight/base/memory.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <utility>

namespace halflight {
namespace {

using shading::GpuEstimate;
using shading::GpuGuide;
using shading::GpuTexel;

static_assert(sizeof(TexelGrid::Cell) == sizeof(shading::GpuCell));
static_assert(sizeof(TexelPlace) == sizeof(GpuGuide) && offsetof(TexelPlace, normal) == offsetof(GpuGuide, normal));
static_assert(sizeof(IrradianceEstimate) == sizeof(GpuEstimate));
static_assert(offsetof(IrradianceEstimate, direct) == offsetof(GpuEstimate, direct));
static_assert(offsetof(IrradianceEstimate, valid) == offsetof(GpuEstimate, valid));
static_assert(sizeof(NoisyLight) == 16);

/// Grid and Field in shaders/bake/denoise.glsl.
struct DeviceGrid {
    VkDeviceAddress cells, texels, firsts, crossings;
    int pageSize;
};
struct DeviceField {
    DeviceGrid grid;
    VkDeviceAddress guides, estimates, differences, scaled, clamped, direct, moments;
    uint32_t count, hasDirect, directions;
};
/// Addresses of signals.
struct SignalAddresses {
    VkDeviceAddress gathered, direct, moments;
};
/// Push in shaders/bake/denoise.glsl.
struct DenoisePush {
    VkDeviceAddress field = 0;
    SignalAddresses in{};
    SignalAddresses out{};
    int number = 0; ///< of the filter's level
};
static_assert(sizeof(DenoisePush) <= gpu::kMostPushBytes);

GpuTexel deviceTexel(const DenoiserInput& input, uint32_t i)
{
    const Texel& texel = input.map.texels[i];
    const IrradianceEstimate& estimate = input.estimates[i];
    uint32_t bits = texel.page << shading::kPageShift | crossingsAround(input.grid, i);
    if (chartHasSeams(input.grid, i)) bits |= shading::kHasSeams;
    if (estimate.valid) bits |= shading::kIsValid;
    if (isWhole(input.map, texel)) bits |= shading::kIsWhole;
    return {uint32_t(texel.x) | uint32_t(texel.y) << 16, bits, texel.chart};
}

/// One run of the denoiser.
class DeviceRun {
public:
    DeviceRun(BakeDevice& bake, const DenoiserInput& input)
        : device_(bake.device()), pipelines_(bake.denoise()), input_(input), count_(input.estimates.size()),
          transfer_(device_), cells_(list(input.grid.cells().size_bytes())), texels_(list(count_ * sizeof(GpuTexel))),
          firsts_(list(input.grid.firstCrossings().size_bytes())),
          crossings_(list(input.grid.crossings().size_bytes())), guides_(list(count_ * sizeof(GpuGuide))),
          estimates_(list(count_ * sizeof(GpuEstimate))), scaled_(list(count_ * sizeof(NoisyLight))),
          gathered_(list(count_ * sizeof(NoisyLight))),
          direct_(list(input.hasDirect ? count_ * sizeof(NoisyLight) : 0)), moments_(list(count_ * sizeof(vec3))),
          field_(list(sizeof(DeviceField)))
    {}

    void upload()
    {
        transfer_.upload(cells_, input_.grid.cells());
        transfer_.upload<GpuTexel>(texels_, count_, [&](std::size_t i) { return deviceTexel(input_, uint32_t(i)); });
        transfer_.upload(firsts_, input_.grid.firstCrossings());
        transfer_.upload(crossings_, input_.grid.crossings());
        transfer_.upload<TexelPlace>(
            guides_, count_, [&](std::size_t i) { return placeOf(input_.geometry, input_.map, input_.map.texels[i]); });
        transfer_.upload(estimates_, input_.estimates);
        uploadField();
    }

    void filter()
    {
        launch(pipelines_.differences, {});
        launch(pipelines_.variances, {});
        launch(pipelines_.outliers, {});
        // Estimates are read no more: every other level's signals have their place.
        const SignalAddresses own{gathered_.address(), direct_.address(), moments_.address()};
        const VkDeviceAddress lights = count_ * sizeof(NoisyLight);
        const VkDeviceAddress place = estimates_.address();
        const SignalAddresses other{place, place + lights, place + (input_.hasDirect ? 2 : 1) * lights};
        static_assert(2 * sizeof(NoisyLight) + sizeof(vec3) <= sizeof(GpuEstimate));
        static_assert(shading::kFilterLevels % 2 == 0, "the last level writes to the signals' own place");
        for (int number = 0; number < shading::kFilterLevels; ++number) {
            const bool even = number % 2 == 0;
            launch(pipelines_.filter, {0, even ? own : other, even ? other : own, number});
        }
    }

    [[nodiscard]] Signals download()
    {
        Signals signals;
        signals.gathered = largeVector<NoisyLight>(count_);
        signals.direct = largeVector<NoisyLight>(input_.hasDirect ? count_ : 0);
        signals.moments = largeVector<vec3>(input_.directions ? count_ : 0);
        transfer_.download(gathered_, std::span(signals.gathered));
        transfer_.download(direct_, std::span(signals.direct));
        transfer_.download(moments_, std::span(signals.moments));
        return signals;
    }

private:
    [[nodiscard]] gpu::Buffer list(std::size_t bytes) const
    {
        return {device_, bytes, gpu::kAddressed, gpu::MemoryUse::Device};
    }

    void uploadField()
    {
        const DeviceField field{
            {cells_.address(), texels_.address(), firsts_.address(), crossings_.address(), input_.map.pageSize},
            guides_.address(),
            estimates_.address(),
            gathered_.address(), // differences are read no more when it is written
            scaled_.address(),
            gathered_.address(),
            direct_.address(),
            moments_.address(),
            uint32_t(count_),
            input_.hasDirect,
            input_.directions};
        static_assert(sizeof(shading::SecondDifference) <= sizeof(NoisyLight));
        transfer_.upload(field_, std::span<const DeviceField>(&field, 1));
    }

    /// One submission for each pass: a driver may end those that take long.
    void launch(const gpu::ComputePipeline& pipeline, DenoisePush push)
    {
        push.field = field_.address();
        device_.execute([&](VkCommandBuffer commands) {
            pipeline.run(commands, gpu::bytesOf(push), count_, shading::kDenoiseGroup);
        });
    }

    gpu::Device& device_;
    const DenoisePipelines& pipelines_;
    const DenoiserInput& input_;
    std::size_t count_;
    Transfer transfer_;
    gpu::Buffer cells_;
    gpu::Buffer texels_;
    gpu::Buffer firsts_;
    gpu::Buffer crossings_;
    gpu::Buffer guides_;
    gpu::Buffer estimates_;
    gpu::Buffer scaled_;   ///< gathered light before outliers are removed
    gpu::Buffer gathered_; ///< at first the second differences
    gpu::Buffer direct_;
    gpu::Buffer moments_;
    gpu::Buffer field_;
};

} // namespace

DenoisePipelines::DenoisePipelines(const gpu::Device& device)
    : differences(device, bake_denoise_differences_comp, sizeof(DenoisePush)),
      variances(device, bake_denoise_variances_comp, sizeof(DenoisePush)),
      outliers(device, bake_denoise_outliers_comp, sizeof(DenoisePush)),
      filter(device, bake_denoise_filter_comp, sizeof(DenoisePush))
{}

Result<Signals> denoisedOnDevice(BakeDevice& device, const DenoiserInput& input, DenoiseSeconds* seconds)
{
    constexpr std::size_t kMostPlaces = std::size_t(1) << 31; // shaders count them by signed integers of 32 bits
    if (input.grid.cells().size() >= kMostPlaces || input.map.pageCount > int(shading::kMostPages))
        return Error{ErrorCode::Unsupported, "the lightmap has too many pages for the device's denoiser"};
    using Clock = std::chrono::steady_clock;
    std::array<Clock::time_point, 5> times{Clock::now()};
    try {
        DeviceRun run(device, input);
        times[1] = Clock::now();
        run.upload();
        times[2] = Clock::now();
        run.filter();
        times[3] = Clock::now();
        Signals signals = run.download();
        times[4] = Clock::now();
        const auto between = [&](std::size_t i) {
            return std::chrono::duration<double>(times[i + 1] - times[i]).count();
        };
        if (seconds != nullptr) *seconds = {between(0), between(1), between(2), between(3)};
        return signals;
    } catch (const gpu::LimitReached& reached) {
        return Error{ErrorCode::Unsupported, reached.what()};
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
}

} // namespace halflight
