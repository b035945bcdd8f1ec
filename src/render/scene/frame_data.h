#pragma once
// A frame's plan as the structures that shaders read.

#include "halflight/render/renderer.h"
#include "render/scene/gpu_layout.h"
#include "render/scene/gpu_scene.h"

#include <vector>

namespace halflight {

shading::GpuFrame gpuFrame(const GpuScene& scene, const FrameView& view, const RenderSettings& settings,
                           const FramePlan& plan);
std::vector<shading::GpuLight> gpuLights(const Scene& scene, const FramePlan& plan, const ShadowSettings& shadows);
std::vector<shading::GpuTile> gpuTiles(const FramePlan& plan);

} // namespace halflight
