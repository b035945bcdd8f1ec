#pragma once
#include "scene/document/document.h"

namespace halflight {

/// Takes what an earlier bake wrote for other loaders out of a document that has just been parsed: materials cloned for
/// MOZ_lightmap, their textures and images, and lightmap coordinates that stand in for missing texture coordinates.
/// HALFLIGHT_* extensions stay: they are read, and replaced when the document is written again.
void stripEarlierBake(SourceDocument& document);

} // namespace halflight
