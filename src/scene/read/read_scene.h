#pragma once
#include "halflight/scene/gltf.h"
#include "scene/document/document.h"

namespace halflight {

/// readScene() on a document that is loaded already.
Result<Scene> sceneFromDocument(std::shared_ptr<const SourceDocument> document, const ReadOptions& options);

} // namespace halflight
