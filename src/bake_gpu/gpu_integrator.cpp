#include "halflight/bake_gpu/gpu_integrator.h"

#include "bake_cpu/trace/embree_kernels.h"
#include "bake_gpu/denoise.h"
#include "bake_gpu/kernels.h"
#include "scene/model/tint.h"
#include "transport/ray_integrator.h"

#include "halflight/bake_cpu/embree_integrator.h"

#include <algorithm>

namespace halflight {
namespace {

MakeKernels gpuKernels(const std::shared_ptr<BakeDevice>& device, const MakeKernels& cpu, Error& error)
{
    return [device, cpu, &error](const RayScene& scene) -> std::unique_ptr<RayKernels> {
        std::unique_ptr<RayKernels> own = cpu(scene);
        if (own == nullptr) return nullptr;
        try {
            return std::make_unique<GpuKernels>(device, scene, std::move(own));
        } catch (const gpu::Failure& failure) {
            error = {ErrorCode::DeviceFailed, failure.what()};
            return nullptr;
        }
    };
}

} // namespace

IntegratorFactory gpuIntegrators(const std::shared_ptr<BakeDevice>& device)
{
    const auto make = [device](const Scene& scene, const BakeGeometry& geometry,
                               const IntegrationSettings& settings) -> Result<std::unique_ptr<Integrator>> {
        // A bake asks for one with few rays first, for its unwrapping.
        device->beginPipelines(std::ranges::any_of(scene.materials, [](const Material& m) { return tintsLight(m); }),
                               settings.integrator == IntegratorKind::Cache);
        if (settings.fewRays) return makeEmbreeIntegrator(scene, geometry, settings);
        Error error{ErrorCode::DeviceFailed, "Embree could not build the scene (out of memory?)"};
        auto integrator =
            makeRayIntegrator(scene, geometry, settings, gpuKernels(device, embreeKernels(settings.isa), error));
        if (integrator == nullptr) return error;
        return integrator;
    };
    const auto identity = [device](InstructionSet set) -> Result<std::string> {
        Result<std::string> cpu = embreeIntegrators().identity(set); // it does a part
        if (!cpu) return cpu;
        return device->identity() + "-" + *cpu;
    };
    return {make, identity, std::make_shared<const IntegratorFactory>(embreeIntegrators()),
            [device](const DenoiserTexels& texels, std::span<Signals> components) {
                return denoiseOnDevice(*device, texels, components);
            },
            [device] { return device->device().memory().peakBytes(); }};
}

} // namespace halflight
