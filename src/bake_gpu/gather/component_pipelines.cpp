#include "bake_gpu/gather/component_pipelines.h"

#include "shaders/bake/components/emitted.comp.h"
#include "shaders/bake/components/gathered.comp.h"
#include "shaders/bake/components/paths.comp.h"

namespace halflight {

ComponentPipelines::ComponentPipelines(const gpu::Device& device)
{
    gathered = {device, bake_components_gathered_comp, sizeof(GatherPush)};
    paths = {device, bake_components_paths_comp, sizeof(OpenRangePush)};
    emitted = {device, bake_components_emitted_comp, sizeof(GatherPush)};
}

std::vector<std::span<const uint32_t>> ComponentPipelines::shaders()
{
    return {bake_components_gathered_comp, bake_components_paths_comp, bake_components_emitted_comp};
}

} // namespace halflight
