#include "bake_gpu/radiosity/radiosity_pipelines.h"

#include "bake_gpu/bake_device.h"

#include "shaders/bake/nearest.rahit.h"
#include "shaders/bake/nearest.rchit.h"
#include "shaders/bake/nearest.rmiss.h"
#include "shaders/bake/radiosity/direct.rgen.h"
#include "shaders/bake/radiosity/direct.rgen.tinted.h"
#include "shaders/bake/radiosity/factors.rgen.h"
#include "shaders/bake/radiosity/factors.rgen.tinted.h"
#include "shaders/bake/radiosity/occluders.rgen.h"
#include "shaders/bake/radiosity/points.comp.h"
#include "shaders/bake/transmittance.rahit.h"
#include "shaders/bake/transmittance.rahit.tinted.h"
#include "shaders/bake/transmittance.rmiss.h"
#include "shaders/bake/transmittance.rmiss.tinted.h"

namespace halflight {

RadiosityPipelines::RadiosityPipelines(gpu::Device& device, bool tinted)
{
    const gpu::RayShaders::Ends nearest{bake_nearest_rmiss, bake_nearest_rchit, bake_nearest_rahit};
    const gpu::RayShaders::Ends gray{bake_transmittance_rmiss, {}, bake_transmittance_rahit};
    const gpu::RayShaders::Ends colored{bake_transmittance_rmiss_tinted, {}, bake_transmittance_rahit_tinted};
    points = {device, bake_radiosity_points_comp, 2 * sizeof(VkDeviceAddress)};
    occluders = {device, {bake_radiosity_occluders_rgen, nearest}, sizeof(TracePush)};
    if (tinted) {
        factors = {device, {bake_radiosity_factors_rgen_tinted, nearest, colored}, sizeof(TracePush)};
        direct = {device, {bake_radiosity_direct_rgen_tinted, nearest, colored}, sizeof(TracePush)};
    } else {
        factors = {device, {bake_radiosity_factors_rgen, nearest}, sizeof(TracePush)};
        direct = {device, {bake_radiosity_direct_rgen, nearest, gray}, sizeof(TracePush)};
    }
}

std::vector<std::span<const uint32_t>> RadiosityPipelines::shaders()
{
    return {bake_radiosity_points_comp, bake_radiosity_occluders_rgen,      bake_radiosity_factors_rgen,
            bake_radiosity_direct_rgen, bake_radiosity_factors_rgen_tinted, bake_radiosity_direct_rgen_tinted};
}

} // namespace halflight
