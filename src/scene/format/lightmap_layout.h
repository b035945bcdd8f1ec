#pragma once
// How a file holds lightmap coordinates. A mesh of one object has its final coordinates on the page in its vertices. A
// mesh of several fills 0…1 in both directions, and the objects' rectangles lie inside 0…1. So all of them survive
// being stored as 16-bit fractions.

#include "scene/document/document.h"

#include <map>
#include <vector>

namespace halflight {

/// From the scene's lightmap coordinates to those of the file: scale * uv + offset.
struct FileLayout {
    vec2 scale{1.0f};
    vec2 offset{0.0f};

    [[nodiscard]] vec2 coordinate(vec2 uv) const;
    [[nodiscard]] LightmapBinding binding(LightmapBinding binding) const;
};

/// By Scene::meshes. A set of the source that textures read too stays as it is.
std::vector<FileLayout> fileLayouts(const Scene& scene, const SourceDocument& source);

/// Width and height of a texel in lightmap coordinates of the file's meshes, the longer 1, where they differ: an
/// earlier bake stretched the layout to fill 0…1. By index of the file's meshes.
std::map<int, vec2> stretchedLayouts(const SourceDocument& document);

} // namespace halflight
