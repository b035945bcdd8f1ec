#include "halflight/bake/integrator.h"

namespace halflight {
namespace {

Error withoutComponents()
{
    return {ErrorCode::Unsupported,
            "light groups are not baked on this device: bake on the processor, or with --groups off", ""};
}

} // namespace

Status PreparedLightmap::irradianceByComponent(const TexelRequest& /*request*/, std::span<IrradianceEstimate> /*out*/,
                                               std::span<IrradianceEstimate> /*components*/,
                                               const Progress& /*progress*/)
{
    return withoutComponents();
}

Status Integrator::probesByComponent(std::span<const vec3> /*positions*/, std::span<const uint32_t> /*which*/,
                                     int /*samples*/, std::span<ProbeEstimate> /*out*/,
                                     std::span<SphericalHarmonicsL2> /*components*/, const Progress& /*progress*/)
{
    return withoutComponents();
}

Status Integrator::radianceAroundByComponent(vec3 /*position*/,
                                             std::span<const std::span<const ImageRgb32f>> /*lightmaps*/, int /*rays*/,
                                             std::span<ImageRgb32f> /*maps*/, const Progress& /*progress*/)
{
    return withoutComponents();
}

} // namespace halflight
