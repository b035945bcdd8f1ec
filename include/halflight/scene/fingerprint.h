#pragma once
// What of a scene a bake depends on, as hashes: equal ones let a bake take what an earlier one has found.

#include "halflight/base/hash.h"
#include "halflight/scene/scene.h"

#include <span>
#include <vector>

namespace halflight {

/// Of each material's parts that a bake sees, textures included; one more at the end for the default material.
std::vector<Hash128> materialHashes(const Scene& scene);
/// The one of `hashes` (materialHashes()) for MeshPart::material, which is -1 for the default material.
const Hash128& materialHash(std::span<const Hash128> hashes, int material);

/// Of all that a bake sees of a light: shape, pose, mode, colour and intensity.
Hash128 lightHash(const Light& light);

/// Adds the sky as a bake sees it.
void addSky(Hasher& hasher, const Sky& sky);

/// Of the meshes, their materials and the objects: without lights and the sky.
Hash128 surfacesHash(const Scene& scene);

/// Of everything that a bake and the file it writes depend on: the source document, its buffers and pictures, and all
/// settings as they were applied.
Hash128 contentHash(const Scene& scene);

} // namespace halflight
