#pragma once
// Which objects get texels, and which of them can share a layout.

#include "halflight/scene/scene.h"
#include "unwrap/surface/surface.h"

#include <string>
#include <vector>

namespace halflight::charts {

/// Objects that share a layout: those with one mesh at (nearly) one scale, and the instances of an
/// EXT_mesh_gpu_instancing node at any scale, since the node has one mesh.
struct LayoutGroup {
    int mesh = -1;              ///< index into the scene's meshes
    std::vector<int> objects;   ///< ascending
    dmat3 worldFromObject{1.0}; ///< linear part of the first or largest object's transform, times lightmapScale
};

/// Groups of all objects that are to be lightmapped, by their first object. Objects that cannot be (a transform that is
/// not finite, a mesh without triangles) are left out, with a warning.
std::vector<LayoutGroup> groupObjects(const Scene& scene, std::vector<std::string>& warnings);

} // namespace halflight::charts
