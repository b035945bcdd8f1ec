#pragma once
// What of a scene a bake depends on, as hashes that the baked file keeps: whoever reads the file can tell what was
// changed since. Colour and intensity of mixed lights are left out where they may change at run time.

#include "halflight/base/hash.h"
#include "halflight/scene/scene.h"

#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Of each material's parts that a bake sees, textures included; one more at the end for the default material.
std::vector<Hash128> materialHashes(const Scene& scene);
/// The one of `hashes` (materialHashes()) for MeshPart::material, which is -1 for the default material.
const Hash128& materialHash(std::span<const Hash128> hashes, int material);

/// Of all that a bake sees of a light: shape, pose, mode, colour and intensity.
Hash128 lightHash(const Light& light);

/// Of everything that a bake and the file it writes depend on: the source document, its buffers and pictures, and all
/// settings as they were applied.
Hash128 contentHash(const Scene& scene);

class SceneFingerprints {
public:
    /// Hashes the materials, textures included, once. `scene` outlives this.
    explicit SceneFingerprints(const Scene& scene);

    /// Of a node's objects (several for instances): shape, place, materials, part in the bake. Vertices that are copies
    /// of one another do not change it. Dynamic objects have an empty one: no bake sees them.
    [[nodiscard]] std::string ofObjects(std::span<const Object* const> objects) const;
    /// Of a light that is baked or mixed, but not its pose, which movedSinceBake() judges; of colour and intensity only
    /// where directLightIsBaked(). Empty for realtime lights.
    [[nodiscard]] std::string ofLight(const Light& light) const;
    /// Of the sky and the number of static objects and baked lights.
    [[nodiscard]] std::string ofScene() const;

    /// False when a texture has no pixels (not decoded): hashes then say nothing.
    [[nodiscard]] bool complete() const { return complete_; }

private:
    const Scene& scene_;
    bool complete_ = true;
    std::vector<Hash128> materials_;
};

} // namespace halflight
