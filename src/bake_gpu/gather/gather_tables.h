#pragma once
// What shaders of the gather and of paths read of a scene, by address.

#include "bake_gpu/gather/gather_layout.h"
#include "bake_gpu/gpu_scene.h"
#include "transport/sample/path_tracer.h"

#include <vector>

namespace halflight {

/// Tables in shaders/bake/gather.glsl.
struct GatherAddresses {
    VkDeviceAddress scene, pattern, radii, angles, surfaces, normals, elements, patches, guideOfPatch, sourcesOfGuide,
        guides, entries, cumulative, clusters, triangles, sourceMasks, bins, members, picture, paths;
    shading::GpuGatherConstants all;
};

/// Sets what paths read of them besides `paths`: the scene, normals and the sky. Uploads them to `buffers`. Throws
/// gpu::Failure.
void addScene(gpu::Device& device, const GpuScene& scene, const PathTracer& paths, std::vector<gpu::Buffer>& buffers,
              GatherAddresses& to);

} // namespace halflight
