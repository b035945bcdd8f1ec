#include "halflight/bake_cpu/embree_integrator.h"

#include "bake_cpu/trace/embree_device.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "transport/ray_integrator.h"

namespace halflight {

Result<std::unique_ptr<Integrator>> makeEmbreeIntegrator(const Scene& scene, const BakeGeometry& geometry,
                                                         const IntegrationSettings& settings)
{
    const RTCBuildQuality quality = settings.fewRays ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_HIGH;
    auto integrator = makeRayIntegrator(scene, geometry, settings, embreeKernels(settings.isa, quality));
    if (integrator == nullptr)
        return Error{ErrorCode::DeviceFailed, "Embree could not build the scene (out of memory?)"};
    return integrator;
}

IntegratorFactory embreeIntegrators()
{
    return {makeEmbreeIntegrator, embree::identityOf};
}

} // namespace halflight
