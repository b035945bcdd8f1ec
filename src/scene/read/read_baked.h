#pragma once
// What readBakedScene() does once the document is loaded.

#include "halflight/scene/gltf.h"
#include "scene/document/document.h"

namespace halflight {

/// Versions of HALFLIGHT_mixed_lighting that are written, and read: the second is of files with several mask layers.
constexpr int kFormatVersion = 2;
constexpr int kLayeredVersion = 3;

inline bool isFormatVersion(const Json& version)
{
    return version == kFormatVersion || version == kLayeredVersion;
}

/// isBaked is false for a document without HALFLIGHT_mixed_lighting.
Result<BakedScene> bakedFromDocument(std::shared_ptr<const SourceDocument> source, const ReadOptions& options);

} // namespace halflight
