#pragma once
#include "scene/document/document.h"

namespace halflight {

/// Takes lightmap coordinates that stand in for missing texture coordinates out of a document that has just been
/// parsed: an earlier bake wrote them for other loaders. HALFLIGHT_* extensions stay: they are read, and replaced when
/// the document is written again.
void stripEarlierBake(SourceDocument& document);

} // namespace halflight
