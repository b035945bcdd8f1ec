#include "bake_gpu/gather/emitter_pipelines.h"

#include "shaders/bake/emitters/cuts.comp.h"
#include "shaders/bake/emitters/hits.comp.h"
#include "shaders/bake/emitters/rays.comp.h"
#include "shaders/bake/emitters/shares.comp.h"
#include "shaders/bake/emitters/sums.comp.h"

namespace halflight {

EmitterPipelines::EmitterPipelines(const gpu::Device& device)
{
    constexpr uint32_t kPush = 2 * sizeof(VkDeviceAddress);
    cuts = {device, bake_emitters_cuts_comp, kPush};
    hits = {device, bake_emitters_hits_comp, kPush};
    shares = {device, bake_emitters_shares_comp, kPush};
    rays = {device, bake_emitters_rays_comp, kPush};
    sums = {device, bake_emitters_sums_comp, kPush};
}

std::vector<std::span<const uint32_t>> EmitterPipelines::shaders()
{
    return {bake_emitters_cuts_comp, bake_emitters_hits_comp, bake_emitters_shares_comp, bake_emitters_rays_comp,
            bake_emitters_sums_comp};
}

} // namespace halflight
