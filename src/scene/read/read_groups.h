#pragma once
// Light groups of a baked file.

#include "halflight/scene/baked_scene.h"
#include "scene/document/document.h"

namespace halflight {

/// Names, weights and members; pages and probes follow.
Status readGroups(const Json& root, BakedScene& baked);
/// The radiance of the groups at the bake's probes, which are read.
Status readGroupProbes(const SourceDocument& document, const Json& root, BakedScene& baked);

/// Their pictures of the bake's reflection probes, which are read.
Status readGroupReflections(const SourceDocument& document, const Json& root, BakedScene& baked);

} // namespace halflight
