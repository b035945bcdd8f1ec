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

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <vector>

namespace halflight {
namespace {

using shading::GpuGuide;
using shading::GpuTexel;

static_assert(sizeof(TexelGrid::Cell) == sizeof(shading::GpuCell));
static_assert(sizeof(TexelPlace) == sizeof(GpuGuide) && offsetof(TexelPlace, normal) == offsetof(GpuGuide, normal));
static_assert(sizeof(NoisyLight) == 16);

/// Grid and Field in shaders/bake/denoise.glsl.
struct DeviceGrid {
    VkDeviceAddress cells, texels, firsts, crossings;
    int pageSize;
};
struct DeviceField {
    DeviceGrid grid;
    VkDeviceAddress guides, differences, variances;
    uint32_t count;
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
    uint32_t hasDirect = 0;
    uint32_t directions = 0;
    int number = 0; ///< of the filter's level
};
static_assert(sizeof(DenoisePush) <= gpu::kMostPushBytes);

GpuTexel deviceTexel(const DenoiserTexels& texels, uint32_t i)
{
    const Texel& texel = texels.map.texels[i];
    uint32_t bits = texel.page << shading::kPageShift | crossingsAround(texels.grid, i);
    if (chartHasSeams(texels.grid, i)) bits |= shading::kHasSeams;
    if (texels.valid[i] != 0) bits |= shading::kIsValid;
    if (isWhole(texels.map, texel)) bits |= shading::kIsWhole;
    if (hasFewSamples(texels, i)) bits |= shading::kHasFewSamples;
    return {uint32_t(texel.x) | uint32_t(texel.y) << 16, bits, texel.chart};
}

/// One run of the denoiser. All components use the same memory, one after the other.
class DeviceRun {
public:
    DeviceRun(BakeDevice& bake, const DenoiserTexels& texels, bool someDirect, bool someMoments)
        : device_(bake.device()), pipelines_(bake.denoise()), texelsOf_(texels), count_(texels.valid.size()),
          up_(device_), down_(device_), cells_(list(texels.grid.cells().size_bytes())),
          texels_(list(count_ * sizeof(GpuTexel))), firsts_(list(texels.grid.firstCrossings().size_bytes())),
          crossings_(list(texels.grid.crossings().size_bytes())), guides_(list(count_ * sizeof(GpuGuide))),
          variances_(list(count_ * sizeof(float))), gathered_(twice(count_ * sizeof(NoisyLight))),
          direct_(twice(someDirect ? count_ * sizeof(NoisyLight) : 0)),
          moments_(twice(someMoments ? count_ * sizeof(vec3) : 0)), field_(list(sizeof(DeviceField)))
    {}

    /// What components have in common.
    void uploadTexels()
    {
        const DenoiserTexels& texels = texelsOf_;
        up_.upload(cells_, texels.grid.cells());
        up_.upload<GpuTexel>(texels_, count_, [&](std::size_t i) { return deviceTexel(texels, uint32_t(i)); });
        up_.upload(firsts_, texels.grid.firstCrossings());
        up_.upload(crossings_, texels.grid.crossings());
        up_.upload<TexelPlace>(
            guides_, count_, [&](std::size_t i) { return placeOf(texels.geometry, texels.map, texels.map.texels[i]); });
        const DeviceField field{
            {cells_.address(), texels_.address(), firsts_.address(), crossings_.address(), texels.map.pageSize},
            guides_.address(),
            gathered_[1].address(), // differences are read no more when it is written
            variances_.address(),
            uint32_t(count_)};
        static_assert(sizeof(shading::SecondDifference) <= sizeof(NoisyLight));
        up_.upload(field_, std::span<const DeviceField>(&field, 1));
    }

    void upload(const Signals& component)
    {
        up_.upload(gathered_[0], std::span<const NoisyLight>(component.gathered));
        up_.upload(direct_[0], std::span<const NoisyLight>(component.direct));
        up_.upload(moments_[0], std::span<const vec3>(component.moments));
    }

    void filter(const Signals& component)
    {
        const SignalAddresses stated{gathered_[0].address(), direct_[0].address(), moments_[0].address()};
        const SignalAddresses clamped{gathered_[1].address(), direct_[0].address(), moments_[0].address()};
        const SignalAddresses other{gathered_[0].address(), direct_[1].address(), moments_[1].address()};
        DenoisePush push{field_.address(), stated, clamped, !component.direct.empty(), !component.moments.empty()};
        launch(pipelines_.differences, push);
        launch(pipelines_.variances, push);
        launch(pipelines_.outliers, push);
        static_assert(shading::kFilterLevels % 2 == 0, "download() takes what the last level writes");
        for (push.number = 0; push.number < shading::kFilterLevels; ++push.number) {
            const bool even = push.number % 2 == 0;
            push.in = even ? clamped : other;
            push.out = even ? other : clamped;
            launch(pipelines_.filter, push);
        }
    }

