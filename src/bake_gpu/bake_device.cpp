#include "bake_gpu/bake_device.h"

#include "bake_gpu/ray_ends.h"

#include "halflight/base/hash.h"

#include "shaders/bake/crossings.rahit.h"
#include "shaders/bake/crossings.rgen.h"
#include "shaders/bake/crossings.rmiss.h"
#include "shaders/bake/fronts.rgen.h"
#include "shaders/bake/gather_light.comp.h"
#include "shaders/bake/gather_points.comp.h"
#include "shaders/bake/gather_rays.comp.h"
#include "shaders/bake/gather_sources.comp.h"
#include "shaders/bake/gather_sums.comp.h"
#include "shaders/bake/nearest.rgen.h"
#include "shaders/bake/paths/paths.rgen.h"
#include "shaders/bake/paths/paths.rgen.tinted.h"
#include "shaders/bake/tints.rgen.tinted.h"
#include "shaders/bake/transmittance.rgen.h"
#include "shaders/bake/transmittance.rgen.tinted.h"
#include "shaders/bake/validity.rgen.h"

#include <algorithm>
#include <cctype>

namespace halflight {
namespace {

Later<gpu::RayPipeline> pathPipeline(gpu::Device& device, bool tinted)
{
    return Later<gpu::RayPipeline>([&device, tinted]() -> gpu::RayPipeline {
        const std::span<const uint32_t> generate = tinted ? std::span<const uint32_t>(bake_paths_paths_rgen_tinted)
                                                          : std::span<const uint32_t>(bake_paths_paths_rgen);
        return {device, {generate, nearestEnds(), throughEnds(tinted)}, uint32_t(sizeof(TracePush))};
    });
}

Later<RadiosityPipelines> radiosityPipelines(gpu::Device& device, bool tinted)
{
    return Later<RadiosityPipelines>([&device, tinted] { return RadiosityPipelines(device, tinted); });
}

TintedPipelines tintedPipelines(gpu::Device& device)
{
    constexpr uint32_t kPush = sizeof(TracePush);
    return {{device, {bake_transmittance_rgen_tinted, throughEnds(true)}, kPush},
            {device, {bake_tints_rgen_tinted, nearestEnds(), throughEnds(true)}, kPush}};
}

} // namespace

BakeDevice::BakeDevice(const BakeDeviceOptions& options)
    : device_({.validation = options.validation,
               .rayTracing = true,
               .name = options.name,
               .mostBytes = options.mostBytes,
               .fails = options.fails}),
      nearest_(device_, {bake_nearest_rgen, nearestEnds()}, sizeof(TracePush)),
      fronts_(device_, {bake_fronts_rgen, nearestEnds()}, sizeof(TracePush)),
      transmittance_(device_, {bake_transmittance_rgen, throughEnds(false)}, sizeof(TracePush)),
      crossings_(device_, {bake_crossings_rgen, bake_crossings_rmiss, {}, bake_crossings_rahit}, sizeof(TracePush)),
      validity_(device_, {bake_validity_rgen, nearestEnds()}, sizeof(TracePush)),
      tinted_([this] { return tintedPipelines(device_); }), paths_{pathPipeline(device_, false),
                                                                   pathPipeline(device_, true)},
      emitters_([this] { return EmitterPipelines(device_); }),
      components_([this] { return ComponentPipelines(device_); }),
      denoise_([this] { return DenoisePipelines(device_); }),
      shadows_([this] { return ShadowPipelines(device_); }), radiosity_{radiosityPipelines(device_, false),
                                                                        radiosityPipelines(device_, true)}
{
    constexpr uint32_t kPush = 2 * sizeof(VkDeviceAddress);
    gatherPoints_ = {device_, bake_gather_points_comp, kPush};
    gatherRays_ = {device_, bake_gather_rays_comp, kPush};
    gatherLight_ = {device_, bake_gather_light_comp, kPush};
    gatherSources_ = {device_, bake_gather_sources_comp, kPush};
    gatherSums_ = {device_, bake_gather_sums_comp, kPush};
}

void BakeDevice::nearest(VkCommandBuffer commands, const TracePush& push, uint32_t count)
{
    nearest_.run(commands, gpu::bytesOf(push), count);
    fronts_.run(commands, gpu::bytesOf(push), count);
    if (push.tinted) tinted().tints.run(commands, gpu::bytesOf(push), count);
}

void BakeDevice::transmittance(VkCommandBuffer commands, const TracePush& push, uint32_t count)
{
    const bool byColor = push.tinted && push.byChance == 0;
    (byColor ? tinted().transmittance : transmittance_).run(commands, gpu::bytesOf(push), count);
}

void BakeDevice::crossings(VkCommandBuffer commands, const TracePush& push, uint32_t count)
{
    crossings_.run(commands, gpu::bytesOf(push), count);
}

void BakeDevice::validity(VkCommandBuffer commands, const TracePush& push, uint32_t count)
{
    validity_.run(commands, gpu::bytesOf(push), count);
}

std::string BakeDevice::identity() const
{
    Hasher hasher;
    for (const std::span<const uint32_t> shader : std::initializer_list<std::span<const uint32_t>>{
             bake_crossings_rahit, bake_crossings_rgen, bake_fronts_rgen, bake_gather_light_comp,
             bake_gather_points_comp, bake_gather_rays_comp, bake_gather_sources_comp, bake_gather_sums_comp,
             bake_nearest_rahit, bake_nearest_rchit, bake_nearest_rgen, bake_paths_paths_rgen, bake_transmittance_rahit,
             bake_transmittance_rgen, bake_validity_rgen, bake_tints_rgen_tinted, bake_transmittance_rahit_tinted,
             bake_transmittance_rgen_tinted, bake_paths_paths_rgen_tinted})
        hasher.bytes(shader.data(), shader.size_bytes());
    for (const auto& shaders : {EmitterPipelines::shaders(), ComponentPipelines::shaders(), ShadowPipelines::shaders(),
                                RadiosityPipelines::shaders()})
        for (const std::span<const uint32_t> shader : shaders) hasher.bytes(shader.data(), shader.size_bytes());
    std::string identity = "gpu-" + name() + "-" + device_.driver() + "-" + hasher.hash().hex().substr(0, 8);
    for (char& c : identity)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.') c = '-';
    return identity;
}

void BakeDevice::beginPipelines(bool tinted, bool radiosity)
{
    paths_[tinted ? 1 : 0].begin();
    if (radiosity) radiosity_[tinted ? 1 : 0].begin();
    if (tinted) tinted_.begin();
    shadows_.begin();
    denoise_.begin();
}

bool BakeDevice::makesPipelines()
{
    const auto any = [](auto& list) { return std::ranges::any_of(list, [](auto& later) { return later.isMaking(); }); };
    return any(paths_) || any(radiosity_) || tinted_.isMaking() || shadows_.isMaking() || denoise_.isMaking();
}

const TintedPipelines& BakeDevice::tinted()
{
    return tinted_.get();
}

const gpu::RayPipeline& BakeDevice::paths(bool tinted)
{
    return paths_[tinted ? 1 : 0].get();
}

const EmitterPipelines& BakeDevice::emitters()
{
    return emitters_.get();
}

const ComponentPipelines& BakeDevice::components()
{
    return components_.get();
}

const DenoisePipelines& BakeDevice::denoise()
{
    return denoise_.get();
}

const ShadowPipelines& BakeDevice::shadows()
{
    return shadows_.get();
}

const RadiosityPipelines& BakeDevice::radiosity(bool tinted)
{
    return radiosity_[tinted ? 1 : 0].get();
}

Result<std::shared_ptr<BakeDevice>> openBakeDevice(const BakeDeviceOptions& options)
{
    try {
        return std::make_shared<BakeDevice>(options);
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
}

Result<std::vector<DeviceDescription>> bakeDevices()
{
    try {
        std::vector<DeviceDescription> devices;
        for (gpu::Device::Description& device : gpu::Device::list({.rayTracing = true}))
            devices.push_back({std::move(device.name), std::move(device.refusal)});
        return devices;
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
}

bool makesPipelines(BakeDevice& device)
{
    return device.makesPipelines();
}

std::string describe(BakeDevice& device)
{
    return device.name() + ", " + device.device().driver();
}

std::vector<std::string> validationMessages(BakeDevice& device)
{
    return device.device().validationMessages();
}

} // namespace halflight
