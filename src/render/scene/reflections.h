#pragma once
// Reflection probes on the GPU.

#include "gpu/resources.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// One black texel and one probe that is never read, where a file has none.
struct ReflectionTextures {
    gpu::Buffer probes; ///< GpuReflectionProbe
    gpu::Image picture;
    int count = 0;
    int size = 0;          ///< ReflectionSet::size
    float unitNits = 1.0f; ///< ReflectionSet::unitNits
};
ReflectionTextures uploadReflections(gpu::Device& device, gpu::Uploader& uploader, const ReflectionSet& set);

/// Another picture of the same probes, which no frame in flight reads.
void updateReflections(gpu::Uploader& uploader, const ReflectionSet& set, ReflectionTextures& textures);

/// GpuFrame::reflections.
vec4 reflectionsOfFrame(const ReflectionTextures& textures);

} // namespace halflight
