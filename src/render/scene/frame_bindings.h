#pragma once
#include "gpu/device.h"
#include "gpu/pipeline.h"

#include <vector>

namespace halflight {

/// Bindings of the one descriptor set, by number as in gpu_layout.h. The last one's count is the most textures a scene
/// may have on this device.
std::vector<gpu::Binding> frameBindings(const gpu::Device& device);

} // namespace halflight
