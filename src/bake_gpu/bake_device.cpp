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

#include <cctype>

namespace halflight {

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
      validity_(device_, {bake_validity_rgen, nearestEnds()}, sizeof(TracePush))
{
    constexpr uint32_t kPush = 2 * sizeof(VkDeviceAddress);
    gatherPoints_ = {device_, bake_gather_points_comp, kPush};
    gatherRays_ = {device_, bake_gather_rays_comp, kPush};
    gatherLight_ = {device_, bake_gather_light_comp, kPush};
    gatherSources_ = {device_, bake_gather_sources_comp, kPush};
    gatherSums_ = {device_, bake_gather_sums_comp, kPush};
}

void BakeDevice::nearest(VkCommandBuffer commands, const TracePush& push, uint32_t count) const
{
    nearest_.run(commands, gpu::bytesOf(push), count);
    fronts_.run(commands, gpu::bytesOf(push), count);
    if (push.tinted) tints_->run(commands, gpu::bytesOf(push), count);
}

void BakeDevice::transmittance(VkCommandBuffer commands, const TracePush& push, uint32_t count) const
{
    const bool byColor = push.tinted && push.byChance == 0;
    (byColor ? *tintedTransmittance_ : transmittance_).run(commands, gpu::bytesOf(push), count);
}

void BakeDevice::crossings(VkCommandBuffer commands, const TracePush& push, uint32_t count) const
{
    crossings_.run(commands, gpu::bytesOf(push), count);
}

void BakeDevice::validity(VkCommandBuffer commands, const TracePush& push, uint32_t count) const
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

void BakeDevice::makeTinted()
{
    const std::lock_guard lock(laterMutex_);
    if (tints_) return;
    tintedTransmittance_.emplace(device_, gpu::RayShaders{bake_transmittance_rgen_tinted, throughEnds(true)},
                                 uint32_t(sizeof(TracePush)));
    tints_.emplace(device_, gpu::RayShaders{bake_tints_rgen_tinted, nearestEnds(), throughEnds(true)},
                   uint32_t(sizeof(TracePush)));
}

const gpu::RayPipeline& BakeDevice::paths(bool tinted)
{
    const std::lock_guard lock(laterMutex_);
    std::optional<gpu::RayPipeline>& paths = paths_[tinted ? 1 : 0];
    if (paths) return *paths;
    const gpu::RayShaders shaders{tinted ? std::span<const uint32_t>(bake_paths_paths_rgen_tinted)
                                         : std::span<const uint32_t>(bake_paths_paths_rgen),
                                  nearestEnds(), throughEnds(tinted)};
    return paths.emplace(device_, shaders, uint32_t(sizeof(TracePush)));
}

const EmitterPipelines& BakeDevice::emitters()
{
    const std::lock_guard lock(laterMutex_);
    if (!emitters_) emitters_.emplace(device_);
    return *emitters_;
}

const ComponentPipelines& BakeDevice::components()
{
    const std::lock_guard lock(laterMutex_);
    if (!components_) components_.emplace(device_);
    return *components_;
}

const DenoisePipelines& BakeDevice::denoise()
{
    const std::lock_guard lock(laterMutex_);
    if (!denoise_) denoise_.emplace(device_);
    return *denoise_;
}

const ShadowPipelines& BakeDevice::shadows()
{
    const std::lock_guard lock(laterMutex_);
    if (!shadows_) shadows_.emplace(device_);
    return *shadows_;
}

const RadiosityPipelines& BakeDevice::radiosity(bool tinted)
{
    const std::lock_guard lock(laterMutex_);
    std::optional<RadiosityPipelines>& radiosity = radiosity_[tinted ? 1 : 0];
    return radiosity ? *radiosity : radiosity.emplace(device_, tinted);
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

std::string describe(BakeDevice& device)
{
    return device.name() + ", " + device.device().driver();
}

std::vector<std::string> validationMessages(BakeDevice& device)
{
    return device.device().validationMessages();
}

} // namespace halflight
