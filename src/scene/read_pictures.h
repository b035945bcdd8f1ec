#pragma once
#include "scene/document.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// Lightmaps, directions and masks of the root extension.
Status readPictures(const SourceDocument& document, const Json& root, BakedScene& baked);

} // namespace halflight
