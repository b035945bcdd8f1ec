#pragma once
#include "scene/document/patcher.h"

#include "halflight/scene/optimize.h"

namespace halflight {

/// Textures of materials as lossy WebP, masks and directions of the bake as lossless WebP, each where that is smaller;
/// lightmaps with fewer bits. Tells `report` of their bytes.
Status optimizePictures(DocumentPatcher& patcher, const SourceDocument& source, const OptimizeOptions& options,
                        OptimizeReport& report);

} // namespace halflight
