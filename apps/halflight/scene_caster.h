#pragma once
// Rays against a scene, for few of them: triangles are tried one by one behind each object's bounds.

#include "halflight/scene/scene.h"

#include <vector>

namespace halflight::cli {

struct SceneHit {
    float distance = kInfinity;
    bool front = false;       ///< on a front face, or on a double-sided surface
    bool doubleSided = false; ///< on a double-sided surface

    explicit operator bool() const { return distance < kInfinity; }
};

/// Panes of glass are left out: a view goes through them. The scene outlives it.
class SceneCaster {
public:
    explicit SceneCaster(const Scene& scene);

    [[nodiscard]] SceneHit cast(vec3 origin, vec3 direction) const;

private:
    struct Item {
        const MeshPart* part;
        Bounds bounds; // in the object's space
        mat4 objectFromWorld;
    };
    void castAtPart(const Item& item, vec3 o, vec3 d, SceneHit& hit) const;

    const Scene& scene_;
    std::vector<Item> items_;
};

} // namespace halflight::cli
