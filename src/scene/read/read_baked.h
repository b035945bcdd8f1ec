#pragma once
// What readBakedScene() does once the document is loaded.

#include "halflight/scene/gltf.h"
#include "scene/document/document.h"

namespace halflight {

/// Version of HALFLIGHT_mixed_lighting that is written, and read.
constexpr int kFormatVersion = 2;

/// isBaked is false for a document without HALFLIGHT_mixed_lighting.
Result<BakedScene> bakedFromDocument(std::shared_ptr<const SourceDocument> source, const ReadOptions& options);

} // namespace halflight
