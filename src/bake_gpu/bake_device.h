#pragma once
// The Vulkan device of a bake, and the pipelines that trace rays on it.

#include "bake_gpu/denoise_pipelines.h"
#include "bake_gpu/gather/component_pipelines.h"
#include "bake_gpu/gather/emitter_pipelines.h"
#include "bake_gpu/later.h"
#include "bake_gpu/radiosity/radiosity_pipelines.h"
#include "bake_gpu/shadows/shadow_pipelines.h"
#include "gpu/acceleration.h"

#include "halflight/bake_gpu/gpu_integrator.h"

#include <array>
#include <memory>
#include <string>

namespace halflight {

/// Push constants of shaders/bake/trace.glsl.
struct TracePush {
    VkDeviceAddress scene = 0;
    VkDeviceAddress rays = 0;    ///< shading::GpuRay
    VkDeviceAddress results = 0; ///< shading::GpuHit; float, or vec3 by colour; int
    uint32_t byChance = 0;       ///< transmittance: 0 multiplies what blended surfaces let through
    bool tinted = false;         ///< of a scene whose glass has a colour; no shader reads it
};

/// Rays of scenes whose glass has a colour.
struct TintedPipelines {
    gpu::RayPipeline transmittance;
    gpu::RayPipeline tints;
};

/// One device for all integrators of a bake, and for what else of it runs there.
class BakeDevice {
public:
    /// Throws gpu::Failure.
    explicit BakeDevice(const BakeDeviceOptions& options);

    [[nodiscard]] gpu::Device& device() { return device_; }
    /// RayKernels' verbs for `count` rays. Each begins with a full barrier. Those of scenes whose glass has a colour
    /// need tinted(), too.
    void nearest(VkCommandBuffer commands, const TracePush& push, uint32_t count);
    void transmittance(VkCommandBuffer commands, const TracePush& push, uint32_t count);
    /// The pipelines of scenes whose glass has a colour, made when they are first asked for. Throws gpu::Failure.
    const TintedPipelines& tinted();
    void crossings(VkCommandBuffer commands, const TracePush& push, uint32_t count);
    /// Tests of `count` texels' points (shaders/bake/validity.rgen), in the same way; `results` are its lists.
    void validity(VkCommandBuffer commands, const TracePush& push, uint32_t count);
    /// Steps of the final gather (shaders/bake/gather_*.comp).
    [[nodiscard]] const gpu::ComputePipeline& gatherPoints() const { return gatherPoints_; }
    [[nodiscard]] const gpu::ComputePipeline& gatherRays() const { return gatherRays_; }
    [[nodiscard]] const gpu::ComputePipeline& gatherLight() const { return gatherLight_; }
    [[nodiscard]] const gpu::ComputePipeline& gatherSources() const { return gatherSources_; }
    [[nodiscard]] const gpu::ComputePipeline& gatherSums() const { return gatherSums_; }
    /// Begins to make, on other threads, what nearly all bakes ask for later and a driver may compile for ten seconds.
    /// `tinted`: of scenes whose glass has a colour. `radiosity`: of bakes with a radiance cache.
    void beginPipelines(bool tinted, bool radiosity);
    /// Whether some of them are not finished yet.
    [[nodiscard]] bool makesPipelines();
    /// Paths (shaders/bake/paths/paths.rgen), made when they are first asked for. Throws gpu::Failure.
    const gpu::RayPipeline& paths(bool tinted);
    /// The same of the gather's emitter samples.
    const EmitterPipelines& emitters();
    /// The same of its sums by component.
    const ComponentPipelines& components();
    /// The denoiser's shaders, made when they are first asked for. Throws gpu::Failure.
    const DenoisePipelines& denoise();
    /// The same around shadow rays.
    const ShadowPipelines& shadows();
    /// The shaders of the radiosity passes.
    const RadiosityPipelines& radiosity(bool tinted);
    [[nodiscard]] std::string name() const { return device_.properties().deviceName; }
    /// "gpu-" with the device's name, its driver's version and a hash of the shaders: what decides the bytes.
    [[nodiscard]] std::string identity() const;

private:
    gpu::Device device_;
    gpu::RayPipeline nearest_;
    gpu::RayPipeline fronts_;
    gpu::RayPipeline transmittance_;
    gpu::RayPipeline crossings_;
    gpu::RayPipeline validity_;
    gpu::ComputePipeline gatherPoints_;
    gpu::ComputePipeline gatherRays_;
    gpu::ComputePipeline gatherLight_;
    gpu::ComputePipeline gatherSources_;
    gpu::ComputePipeline gatherSums_;
    Later<TintedPipelines> tinted_;
    std::array<Later<gpu::RayPipeline>, 2> paths_; ///< the second one with tints
    Later<EmitterPipelines> emitters_;
    Later<ComponentPipelines> components_;
    Later<DenoisePipelines> denoise_;
    Later<ShadowPipelines> shadows_;
    std::array<Later<RadiosityPipelines>, 2> radiosity_; ///< in the same way
};

/// Copies a list to a buffer that shaders find by its address, and trees are built from.
template<typename T> gpu::Buffer bufferOf(gpu::Device& device, std::span<const T> list)
{
    gpu::Buffer buffer(device, list.size_bytes(), gpu::kTreeInput, gpu::MemoryUse::Device);
    gpu::Uploader uploader(device);
    uploader.buffer(buffer, list.data(), list.size_bytes());
    uploader.finish();
    return buffer;
}
template<typename T> gpu::Buffer bufferOf(gpu::Device& device, const std::vector<T>& list)
{
    return bufferOf(device, std::span<const T>(list));
}

} // namespace halflight
