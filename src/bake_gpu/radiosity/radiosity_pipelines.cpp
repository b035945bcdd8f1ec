#include "bake_gpu/radiosity/radiosity_pipelines.h"

#include "bake_gpu/bake_device.h"
#include "bake_gpu/ray_ends.h"

#include "shaders/bake/radiosity/direct.rgen.h"
#include "shaders/bake/radiosity/direct.rgen.tinted.h"
#include "shaders/bake/radiosity/factors.rgen.h"
#include "shaders/bake/radiosity/factors.rgen.tinted.h"
#include "shaders/bake/radiosity/occluders.rgen.h"
#include "shaders/bake/radiosity/points.comp.h"

namespace halflight {

RadiosityPipelines::RadiosityPipelines(gpu::Device& device, bool tinted)
{
    points = {device, bake_radiosity_points_comp, 2 * sizeof(VkDeviceAddress)};
    occluders = {device, {bake_radiosity_occluders_rgen, nearestEnds()}, sizeof(TracePush)};
    if (tinted) {
        factors = {device, {bake_radiosity_factors_rgen_tinted, nearestEnds(), throughEnds(true)}, sizeof(TracePush)};
        direct = {device, {bake_radiosity_direct_rgen_tinted, nearestEnds(), throughEnds(true)}, sizeof(TracePush)};
    } else {
        factors = {device, {bake_radiosity_factors_rgen, nearestEnds()}, sizeof(TracePush)};
        direct = {device, {bake_radiosity_direct_rgen, nearestEnds(), throughEnds(false)}, sizeof(TracePush)};
    }
}

std::vector<std::span<const uint32_t>> RadiosityPipelines::shaders()
{
    return {bake_radiosity_points_comp, bake_radiosity_occluders_rgen,      bake_radiosity_factors_rgen,
            bake_radiosity_direct_rgen, bake_radiosity_factors_rgen_tinted, bake_radiosity_direct_rgen_tinted};
}

} // namespace halflight