    /// What filter() leaves of a component that is like this one.
    [[nodiscard]] Signals download(const Signals& component)
    {
        Signals signals;
        signals.gathered = largeVector<NoisyLight>(count_);
        signals.direct = largeVector<NoisyLight>(component.direct.size());
        signals.moments = largeVector<vec3>(component.moments.size());
        down_.download(gathered_[1], std::span(signals.gathered));
        down_.download(direct_[0], std::span(signals.direct));
        down_.download(moments_[0], std::span(signals.moments));
        return signals;
    }

private:
    [[nodiscard]] gpu::Buffer list(std::size_t bytes) const
    {
        return {device_, bytes, gpu::kAddressed, gpu::MemoryUse::Device};
    }
    [[nodiscard]] std::array<gpu::Buffer, 2> twice(std::size_t bytes) const { return {list(bytes), list(bytes)}; }

    /// One submission for each pass: a driver may end those that take long.
    void launch(const gpu::ComputePipeline& pipeline, const DenoisePush& push)
    {
        device_.execute([&](VkCommandBuffer commands) {
            pipeline.run(commands, gpu::bytesOf(push), count_, shading::kDenoiseGroup);
        });
    }

    gpu::Device& device_;
    const DenoisePipelines& pipelines_;
    const DenoiserTexels& texelsOf_;
    std::size_t count_;
    Transfer up_;
    Transfer down_;
    gpu::Buffer cells_;
    gpu::Buffer texels_;
    gpu::Buffer firsts_;
    gpu::Buffer crossings_;
    gpu::Buffer guides_;
    gpu::Buffer variances_;
    std::array<gpu::Buffer, 2> gathered_; ///< as stated, and without outliers: the filter's levels go to and fro
    std::array<gpu::Buffer, 2> direct_;
    std::array<gpu::Buffer, 2> moments_;
    gpu::Buffer field_;
};

/// Adds the seconds since it was last asked.
class Lap {
public:
    void addTo(double& seconds)
    {
        const Clock::time_point now = Clock::now();
        seconds += std::chrono::duration<double>(now - last_).count();
        last_ = now;
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point last_ = Clock::now();
};

void denoiseOn(BakeDevice& device, const DenoiserTexels& texels, std::span<Signals> components, DenoiseSeconds& seconds)
{
    const auto some = [&](auto list) {
        return std::ranges::any_of(components, [&](const Signals& signals) { return !(signals.*list).empty(); });
    };
    Lap lap;
    DeviceRun run(device, texels, some(&Signals::direct), some(&Signals::moments));
    lap.addTo(seconds.memory);
    run.uploadTexels();
    std::vector<Signals> denoised; // a device may be lost at any component
    for (const Signals& component : components) {
        run.upload(component);
        lap.addTo(seconds.upload);
        run.filter(component);
        lap.addTo(seconds.filter);
        denoised.push_back(run.download(component));
        lap.addTo(seconds.download);
    }
    std::ranges::move(denoised, components.begin());
}

} // namespace

DenoisePipelines::DenoisePipelines(const gpu::Device& device)
    : differences(device, bake_denoise_differences_comp, sizeof(DenoisePush)),
      variances(device, bake_denoise_variances_comp, sizeof(DenoisePush)),
      outliers(device, bake_denoise_outliers_comp, sizeof(DenoisePush)),
      filter(device, bake_denoise_filter_comp, sizeof(DenoisePush))
{}

Status denoiseOnDevice(BakeDevice& device, const DenoiserTexels& texels, std::span<Signals> components,
                       DenoiseSeconds* seconds)
{
    constexpr std::size_t kMostPlaces = std::size_t(1) << 31; // shaders count them by signed integers of 32 bits
    if (texels.grid.cells().size() >= kMostPlaces || texels.map.pageCount > int(shading::kMostPages))
        return Error{ErrorCode::Unsupported, "the lightmap has too many pages for the device's denoiser"};
    try {
        DenoiseSeconds own;
        denoiseOn(device, texels, components, own);
        if (seconds != nullptr) *seconds = own;
        return {};
    } catch (const gpu::LimitReached& reached) {
        return Error{ErrorCode::Unsupported, reached.what()};
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
}

} // namespace halflight
