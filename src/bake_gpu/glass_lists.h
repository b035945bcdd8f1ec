#pragma once
// What a device needs of glass that gives light a colour.

#include "bake_gpu/layout.h"
#include "transport/trace/ray_scene.h"

#include <vector>

namespace halflight {

/// Lists for shaders; empty where no glass has a colour.
struct GlassLists {
    std::vector<shading::GpuGlass> glass;
    std::vector<uint32_t> numbers; ///< by masked triangle, its number in `triangles`; shading::kNone of those not there
    std::vector<shading::GpuGlassTriangle> triangles;

    /// A masked triangle with its number among them, in ascending order. `triangle` is one of the bake's.
    void addTriangle(const RayScene& scene, uint32_t triangle, uint32_t masked, const TransportMaterial& material);
};

/// Without its textures.
shading::GpuGlass glassOf(const TransportMaterial& material);

} // namespace halflight
